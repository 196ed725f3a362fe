// Vectors, quaternions and symmetric 3x3 matrices of the rod references, for float and double. The
// operations have the order of kernels/common/quaternion.hlsli, so that float results can be held
// against a kernel's bit by bit.
#pragma once

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <limits>
#include <type_traits>

namespace pelage::reference {

/// 1 / sqrt(x) for x in 1e-30..1e38; in float with the operations of kernels/common/roots.hlsli.
template <class Real>
Real inverseRoot(Real x) {
  if constexpr (std::is_same_v<Real, float>) {
    float y = std::bit_cast<float>(0x5f375a86u - (std::bit_cast<uint32_t>(x) >> 1));
    for (int i = 0; i < 4; ++i) {
      const float missing = 1.0f - (x * y) * y;
      y = y + (y * 0.5f) * missing;
    }
    return y;
  } else {
    return Real(1) / std::sqrt(x);
  }
}

/// sqrt(x); in float with the operations of kernels/common/roots.hlsli.
template <class Real>
Real squareRoot(Real x) {
  if constexpr (std::is_same_v<Real, float>) {
    if (!(x <= std::numeric_limits<float>::max())) return x;
    if (!(x >= 1e-30f)) return 0.0f;
    const float y = inverseRoot(x);
    const float root = x * y;
    return root + (y * 0.5f) * (x - root * root);
  } else {
    return std::sqrt(x);
  }
}

/// In float with the upper 21 bits, rounded.
template <class Real>
Real shortened(Real x) {
  if constexpr (std::is_same_v<Real, float>) {
    return std::bit_cast<float>((std::bit_cast<uint32_t>(x) + 0x400u) & 0xfffff800u);
  } else {
    return x;
  }
}

template <class Real>
struct Vector3 {
  Real x = 0, y = 0, z = 0;

  constexpr Vector3() = default;
  constexpr Vector3(Real px, Real py, Real pz) : x(px), y(py), z(pz) {}
  template <class Other>
  explicit constexpr Vector3(const Vector3<Other>& o)
      : x(static_cast<Real>(o.x)), y(static_cast<Real>(o.y)), z(static_cast<Real>(o.z)) {}

