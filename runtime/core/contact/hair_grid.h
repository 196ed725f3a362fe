// Hair against hair: a grid around an object that takes in the mass and momentum of its guides, and
// gives back a force of pressure and friction (docs/contact_hair.md).
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "assets/groom.h"
#include "base/local_origin.h"
#include "base/rigid_move.h"
#include "passes/moved_elements.h"
#include "passes/room_buffers.h"
#include "pelage/gpu_structs.h"
#include "pelage/pass_list.h"
#include "pelage/result.h"
#include "pelage/simulation_settings.h"
#include "skinning/bone_bounds.h"

namespace pelage::detail {

/// The object that a grid is of, in a frame.
struct GridHair {
  const std::string& name;
  const Groom& groom;
  std::span<const BoneBounds> bounds;
  std::span<const AffineTransform> bones;
  float deviation = 0;      ///< of roots from where the bones put the bounds [m]
  Vector3<double> shifted;  ///< of the world that the bones are in
  BufferId positions = BufferId::kInvalid;
  BufferId otherForces = BufferId::kInvalid;  ///< that the grid's are added to; kInvalid: none
  const HairContactSettings& settings;
};

/// The grid of one object, and its buffers. A copy of it is what a frame is taken back to.
class HairGrid {
 public:
  /// Makes the grid, or removes it, where the settings ask for another one than there is.
  /// \param on  the solver takes forces of hair against hair
  void prepare(const GridHair& hair, bool on, const RoomBuffers& room);
  /// Adds the passes of a step of h seconds, which write forces().
  Result<void> record(const GridHair& hair, double h, bool reset, PassList& list);
  /// Call it at the end of a frame of so many seconds.
  void finish(const GridHair& hair, double seconds);
  void remove(const RoomBuffers& room);
  /// Leaves the grid alone in a list that only poses the hair.
  void pause() { size_ = 0; }

  /// [vertex] Float4: the sum with the other forces; kInvalid where there is no grid.
  BufferId forces() const { return forces_; }
  /// [vertex] Float4: the positions that it goes on from; kInvalid where it does not.
  BufferId before() const { return size_ > 0 && history_ > 0 ? vertices_ : BufferId::kInvalid; }
  void shift(ShiftedFloats& floats, const Vector3<double>& by) { floats.shift(middle_, by); }
  /// Moves what it knows of the object by a rigid motion in the world.
  void move(const RigidMove& move) {
    middle_ = toFloat3(move(toVector(middle_)));
    velocity_ = toFloat3(rotate(move.rotation, toVector(velocity_)));
  }
  /// What a rigid motion of the object moves on the GPU.
  std::vector<MovedElements> moved(uint64_t vertices) const {
    if (before() == BufferId::kInvalid) return {};
    return {{vertices_, 0, vertices, 1, {move_rigidly::kMovesPoint}, true}};
  }

 private:
  HairGridConstants constantsOf(const GridHair& hair, Float3 middle,
                                const Vector3<double>& shifted) const;
  Result<void> addSplatPasses(const HairGridConstants& constants, BufferId positions,
                              uint64_t offset, PassList& list) const;
  Result<void> addMeasurePasses(const GridHair& hair, PassList& list) const;

  uint32_t size_ = 0;  ///< nodes an axis; 0: there is none
  float cell_ = 0;     ///< [m]
  // What it was made for.
  float cellSetting_ = 0;
  bool friction_ = false, pressure_ = false;

  float massScale_ = 0, momentumScale_ = 0;  ///< of HairGridConstants
  BufferId nodes_ = BufferId::kInvalid, vertices_ = BufferId::kInvalid;
  BufferId rest_ = BufferId::kInvalid, forces_ = BufferId::kInvalid;
  BufferId bindPoses_ = BufferId::kInvalid;  ///< until the rest density has been measured
  bool measured_ = false;
  uint32_t history_ = 0;  ///< steps since the last reset, at most 2
  double step_ = 0;       ///< the last one [s]
  Float3 middle_ = {};    ///< of the object in the last frame [m]
  Float3 velocity_ = {};  ///< of that in the last frame [m/s]
};

}  // namespace pelage::detail
