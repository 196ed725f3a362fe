// Small vectors and quaternions for asset processing, with the operations in a fixed order, so that
// the numbers are the same on every machine and in the kernels.
#pragma once

#include <algorithm>
#include <cmath>

#include "pelage/types.h"

namespace pelage::detail {

template <class T>
struct Vector3 {
  T x = 0, y = 0, z = 0;

  constexpr Vector3 operator+(const Vector3& o) const { return {x + o.x, y + o.y, z + o.z}; }
  constexpr Vector3 operator-(const Vector3& o) const { return {x - o.x, y - o.y, z - o.z}; }
  constexpr Vector3 operator-() const { return {-x, -y, -z}; }
  constexpr Vector3 operator*(T s) const { return {x * s, y * s, z * s}; }
  constexpr Vector3& operator+=(const Vector3& o) { return *this = *this + o; }
  constexpr Vector3& operator-=(const Vector3& o) { return *this = *this - o; }
};

constexpr double toDouble(float x) { return static_cast<double>(x); }
constexpr Vector3<double> toVector(const Float3& v) {
  return {toDouble(v.x), toDouble(v.y), toDouble(v.z)};
}
constexpr Float3 toFloat3(const Vector3<double>& v) {
  return {static_cast<float>(v.x), static_cast<float>(v.y), static_cast<float>(v.z)};
}

template <class T>
constexpr T dot(const Vector3<T>& a, const Vector3<T>& b) {
  return a.x * b.x + a.y * b.y + a.z * b.z;
}

template <class T>
constexpr Vector3<T> cross(const Vector3<T>& a, const Vector3<T>& b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}

template <class T>
T length(const Vector3<T>& a) {
  return std::sqrt(dot(a, a));
}

/// Returns `fallback` if the vector is shorter than 1e-12.
template <class T>
Vector3<T> normalizeOr(const Vector3<T>& a, const Vector3<T>& fallback) {
  const T square = dot(a, a);
  return square > T(1e-24) ? a * (T(1) / std::sqrt(square)) : fallback;
}

template <class T>
constexpr Vector3<T> lerp(const Vector3<T>& a, const Vector3<T>& b, T t) {
  return a + (b - a) * t;
}

template <class T>
struct UnitQuaternion {
  T x = 0, y = 0, z = 0, w = 1;
};

template <class T>
UnitQuaternion<T> normalized(const UnitQuaternion<T>& q) {
  const T s = T(1) / std::sqrt(q.x * q.x + q.y * q.y + q.z * q.z + q.w * q.w + T(1e-30));
  return {q.x * s, q.y * s, q.z * s, q.w * s};
}

template <class T>
constexpr UnitQuaternion<T> operator*(const UnitQuaternion<T>& a, const UnitQuaternion<T>& b) {
  return {
      a.w * b.x + a.x * b.w + a.y * b.z - a.z * b.y, a.w * b.y + a.y * b.w + a.z * b.x - a.x * b.z,
      a.w * b.z + a.z * b.w + a.x * b.y - a.y * b.x, a.w * b.w - a.x * b.x - a.y * b.y - a.z * b.z};
}

template <class T>
constexpr Vector3<T> rotate(const UnitQuaternion<T>& q, const Vector3<T>& v) {
  const Vector3<T> u = {q.x, q.y, q.z};
  const Vector3<T> t = cross(u, v) * T(2);
  return v + t * q.w + cross(u, t);
}

template <class T>
constexpr Vector3<T> rotateInverse(const UnitQuaternion<T>& q, const Vector3<T>& v) {
  return rotate(UnitQuaternion<T>{-q.x, -q.y, -q.z, q.w}, v);
}

/// Image of the x axis.
template <class T>
constexpr Vector3<T> axisX(const UnitQuaternion<T>& q) {
  return {T(1) - T(2) * (q.y * q.y + q.z * q.z), T(2) * (q.x * q.y + q.w * q.z),
          T(2) * (q.x * q.z - q.w * q.y)};
}

/// Returns the shortest rotation from unit vector a to unit vector b: the quaternion (a x b, 1 +
/// a.b), normalized, which needs no angle and so keeps small bends. If the two are opposite (within
/// a quarter of a degree), the axis is not defined; it is then any one perpendicular to a.
template <class T>
UnitQuaternion<T> shortestArc(const Vector3<T>& a, const Vector3<T>& b) {
  const T real = T(1) + dot(a, b);
  if (real < T(1e-5)) {
    const bool alongZ = std::abs(a.x) + std::abs(a.y) < T(0.1);
    return normalized(alongZ ? UnitQuaternion<T>{T(0), -a.z, a.y, T(0)}
                             : UnitQuaternion<T>{-a.y, a.x, T(0), T(0)});
  }
  const Vector3<T> axis = cross(a, b);
  return normalized(UnitQuaternion<T>{axis.x, axis.y, axis.z, real});
}

}  // namespace pelage::detail