  friend constexpr Vector3 operator+(const Vector3& a, const Vector3& b) {
    return {a.x + b.x, a.y + b.y, a.z + b.z};
  }
  friend constexpr Vector3 operator-(const Vector3& a, const Vector3& b) {
    return {a.x - b.x, a.y - b.y, a.z - b.z};
  }
  friend constexpr Vector3 operator-(const Vector3& a) { return {-a.x, -a.y, -a.z}; }
  friend constexpr Vector3 operator*(const Vector3& a, Real s) {
    return {a.x * s, a.y * s, a.z * s};
  }
  Vector3& operator+=(const Vector3& b) { return *this = *this + b; }
  Vector3& operator-=(const Vector3& b) { return *this = *this - b; }
};

template <class Real>
constexpr Real dot(const Vector3<Real>& a, const Vector3<Real>& b) {
  return a.x * b.x + a.y * b.y + a.z * b.z;
}
template <class Real>
constexpr Vector3<Real> cross(const Vector3<Real>& a, const Vector3<Real>& b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
template <class Real>
Real length(const Vector3<Real>& a) {
  return squareRoot(dot(a, a));
}
template <class Real>
bool isFinite(const Vector3<Real>& a) {
  return std::isfinite(a.x) && std::isfinite(a.y) && std::isfinite(a.z);
}
/// a / |a|, or the fallback where |a|^2 is not above 1e-30.
template <class Real>
Vector3<Real> directionOr(const Vector3<Real>& a, const Vector3<Real>& fallback) {
  const Real squared = dot(a, a);
  if (!(squared > Real(1e-30))) return fallback;
  return a * inverseRoot(squared);
}

/// Rotation; the product a * b rotates by b first.
template <class Real>
struct Quaternion {
  Real x = 0, y = 0, z = 0, w = 1;

  constexpr Quaternion() = default;
  constexpr Quaternion(Real px, Real py, Real pz, Real pw) : x(px), y(py), z(pz), w(pw) {}
  constexpr Quaternion(const Vector3<Real>& v, Real pw) : x(v.x), y(v.y), z(v.z), w(pw) {}
  template <class Other>
  explicit constexpr Quaternion(const Quaternion<Other>& o)
      : x(static_cast<Real>(o.x)),
        y(static_cast<Real>(o.y)),
        z(static_cast<Real>(o.z)),
        w(static_cast<Real>(o.w)) {}

  constexpr Vector3<Real> vector() const { return {x, y, z}; }
  friend constexpr Quaternion operator*(const Quaternion& a, const Quaternion& b) {
    return {a.w * b.x + a.x * b.w + (a.y * b.z - a.z * b.y),
            a.w * b.y + a.y * b.w + (a.z * b.x - a.x * b.z),
            a.w * b.z + a.z * b.w + (a.x * b.y - a.y * b.x),
            a.w * b.w - (a.x * b.x + a.y * b.y + a.z * b.z)};
  }
};

template <class Real>
constexpr Quaternion<Real> conjugate(const Quaternion<Real>& q) {
  return {-q.x, -q.y, -q.z, q.w};
}
template <class Real>
constexpr Real dot(const Quaternion<Real>& a, const Quaternion<Real>& b) {
  return a.x * b.x + a.y * b.y + a.z * b.z + a.w * b.w;
}
/// The caller knows that q is not near zero: a product of unit quaternions, or (v, 1).
template <class Real>
Quaternion<Real> normalized(const Quaternion<Real>& q) {
  const Real inverse = inverseRoot(dot(q, q));
  return {q.x * inverse, q.y * inverse, q.z * inverse, q.w * inverse};
}
/// Of a product of quaternions that are unit to rounding: one step of Newton from 1.
template <class Real>
constexpr Quaternion<Real> polished(const Quaternion<Real>& q) {
  const Real factor = Real(1.5) - Real(0.5) * dot(q, q);
  return {q.x * factor, q.y * factor, q.z * factor, q.w * factor};
}
/// Of a product of a unit quaternion and (v, 1) with |v| <= 1/2.
template <class Real>
Quaternion<Real> normalizedTurned(const Quaternion<Real>& q) {
  const Real squared = dot(q, q), e = squared - Real(1);
  Real y = Real(1) + e * (e * (Real(0.36183913) - e * Real(0.21267281)) - Real(0.49948119));
  const int steps = std::is_same_v<Real, float> ? 1 : 3;
  for (int i = 0; i < steps; ++i) y = y + (y * Real(0.5)) * (Real(1) - (squared * y) * y);
  return {q.x * y, q.y * y, q.z * y, q.w * y};
}
/// Whether q is a unit quaternion but for its rounding, and no NaN.
template <class Real>
bool isUnit(const Quaternion<Real>& q) {
  const Real squared = dot(q, q);
  return squared >= Real(0.25) && squared < Real(4);
}
template <class Real>
constexpr Vector3<Real> rotate(const Quaternion<Real>& q, const Vector3<Real>& v) {
  const Vector3<Real> twice = cross(q.vector(), v) * Real(2);
  return v + (twice * q.w + cross(q.vector(), twice));
}
/// Unit tangent of an edge: its frame's x axis.
template <class Real>
constexpr Vector3<Real> axisX(const Quaternion<Real>& q) {
  return {Real(1) - Real(2) * (q.y * q.y + q.z * q.z), Real(2) * (q.x * q.y + q.w * q.z),
          Real(2) * (q.x * q.z - q.w * q.y)};
}
template <class Real>
Quaternion<Real> axisAngle(const Vector3<Real>& unitAxis, Real angle) {
  return {unitAxis * std::sin(angle / 2), std::cos(angle / 2)};
}
/// The shortest rotation between unit vectors. Opposite vectors turn about an arbitrary axis.
template <class Real>
Quaternion<Real> rotationBetween(const Vector3<Real>& a, const Vector3<Real>& b) {
  const Real scalar = Real(1) + dot(a, b);
  if (!(scalar > Real(1e-6))) {
    const bool flat = std::abs(a.x) > std::abs(a.z);
    const Vector3<Real> axis = flat ? Vector3<Real>(-a.y, a.x, 0) : Vector3<Real>(0, -a.z, a.y);
    return normalized(Quaternion<Real>(axis, 0));
  }
  return normalized(Quaternion<Real>(cross(a, b), scalar));
}
/// Normalised linear interpolation on the shorter arc.
template <class Real>
Quaternion<Real> interpolate(const Quaternion<Real>& a, const Quaternion<Real>& b, Real t) {
  if (t <= 0) return a;
  if (t >= 1) return b;
  const Real side = dot(a, b) < 0 ? Real(-1) : Real(1);
  return normalized(Quaternion<Real>(a.x + (b.x * side - a.x) * t, a.y + (b.y * side - a.y) * t,
                                     a.z + (b.z * side - a.z) * t, a.w + (b.w * side - a.w) * t));
}

template <class Real>
struct Symmetric3 {
  Real xx = 0, xy = 0, xz = 0, yy = 0, yz = 0, zz = 0;

  Vector3<Real> column0() const { return {xx, xy, xz}; }
  Vector3<Real> column1() const { return {xy, yy, yz}; }
  Vector3<Real> column2() const { return {xz, yz, zz}; }
  Real trace() const { return xx + yy + zz; }
  friend Vector3<Real> operator*(const Symmetric3& a, const Vector3<Real>& v) {
    return {a.xx * v.x + a.xy * v.y + a.xz * v.z, a.xy * v.x + a.yy * v.y + a.yz * v.z,
            a.xz * v.x + a.yz * v.y + a.zz * v.z};
  }
  /// Adds a * u u^T, with au = a u.
  void addOuter(const Vector3<Real>& au, const Vector3<Real>& u) {
    xx = xx + au.x * u.x;
    xy = xy + au.x * u.y;
    xz = xz + au.x * u.z;
    yy = yy + au.y * u.y;
    yz = yz + au.y * u.z;
    zz = zz + au.z * u.z;
  }
  void addDiagonal(Real a) {
    xx = xx + a;
    yy = yy + a;
    zz = zz + a;
  }
};

/// Inverse of a symmetric positive definite matrix by L D L^T with pivots of at least `floor`.
template <class Real>
Symmetric3<Real> inverseOf(const Symmetric3<Real>& a, Real floor) {
  const Real i0 = Real(1) / std::max(a.xx, floor);
  const Real l10 = a.xy * i0, l20 = a.xz * i0;
  const Real i1 = Real(1) / std::max(a.yy - l10 * a.xy, floor);
  const Real a21 = a.yz - l20 * a.xy;
  const Real l21 = a21 * i1;
  const Real i2 = Real(1) / std::max(a.zz - l20 * a.xz - l21 * a21, floor);
  const Real k20 = l10 * l21 - l20;
  Symmetric3<Real> w;
  w.zz = i2;
  w.yz = -(l21 * i2);
  w.xz = k20 * i2;
  w.yy = i1 - l21 * w.yz;
  w.xy = -(l10 * i1) - l21 * w.xz;
  w.xx = i0 + l10 * l10 * i1 + k20 * w.xz;
  return w;
}

using Vector3d = Vector3<double>;
using Quaterniond = Quaternion<double>;

}  // namespace pelage::reference
