// The sample's scenes: a character with three grooms, a head with one, or grooms and meshes from
// files. Samples, golden tests and benchmarks share them.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "camera.h"
#include "demo_assets.h"
#include "groom_presets.h"
#include "mesh_object.h"
#include "pelage/asset_cache.h"
#include "pelage/demo/character.h"
#include "pelage/headless.h"
#include "pelage/scene.h"
#include "pelage/settings/settings_file.h"

namespace sample {

/// The collider of a generated head.
enum class HeadCollider : uint8_t {
  kCapsules,
  kMesh,  ///< the head's mesh, through a signed distance field
};

/// The motion of the bones of grooms and meshes from files.
struct BoneMotion {
  std::string name;  ///< for errors
  std::vector<std::string> bones;
  double seconds = 0;  ///< it starts over after this time
  /// [bone] bind space to world, at a time within `seconds`.
  std::function<std::vector<pelage::AffineTransform>(double seconds)> pose;
};

/// Grooms and meshes from files. Bones with the same name are one bone.
struct FileAssets {
  pelage::AssetCache assets;
  /// Without it all bones follow a head that looks to both sides and nods.
  std::optional<BoneMotion> motion;
};

struct DemoDef {
  std::optional<uint32_t> followPerGuide;  ///< a default for the groom when not given
  uint64_t seed = 1;                       ///< of the follow hairs
  pelage::SkinningMethod skinning = pelage::SkinningMethod::kMatrices;
  pelage::Solver solver = pelage::Solver::kExact;
  /// Settings of all hair, colliders and lights, in place of the scene's own. Of its solver,
  /// skinning and collision of follow hairs, those here are used; the first light also lights the
  /// meshes. Transparency and view are the caller's.
  std::optional<pelage::SettingsFile> settings;
  std::optional<uint32_t> subSteps;           ///< of the exact solver; before `settings`
  std::optional<pelage::Float3> wind;         ///< [m/s]; before `settings`
  GroomPreset preset = GroomPreset::kParted;  ///< the look of a generated groom
  pelage::CharacterMotion motion = pelage::CharacterMotion::kAll;  ///< of a character
  pelage::Float3 place;                                            ///< of a character [m]
  HeadCollider headCollider = HeadCollider::kCapsules;
  /// draw() shows the surfaces of the signed distance fields that hair collides with in place of
  /// the meshes. It changes nothing else.
  bool drawSdf = false;
  /// draw() shows the contact records of all hair on top of it.
  bool drawContacts = false;
  pelage::CollidingHair collidingHair = pelage::CollidingHair::kGuides;
  /// Receives hair, colliders and meshes, and must outlive the DemoScene, which removes them in the
  /// end. nullptr: the DemoScene has a scene of its own.
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
  /// Grooms from files, which collide with all meshes. Of the definition, `preset`, `motion` and
  /// `headCollider` are not used. Errors: no hair; with a motion, hair without bones, and a bone
  /// that it does not have.
  static pelage::Result<DemoScene> create(const FileAssets& files, const DemoDef& def);

