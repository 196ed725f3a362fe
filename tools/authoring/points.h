// Points of assets, in double precision and in range. The operations have a fixed order, so that
// numbers are the same on every machine.
#pragma once

#include <cmath>

#include "pelage/hair_asset.h"
#include "pelage/types.h"

namespace pelage::detail {

struct Vector {
  double x = 0, y = 0, z = 0;

  constexpr Vector operator+(const Vector& v) const { return {x + v.x, y + v.y, z + v.z}; }
  constexpr Vector operator-(const Vector& v) const { return {x - v.x, y - v.y, z - v.z}; }
  constexpr Vector operator-() const { return {-x, -y, -z}; }
  constexpr Vector operator*(double s) const { return {x * s, y * s, z * s}; }
  constexpr Vector& operator+=(const Vector& v) { return *this = *this + v; }
  constexpr Vector& operator-=(const Vector& v) { return *this = *this - v; }
};

inline Vector vectorOf(const Float3& p) { return {double{p.x}, double{p.y}, double{p.z}}; }
inline Vector vectorOf(const Float4& p) { return {double{p.x}, double{p.y}, double{p.z}}; }
inline Float3 toFloat3(const Vector& v) {
  return {static_cast<float>(v.x), static_cast<float>(v.y), static_cast<float>(v.z)};
}

constexpr double dot(const Vector& a, const Vector& b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
constexpr Vector cross(const Vector& a, const Vector& b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
inline double length(const Vector& v) { return std::sqrt(dot(v, v)); }
constexpr Vector lerp(const Vector& a, const Vector& b, double t) { return a + (b - a) * t; }

/// The unit vector; zero if `v` is shorter than 1e-12.
inline Vector unitOrZero(const Vector& v) {
  const double square = dot(v, v);
  return square > 1e-24 ? v * (1 / std::sqrt(square)) : Vector{};
}

/// Whether a point is finite and within kMaxCoordinate.
inline bool isCoordinate(const Float3& p) {
  return std::abs(p.x) <= kMaxCoordinate && std::abs(p.y) <= kMaxCoordinate &&
         std::abs(p.z) <= kMaxCoordinate;
}

}  // namespace pelage::detail
