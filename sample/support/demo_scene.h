// The sample's scene: a groom and its mesh on a head that moves. Samples, golden tests and
// benchmarks share it.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "camera.h"
#include "demo_assets.h"
#include "groom_presets.h"
#include "mesh_object.h"
#include "pelage/headless.h"
#include "pelage/scene.h"

namespace sample {

struct DemoDef {
  std::optional<uint32_t> followPerGuide;  ///< a default for the groom when not given
  uint64_t seed = 1;                       ///< of the follow hairs
  pelage::SkinningMethod skinning = pelage::SkinningMethod::kMatrices;
  pelage::Solver solver = pelage::Solver::kExact;
  uint32_t subSteps = 1;                      ///< of the exact solver
  pelage::Float3 wind;                        ///< [m/s]
  GroomPreset preset = GroomPreset::kParted;  ///< the look of a generated groom
  /// Hair collides with the mesh by a signed distance field, and draw() shows the field's surface
  /// in place of the mesh.
  bool drawSdf = false;
};

class DemoScene {
 public:
  static constexpr double kFrameSeconds = 1.0 / 60;

  static pelage::Result<DemoScene> create(const DemoAssets& assets, const DemoDef& def);

  /// Writes the passes of the next frame into a list, which is cleared first: the pose of the head
  /// at the frame's end and one simulation step.
  pelage::Result<void> advance(pelage::PassList& list);
  /// Adds the draws of mesh and hair, without sorting.
  pelage::Result<void> draw(const pelage::View& view, pelage::PassList& list);
  /// Adds them to lists that run one after another. lists[0] keeps what it has.
  pelage::Result<void> draw(const pelage::View& view, const pelage::TransparencySettings& settings,
                            std::vector<pelage::PassList>& lists);
  /// With DemoDef::drawSdf, after draw() has run: an error when the surface was too large to be
  /// drawn as a whole.
  pelage::Result<void> checkDraw(pelage::HeadlessDevice& device) const;
  /// Computes the barriers of a complete list.
  void finish(pelage::PassList& list) { scene_.finish(list); }

  /// A camera that sees the bind shape in every pose of the motion.
  Camera camera(float aspect) const;

  /// A buffer for the depth of the mesh, for TransparencySettings::opaqueDepth.
  pelage::BufferId addDepthBuffer(uint32_t width, uint32_t height);
  pelage::BufferId transparencyCounters() const { return scene_.transparencyCounters(); }
  pelage::BufferId shadowWords() const { return scene_.shadowWords(); }
  const pelage::ResourceTable& resources() const { return scene_.resources(); }
  pelage::HairObject& hair() { return scene_.hair(hair_); }
  const pelage::HairObject& hair() const { return scene_.hair(hair_); }
  /// Frames advanced so far.
  uint32_t frame() const { return frame_; }

  pelage::Light light;

 private:
  DemoScene() = default;
  pelage::Result<void> drawMesh(const pelage::View& view, pelage::PassList& list);
  pelage::Result<void> addMesh(const DemoAssets& assets);
  pelage::Result<void> addCollider(const DemoAssets& assets);
  std::vector<pelage::AffineTransform> pose(double seconds) const;

  pelage::Scene scene_;
  pelage::HairId hair_ = pelage::HairId::kInvalid;
  std::optional<MeshObject> mesh_;
  pelage::ColliderId collider_ = pelage::ColliderId::kInvalid;
  std::vector<pelage::CapsuleCollider>
      capsules_;  ///< in bind space; the first one on the neck bone
  pelage::Skeleton skeleton_;
  uint32_t boneCount_ = 1;
  CameraDef cameraDef_;
  pelage::Float3 pivot_;  ///< of a groom without a skeleton [m]
  std::vector<pelage::Float3> sweptPoints_;
  uint32_t frame_ = 0;
};

}  // namespace sample