  /// Writes the passes of the next frame into a list, which is cleared first: the pose at
  /// the frame's end and one simulation step.
  pelage::Result<void> advance(pelage::PassList& list);
  /// How a hair object was made, for makeHairAgain().
  struct HairMaking {
    pelage::HairCreation creation;
    pelage::FollowDef follow;  ///< without effect on follow hairs from a file, until it changes
  };
  /// \param hair index in hairs().
  HairMaking making(size_t hair) const;
  /// Makes a hair object in another way: a new one, in its bind shape, with the settings and the
  /// look of the old one, whose id ends. Errors: those of generateFollowHairs() and
  /// Scene::addHair(); nothing has changed then.
  pelage::Result<void> makeHairAgain(size_t hair, const HairMaking& making);
  /// Sets the pose at a time: bones, colliders and meshes, for programs that call
  /// Scene::simulate() themselves. \param seconds >= 0. \param others colliders of all hair beside
  /// its own; keep each at its index from pose to pose.
  void pose(double seconds, std::span<const pelage::CapsuleCollider> others = {});
  /// Gives a character another motion, from the next pose on. Nothing happens to a head or files.
  void setMotion(pelage::CharacterMotion motion);
  /// How long its motion is, after which it starts over [s].
  pelage::CharacterCycle cycle() const { return cycle_; }
  /// Runs the pass that finds what the light sees of the meshes, for their shadow on the hair of
  /// the next draw(): Light::opaque. After advance(). It takes nothing where the light casts no
  /// shadow or there is no mesh.
  pelage::Result<void> castOpaqueShadow(pelage::HeadlessDevice& device);
  /// Sets the shadow that hair casts, of the light and those of moreLights that have one.
  void setShadow(pelage::HairShadow shadow);
  /// Level of detail: sets HairObject::drawnShare of all hair to the share that is enough for a
  /// view (Scene::shareForView()), but at most to `most`. Before what draws or casts shadows.
  void setDetail(const pelage::View& view, float pixels, float most);
  /// Adds the draws of mesh and hair, without sorting.
  pelage::Result<void> draw(const pelage::View& view, pelage::PassList& list);
  /// Adds them to lists that run one after another. lists[0] keeps what it has.
  pelage::Result<void> draw(const pelage::View& view, const pelage::TransparencySettings& settings,
                            std::vector<pelage::PassList>& lists);
  /// Whether draw() shows more than hair.
  bool drawsMeshes() const { return !meshes_.empty() || (drawSdf_ && !colliders_.empty()); }
  /// Adds what comes before the hair in a view: the shadow maps of hair, and the draws of
  /// drawMeshes() with the shadow in them.
  pelage::Result<void> drawOpaque(const pelage::View& view, pelage::PassList& list);
  /// Adds the draws of all that draw() shows except hair and contacts, with the shadow of the hair
  /// of the last draw().
  pelage::Result<void> drawMeshes(const pelage::View& view, pelage::PassList& list);
  /// With DemoDef::drawSdf, after draw() has run: an error when a surface was too large to be drawn
  /// as a whole.
  pelage::Result<void> checkDraw(pelage::HeadlessDevice& device) const;
  /// Computes the barriers of a complete list.
  void finish(pelage::PassList& list) { scene_->finish(list); }

  /// A camera that sees the bind shape in every pose of the motion.
  Camera camera(float aspect) const { return camera(aspect, {}); }
  /// The same from a place, as far as it is given.
  Camera camera(float aspect, const CameraPlace& place) const;
  /// The same from another side. \param direction from the scene towards the camera; any length >
  /// 0.
  Camera cameraFrom(const pelage::Float3& direction, float aspect) const;

  /// A box around all hair and meshes in every pose of the motion [m].
  struct Extent {
    pelage::Float3 low, high;
  };
  Extent extent() const;
  /// Shadow maps of hair that the last drawOpaque() has made; nothing where the light has none.
  std::optional<HairShadowMaps> hairShadowMaps() const;

  /// A buffer for the depth of the mesh, for TransparencySettings::opaqueDepth.
  pelage::BufferId addDepthBuffer(uint32_t width, uint32_t height);
  pelage::BufferId transparencyCounters() const { return scene_->transparencyCounters(); }
  pelage::BufferId shadowWords() const { return scene_->shadowWords(); }
  const pelage::ResourceTable& resources() const { return scene_->resources(); }
  const std::vector<pelage::HairId>& hairs() const { return hairs_; }
  /// The same, and brows and lashes, which have no settings of their own.
  std::vector<pelage::HairId> drawnHairs() const;
  const std::vector<pelage::ColliderId>& colliders() const { return colliders_; }
  /// Skinning transforms of the last frame, bind space to world.
  std::vector<pelage::AffineTransform> bones() const { return pose_(frame_ * kFrameSeconds); }
  /// The capsules of HeadCollider::kCapsules in the last frame.
  std::vector<pelage::CapsuleCollider> capsules() const;
  /// The same at a time of pose() [s].
  std::vector<pelage::CapsuleCollider> capsules(double seconds) const;
  /// HairAsset::restLengths of a hair object. \param hair index in hairs().
  const std::vector<float>& restLengths(size_t hair) const { return restLengths_[hair]; }
  const pelage::Scene& scene() const { return *scene_; }
  /// Tier of the device that runs the scene: Scene::setTier().
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

