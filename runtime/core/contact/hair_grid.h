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

/// A grid, and the settings that it was made for.
struct GridShape {
  uint32_t size = 0;  ///< nodes an axis; 0: there is none
  float cell = 0;     ///< [m]
  float cellSetting = 0;
  bool friction = false, pressure = false;
  float massScale = 0, momentumScale = 0;  ///< of HairGridConstants
  uint64_t nodes() const { return uint64_t{size} * size * size; }
};

struct GridBuffers {
  BufferId nodes = BufferId::kInvalid, vertices = BufferId::kInvalid;
  BufferId rest = BufferId::kInvalid;
  BufferId forces = BufferId::kInvalid;     ///< [vertex] Float4: the sum with the forces of others
  BufferId bindPoses = BufferId::kInvalid;  ///< until the rest density has been measured
};

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
  void lose(HairBuffers& buffers, const BufferFactory& factory) {
    remove(factory);
    buffers.contactForces = BufferId::kInvalid;
  }
  void move(const WorldMove& move) {
    move.point(middle_);
    move.direction(velocity_);
  }
  std::vector<MovedElements> moved(const HairFrame& frame) const {
    if (shape_.size == 0 || history_ == 0) return {};
    return {{buffers_.vertices, 0, frame.guideVertices(), 1, {move_rigidly::kMovesPoint}, true}};
  }

 private:
  void make(const HairFrame& frame);

  GridShape shape_;
  GridBuffers buffers_;
  BufferId others_ = BufferId::kInvalid;  ///< forces of others in this frame; kInvalid: none
  bool measured_ = false;
  uint32_t history_ = 0;  ///< steps since the last reset, at most 2
  double step_ = 0;       ///< the last one [s]
  Float3 middle_ = {};    ///< of the object in the last frame [m]
  Float3 velocity_ = {};  ///< of that in the last frame [m/s]
};

}  // namespace pelage::detail
