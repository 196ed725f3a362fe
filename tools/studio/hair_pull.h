// Pulls a lock of hair with the mouse.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "pelage/pass_list.h"
#include "pelage/result.h"
#include "pelage/scene.h"
#include "pelage/view.h"

namespace sample {

/// Radius of a lock that is pulled, as a share of half the picture's height.
inline constexpr float kLockRadius = 0.15f;

/// A vertex of a guide.
struct PickedVertex {
  uint32_t vertex = 0;  ///< in HairBuffers::positions
  pelage::Float3 position;
  float depth = 0;  ///< from the camera [m]
};

/// Returns the vertex nearest to a pixel; nothing without one within 40 pixels. Of vertices within
/// 8 pixels, the one in front is taken. The first two of a strand, which bones hold, do not count.
/// \param x, y pixels from the top left.
std::optional<PickedVertex> pickVertex(std::span<const pelage::Float4> positions,
                                       uint32_t verticesPerStrand, const pelage::View& view,
                                       float x, float y);

/// Springs between a lock of hair and the mouse. They write forces to buffers of the scene, for
/// HairObject::setForces(), until release(). Objects may be removed from the scene meanwhile.
class HairPull {
 public:
  /// Asks for the hair at a pixel: take() reads it.
  /// \param x, y pixels from the top left. \param radius of the lock [m].
  void ask(const pelage::View& view, float x, float y, float radius);
  bool isAsked() const { return asked_.has_value(); }
  /// Takes the hair that ask() wants, if there is some near the pixel. Errors: those of `read`.
  pelage::Result<void> take(pelage::Scene& scene, std::span<const pelage::HairId> hairs,
                            const pelage::BufferReader& read);
  bool holds() const { return !locks_.empty(); }
  /// Returns the point where the hair was taken [m].
  const pelage::Float3& point() const { return point_; }
  /// Returns the point that the mouse drags it to [m].
  const pelage::Float3& target() const { return target_; }
  void dragTo(const pelage::Float3& target) { target_ = target; }
  void release(pelage::Scene& scene);
  /// Adds the passes that write the forces to a list that runs before the simulation.
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

}  // namespace sample