  pelage::Light light;                    ///< of hair and meshes
  std::vector<pelage::Light> moreLights;  ///< of hair alone

 private:
  explicit DemoScene(const DemoDef& def);
  struct HairSource {
    std::shared_ptr<const pelage::HairAsset> asset;
    pelage::HairDef def;  ///< without its spans, which are those below
    std::vector<pelage::BoneInfluences> influences;
    std::vector<pelage::FollowHair> followHairs;
    pelage::FollowDef follow;
  };
  pelage::Result<pelage::HairId> addToScene(const HairSource& source);
  pelage::Float3 underHair(pelage::HairId hair) const;
  /// Adds brows and lashes to the bone "head", in colors of the first hair.
  pelage::Result<void> addFaceHair(const pelage::Skeleton& skeleton);
  void poseHair(const std::vector<pelage::AffineTransform>& posed);
  std::vector<pelage::CapsuleCollider> capsulesIn(
      const std::vector<pelage::AffineTransform>& posed) const;
  pelage::Result<void> drawContacts(const pelage::View& view, pelage::PassList& list);
  pelage::Result<void> castHairShadow(pelage::PassList& list);
  pelage::Result<void> castOpaqueShadow(size_t index, pelage::Light& from,
                                        pelage::HeadlessDevice& device);
  pelage::Result<void> addMesh(const pelage::CollisionMesh& mesh, MeshDef def);
  pelage::Result<void> addHead(const DemoAssets& assets, const DemoDef& def);
  pelage::Result<void> addFiles(const FileAssets& files, const std::vector<std::string>& bones,
                                const DemoDef& def);
  pelage::Result<void> addHair(const pelage::HairAsset& hair, const pelage::HairDef& hairDef,
                               pelage::FollowDef follow, const DemoDef& def);
  pelage::Result<void> addCollider(const pelage::CollisionMesh& mesh,
                                   const pelage::SdfColliderDef& from, const DemoDef& demo);
  pelage::Result<void> addBody(const pelage::Character& character);
  void takeLook(std::vector<pelage::Light> from, const DemoDef& def);
  std::vector<pelage::Light> allLights() const;

  std::unique_ptr<pelage::Scene> ownScene_;  ///< nullptr: it is somebody else's
  pelage::Scene* scene_;
  std::vector<pelage::HairId> hairs_;
  std::vector<pelage::HairId> faceHair_;         ///< none or one; it has no settings
  std::vector<HairSource> sources_;              ///< [hair]
  std::vector<std::vector<float>> restLengths_;  ///< [hair]
  std::vector<MeshObject> meshes_;
  std::vector<pelage::ColliderId> colliders_;
  std::vector<pelage::BufferId> opaqueDepths_;  ///< [light], of Light::opaque
  std::vector<bool> unshadowed_;                ///< [moreLights]: by setShadow()
  bool hairShadowsMeshes_ = false;              ///< in the last draw()
  bool drawSdf_ = false, drawContacts_ = false;
  pelage::ColliderLook colliderLook_;
  pelage::ContactLook contactLook_;
  std::vector<pelage::CapsuleCollider>
      capsules_;  ///< in bind space; the first one on the neck bone
  std::function<std::vector<pelage::AffineTransform>(double seconds)> pose_;  ///< skinning
  uint32_t boneCount_ = 1;
  pelage::CharacterCycle cycle_;
  bool isCharacter_ = false;
  pelage::Float3 place_;
  CameraDef cameraDef_;
  std::vector<pelage::Float3> sweptPoints_;
  uint32_t frame_ = 0;
};

}  // namespace sample
