// The scene of a shot: its hair, what that collides with, and the bones of each simulation step.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "pelage/asset_cache.h"
#include "pelage/headless.h"
#include "pelage/scene.h"
#include "pelage/settings/settings_file.h"
#include "pelage/skin_table.h"
#include "project.h"

namespace pelage::bake {

/// A groom with its own settings.
struct ShotHair {
  std::shared_ptr<const CachedHair> hair;  ///< named as its files; shots share it
  SimulationSettings settings;
  FollowDef follow;
  std::optional<SkinTable> skin = {};  ///< roots on ShotInputs::skin, in place of bones
};

/// A mesh that a point cache moves: hair without bones follows it, and all hair collides with it.
struct ShotSkin {
  CollisionMesh mesh;
  /// Its vertices at a time [s] from the cache's first sample [m]. Errors: those of the cache.
  std::function<Result<std::vector<Float3>>(double seconds)> positions;
};

/// Everything that a shot is made of, loaded.
struct ShotInputs {
  std::vector<ShotHair> hairs;
  std::vector<CachedMesh> meshes;
  std::vector<float> cellSizes;  ///< [mesh] of its field [m]; 0: the default
  std::optional<SettingsFile> settings;
  std::vector<std::string> bones;
  /// [bone] bind space to world at a time [s].
  std::function<std::vector<AffineTransform>(double seconds)> pose;
  std::optional<ShotSkin> skin;
  std::vector<std::string> warnings;
};

/// Hair and meshes of a shot, and their warnings: the same for shots of one assetKeyOf(). Errors:
/// those of the loaders; two grooms of one name.
Result<ShotInputs> loadAssets(const Shot& shot);

/// \param assets  of loadAssets(). Errors: those of the loaders; hair that nothing moves, or that
/// bones move which the animation does not have; a point cache of another mesh.
Result<ShotInputs> loadShot(const Shot& shot, ShotInputs assets);
/// The same with assets of its own.
Result<ShotInputs> loadShot(const Shot& shot);

/// A groom in the scene, as it is baked.
struct BakedHair {
  std::string name;
  HairId id = {};
  uint32_t stride = 0;                 ///< vertices of a strand in the buffer of positions
  std::vector<uint32_t> vertexCounts;  ///< [strand], of those that are written
  uint64_t vertexCount = 0;            ///< sum of these
  uint64_t bytes() const { return uint64_t{stride} * vertexCounts.size() * sizeof(Float4); }
};

/// Positions [m] of ShotScene::readBytes(), strand by strand.
std::vector<Float3> positionsOf(const BakedHair& hair, std::span<const std::byte> bytes);

class ShotScene {
 public:
  /// \param subSteps  in place of those of shot and settings. Errors: those of Scene.
  static Result<ShotScene> create(const ShotInputs& inputs, const Shot& shot,
                                  double framesPerSecond, std::optional<uint32_t> subSteps = {});

  /// Steps of the whole shot: the pre-roll and the frames.
  uint64_t stepCount() const { return preRoll_ + shot_->frames.count(); }
  /// The step whose result is a frame.
  uint64_t stepOf(int64_t frame) const {
    return preRoll_ + static_cast<uint64_t>(frame - shot_->frames.first);
  }
  /// Runs a step: the pose at its end, and the simulation. Run all steps in order, from 0 on.
  Result<void> run(uint64_t step, HeadlessDevice& device);
  /// Notes a step without running it: the host's state is then that of a scene that has run it.
  Result<void> note(uint64_t step);
  /// Adds an acceleration to the gravity of all hair [m/s2].
  void accelerate(const Float3& acceleration);
  /// Lets the next step begin in the bind shape, under its bones.
  void reset();
  /// Reads where the hair is [m], strand by strand.
  Result<std::vector<Float3>> read(const BakedHair& hair, HeadlessDevice& device) const;
  /// The same as the device has it, for positionsOf().
  Result<std::vector<std::byte>> readBytes(const BakedHair& hair, HeadlessDevice& device) const;

  const std::vector<BakedHair>& hairs() const { return hairs_; }
  uint32_t subSteps() const;  ///< of the exact solver; the most of all hair
  bool isExact() const;       ///< all hair has the exact solver
  Scene& scene() { return *scene_; }

 private:
  ShotScene() = default;
  Result<void> addHair(const ShotHair& from, std::optional<uint32_t> subSteps);
  Result<void> addColliders();
  Result<std::vector<BoneInfluences>> mapped(const std::vector<BoneName>& bones,
                                             const std::vector<BoneInfluences>& influences) const;
  Result<void> addSkinCollider();
  Result<void> pose(uint64_t step);
  Result<void> poseSkin(double seconds);
  Result<Frame> simulate(uint64_t step);

  std::unique_ptr<Scene> scene_ = std::make_unique<Scene>();
  const ShotInputs* inputs_ = nullptr;
  const Shot* shot_ = nullptr;
  double framesPerSecond_ = 24;
  uint64_t preRoll_ = 0;
  SkeletonId skeleton_ = SkeletonId::kInvalid;
  std::vector<BakedHair> hairs_;
  std::vector<ColliderId> colliders_;
  /// Hair on the skin, and the motion of its roots so far.
  struct SkinnedHair {
    HairId id = {};
    const SkinTable* table = nullptr;
    std::vector<AffineTransform> roots;
  };
  std::vector<SkinnedHair> onSkin_;
  std::optional<ColliderId> skin_;
};

}  // namespace pelage::bake
