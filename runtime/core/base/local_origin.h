// The origin of an object's coordinates, in a world whose own origin may be shifted.
#pragma once

#include <cmath>
#include <cstddef>
#include <vector>

#include "base/vector3.h"
#include "pelage/types.h"

namespace pelage::detail {

/// The origin follows if its object is farther from it than this [m]: the rounding of a state grows
/// with the distance, and a new origin costs a pass over the state.
inline constexpr float kOriginRange = 1.5f;

/// The origin of an object's coordinates. It is stored relative to the first world, before any
/// Scene::shiftOrigin(), in doubles, so that a shift changes neither the difference of two origins
/// nor anything relative to one.
struct LocalOrigin {
  Vector3<double> metres = {};  ///< whole meters in the first world
  Vector3<double> shifted =
      {};  ///< of the scene: what was at p in the first world is at p - shifted

  /// Returns the origin in the current world [m].
  Float3 world() const { return toFloat3(metres - shifted); }
  /// Returns a position of the current world relative to the origin.
  Float3 relative(const Float3& p) const { return toFloat3(toVector(p) - (metres - shifted)); }
  /// Returns a position relative to the origin in the current world.
  Float3 toWorld(const Float3& p) const { return toFloat3(toVector(p) + (metres - shifted)); }
  /// Returns the origin at the whole meters next to a position of the current world.
  LocalOrigin near(const Float3& p) const { return nearDouble(toVector(p)); }
  LocalOrigin nearDouble(const Vector3<double>& p) const {
    const Vector3<double> at = p + shifted;
    return {{std::round(at.x), std::round(at.y), std::round(at.z)}, shifted};
  }
  bool isAt(const LocalOrigin& other) const {
    return metres.x == other.metres.x && metres.y == other.metres.y && metres.z == other.metres.z;
  }
};

/// Returns what to add to positions relative to the first origin to make them relative to the
/// second.
inline Float3 between(const LocalOrigin& from, const LocalOrigin& to) {
  return toFloat3(from.metres - to.metres);
}

/// Moves coordinates that an engine has set, repeatedly, without accumulating rounding while the
/// world's origin is far away: a value that returns to its old position has its old bits.
class ShiftedFloats {
 public:
  /// \param value moves by `by`. Call it for the same values in the same order each time, between
  /// begin() and end(); a value that was set anew since starts anew.
  void shift(float& value, double by) {
    if (next_ == exact_.size()) exact_.push_back(static_cast<double>(value));
    double& exact = exact_[next_++];
    // Also for NaN.
    if (!(static_cast<float>(exact) == value)) exact = static_cast<double>(value);
    exact += by;
    value = static_cast<float>(exact);
  }
  void shift(Float3& p, const Vector3<double>& by) {
    shift(p.x, by.x);
    shift(p.y, by.y);
    shift(p.z, by.z);
  }
  void shift(AffineTransform& bone, const Vector3<double>& by) {
    shift(bone.rows[0].w, by.x);
    shift(bone.rows[1].w, by.y);
    shift(bone.rows[2].w, by.z);
  }
  void begin() { next_ = 0; }
  void end() { exact_.resize(next_); }

 private:
  std::vector<double> exact_;
  size_t next_ = 0;
};

}  // namespace pelage::detail
