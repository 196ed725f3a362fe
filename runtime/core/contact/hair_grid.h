// Hair against hair: a grid around an object that takes in the mass and momentum of its guides, and
// gives back a force of pressure and friction (docs/contact_hair.md).
#pragma once

#include <cstdint>
#include <vector>

#include "base/rigid_move.h"
#include "passes/buffer_factory.h"
#include "passes/moved_elements.h"
#include "pelage/gpu_structs.h"
#include "pelage/pass_list.h"
#include "pelage/result.h"
#include "skinning/hair_frame.h"

namespace pelage::detail {

/// The grid of one object, and its buffers. A copy of it is what a frame is taken back to.
class HairGrid {
 public:
  /// Makes the grid, or removes it, where the settings ask for another one than there is.
  void prepare(HairFrame& frame);
  /// Adds the passes of a step of h seconds, which write the forces.
  Result<void> record(const HairFrame& frame, double h, bool reset);
  /// Call it behind the last step of a frame.
  void finish(const HairFrame& frame);
  void remove(const BufferFactory& factory);
  void move(const WorldMove& move) {
    move.point(middle_);
    move.direction(velocity_);
  }
  std::vector<MovedElements> moved(const HairFrame& frame) const {
    if (size_ == 0 || history_ == 0) return {};
    return {{vertices_, 0, frame.guideVertices(), 1, {move_rigidly::kMovesPoint}, true}};
  }

 private:
  void make(const HairFrame& frame);
  HairGridConstants constantsOf(const HairFrame& frame, Float3 middle,
                                const Vector3<double>& shifted) const;
  Result<void> addSplatPasses(const HairGridConstants& constants, BufferId positions,
                              uint64_t offset, PassList& list) const;
  Result<void> addMeasurePasses(const HairFrame& frame, PassList& list) const;

  uint32_t size_ = 0;  ///< nodes an axis; 0: there is none
  float cell_ = 0;     ///< [m]
  // The settings that it was made for:
  float cellSetting_ = 0;
  bool friction_ = false, pressure_ = false;

  float massScale_ = 0, momentumScale_ = 0;  ///< of HairGridConstants
  BufferId nodes_ = BufferId::kInvalid, vertices_ = BufferId::kInvalid;
  BufferId rest_ = BufferId::kInvalid;
  BufferId forces_ = BufferId::kInvalid;     ///< [vertex] Float4: the sum with the forces of others
  BufferId others_ = BufferId::kInvalid;     ///< these, in this frame; kInvalid: none
  BufferId bindPoses_ = BufferId::kInvalid;  ///< until the rest density has been measured
  bool measured_ = false;
  uint32_t history_ = 0;  ///< steps since the last reset, at most 2
  double step_ = 0;       ///< the last one [s]
  Float3 middle_ = {};    ///< of the object in the last frame [m]
  Float3 velocity_ = {};  ///< of that in the last frame [m/s]
};

}  // namespace pelage::detail
