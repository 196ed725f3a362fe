// The sample's scenes: a character with three grooms, or one groom and its mesh on a head that
// moves. Samples, golden tests and benchmarks share them.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <vector>

#include "camera.h"
#include "demo_assets.h"
#include "groom_presets.h"
#include "mesh_object.h"
#include "pelage/demo/character.h"
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
  pelage::CharacterMotion motion = pelage::CharacterMotion::kAll;  ///< of a character
  /// draw() shows the surface of the signed distance fields that hair collides with in place of the
  /// mesh. A head's hair collides with a field only then.
  bool drawSdf = false;
  /// draw() shows the contact records of all hair on top of it.
  bool drawContacts = false;
  pelage::CollidingHair collidingHair = pelage::CollidingHair::kGuides;
  /// Receives hair, colliders and mesh, and must outlive the DemoScene, which removes the hair and
  /// the colliders in the end. nullptr: the DemoScene has a scene of its own.
  pelage::Scene* scene = nullptr;
};

class DemoScene {
 public:
  static constexpr double kFrameSeconds = 1.0 / 60;

  DemoScene(DemoScene&&) noexcept = default;
  DemoScene& operator=(DemoScene&&) = delete;
  ~DemoScene();

  /// One groom on a head. Of the definition, `motion` is not used.
  static pelage::Result<DemoScene> create(const DemoAssets& assets, const DemoDef& def);
  /// A character with its three grooms, which collide with its three colliders. Of the definition,
  /// `preset` is not used.
  static pelage::Result<DemoScene> create(const pelage::Character& character, const DemoDef& def);

  /// Writes the passes of the next frame into a list, which is cleared first: the pose at
  /// the frame's end and one simulation step.
  pelage::Result<void> advance(pelage::PassList& list);
  /// Adds the draws of mesh and hair, without sorting.
  pelage::Result<void> draw(const pelage::View& view, pelage::PassList& list);
  /// Adds them to lists that run one after another. lists[0] keeps what it has.
  pelage::Result<void> draw(const pelage::View& view, const pelage::TransparencySettings& settings,
                            std::vector<pelage::PassList>& lists);
  /// With DemoDef::drawSdf, after draw() has run: an error when a surface was too large to be drawn
  /// as a whole.
  pelage::Result<void> checkDraw(pelage::HeadlessDevice& device) const;
  /// Computes the barriers of a complete list.
  void finish(pelage::PassList& list) { scene_->finish(list); }

  /// A camera that sees the bind shape in every pose of the motion.
  Camera camera(float aspect) const;

  /// A buffer for the depth of the mesh, for TransparencySettings::opaqueDepth.
  pelage::BufferId addDepthBuffer(uint32_t width, uint32_t height);
  pelage::BufferId transparencyCounters() const { return scene_->transparencyCounters(); }
  pelage::BufferId shadowWords() const { return scene_->shadowWords(); }
  const pelage::ResourceTable& resources() const { return scene_->resources(); }
  const std::vector<pelage::HairId>& hairs() const { return hairs_; }
  const std::vector<pelage::ColliderId>& colliders() const { return colliders_; }
  /// Skinning transforms of the last frame, bind space to world.
  std::vector<pelage::AffineTransform> bones() const { return pose_(frame_ * kFrameSeconds); }
  /// What a head's hair collides with without DemoDef::drawSdf, where it is in the last frame.
  std::vector<pelage::CapsuleCollider> capsules() const;
  const pelage::Scene& scene() const { return *scene_; }
  /// Of the device that runs it: Scene::setTier().
  void setTier(pelage::Tier tier) { scene_->setTier(tier); }
  /// Counters of a hair object's contacts in the last frame, and its deepest vertex [m]: read back.
  /// Nothing where no collider has been in reach.
  struct ContactFigures {
    pelage::ContactCounters counters;
    float deepest = 0;
  };
  pelage::Result<std::optional<ContactFigures>> contactFigures(
      pelage::HairId hair, pelage::HeadlessDevice& device) const;
  /// Vertices of all strands, follow hairs included.
  uint64_t vertexCount() const;
  /// Frames advanced so far.
  uint32_t frame() const { return frame_; }

  pelage::Light light;

 private:
  explicit DemoScene(const DemoDef& def);
  pelage::Result<void> drawMesh(const pelage::View& view, pelage::PassList& list);
  pelage::Result<void> drawContacts(const pelage::View& view, pelage::PassList& list);
  pelage::Result<void> addMesh(const DemoAssets& assets);
  pelage::Result<void> addHair(const pelage::HairAsset& hair, const pelage::HairDef& hairDef,
                               pelage::FollowDef follow, const DemoDef& def);
  pelage::Result<void> addCollider(const pelage::CollisionMesh& mesh,
                                   const pelage::SdfColliderDef& def);
  pelage::Result<void> addBody(const pelage::Character& character);

  std::unique_ptr<pelage::Scene> ownScene_;  ///< nullptr: it is somebody else's
  pelage::Scene* scene_;
  std::vector<pelage::HairId> hairs_;
  std::optional<MeshObject> mesh_;
  std::vector<pelage::ColliderId> colliders_;
  bool drawSdf_ = false, drawContacts_ = false;
  std::vector<pelage::CapsuleCollider>
      capsules_;  ///< in bind space; the first one on the neck bone
  std::function<std::vector<pelage::AffineTransform>(double seconds)> pose_;  ///< skinning
  uint32_t boneCount_ = 1;
  CameraDef cameraDef_;
  std::vector<pelage::Float3> sweptPoints_;
  uint32_t frame_ = 0;
};

}  // namespace sample
