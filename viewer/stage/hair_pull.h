// The mouse takes a lock of hair and pulls it.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "pelage/pass_list.h"
#include "pelage/result.h"
#include "pelage/scene.h"
#include "pelage/view.h"

namespace viewer {

/// A vertex of a guide.
struct PickedVertex {
  uint32_t vertex = 0;  ///< in HairBuffers::positions
  pelage::Float3 position;
  float depth = 0;  ///< from the camera [m]
};

/// The vertex nearest to a pixel: of those that are nearly under it the one in front, else the
/// nearest in the picture. The first two of a strand do not count: bones hold them. \param x, y
/// pixels from the top left. Nothing where none is within 40 pixels.
std::optional<PickedVertex> pickVertex(std::span<const pelage::Float4> positions,
                                       uint32_t verticesPerStrand, const pelage::View& view,
                                       float x, float y);

/// Springs between a lock of hair and the mouse, in buffers of the scene that HairObject::
/// setForces() has. They end with release(); objects that are gone meanwhile are let go.
class HairPull {
 public:
  /// Asks for the hair at a pixel: take() does it, when it can read. \param radius of the lock [m].
  void ask(const pelage::View& view, float x, float y, float radius);
  bool isAsked() const { return asked_.has_value(); }
  /// Takes what was asked for, or nothing where no hair is near. Errors: those of `read`.
  pelage::Result<void> take(pelage::Scene& scene, std::span<const pelage::HairId> hairs,
                            const pelage::BufferReader& read);
  bool holds() const { return !locks_.empty(); }
  /// Where the hair was taken [m].
  const pelage::Float3& point() const { return point_; }
  /// Where the mouse has dragged that point [m].
  const pelage::Float3& target() const { return target_; }
  void dragTo(const pelage::Float3& target) { target_ = target; }
  void release(pelage::Scene& scene);
  /// Adds the passes that write the forces, to a list before the simulation.
  pelage::Result<void> record(pelage::Scene& scene, pelage::PassList& list);

 private:
  struct Asked {
    pelage::View view;
    float x, y, radius;
  };
  struct Lock {
    pelage::HairId hair;
    pelage::BufferId taken, forces;
    uint32_t vertexCount;
  };
  void hold(pelage::Scene& scene, pelage::HairId hair, std::span<const pelage::Float4> positions,
            float radius);
  std::optional<Asked> asked_;
  std::vector<Lock> locks_;
  pelage::Float3 point_, target_;
};

}  // namespace viewer
