#include "shot_scene.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <cstring>
#include <utility>

#include "bone_stream.h"
#include "pelage/authoring/animation.h"
#include "pelage/demo/groom.h"
#include "point_cache.h"
#include "skin_mesh.h"

namespace pelage::bake {
namespace {

constexpr float kCharacterField = 0.010f;  // m

std::optional<uint32_t> indexOf(const std::vector<std::string>& names, std::string_view name) {
  const auto found = std::find(names.begin(), names.end(), name);
  if (found == names.end()) return std::nullopt;
  return static_cast<uint32_t>(found - names.begin());
}

// A name that a file can have on every system.
std::string fileNameOf(std::string name) {
  for (char& c : name)
    if (!(std::isalnum(static_cast<unsigned char>(c)) != 0 || c == '.' || c == '-')) c = '_';
  if (name.empty() || name.front() == '.') name.insert(0, "_");
  return name;
}

ShotHair shotHair(CachedHair hair, const SimulationSettings& settings = {},
                  const FollowDef& follow = {}) {
  hair.name = fileNameOf(std::move(hair.name));
  return {std::make_shared<const CachedHair>(std::move(hair)), settings, follow};
}

Result<void> makeCharacter(const GeneratedAssets& from, ShotInputs& inputs) {
  CharacterDef def;
  def.seed = from.seed;
  if (from.guides) {
    const double share = static_cast<double>(*from.guides) / def.longHair.strandCount;
    for (uint32_t* count :
         {&def.longHair.strandCount, &def.fur.strandCount, &def.mohawk.strandCount})
      *count = static_cast<uint32_t>(std::clamp(std::round(share * *count), 1.0, 1e6));
  }
  auto character = generateCharacter(def);
  if (!character) return character.error();
  for (CharacterGroom& groom : character->grooms) {
    const bool wanted = from.grooms.empty() || indexOf(from.grooms, groom.name).has_value();
    if (!wanted) continue;
    if (auto done = groom.hair.process(); !done) return done;
    inputs.hairs.push_back(shotHair({groom.name, std::move(groom.hair), std::move(groom.bones), {}},
                                    groom.settings, groom.follow));
  }
  for (CharacterCollider& collider : character->colliders) {
    inputs.meshes.push_back({collider.name, std::move(collider.mesh)});
    inputs.cellSizes.push_back(kCharacterField);
  }
  return {};
}

Result<void> makeHead(const GeneratedAssets& from, ShotInputs& inputs) {
  GroomDef def;
  def.seed = from.seed;
  if (from.guides) def.strandCount = *from.guides;
  auto groom = generateGroom(def);
  if (!groom) return groom.error();
  if (auto done = groom->hair.process(); !done) return done;
  inputs.hairs.push_back(shotHair({"head", std::move(groom->hair), std::move(groom->bones), {}}));
  inputs.meshes.push_back({"head", std::move(groom->head)});
  inputs.cellSizes.push_back(kCharacterField);
  return {};
}

Result<void> loadFiles(const Shot& shot, ShotInputs& inputs) {
  auto assets = program::loadAssetFiles(shot.files, inputs.warnings);
  if (!assets) return assets.error();
  for (std::string& warning : program::unitWarnings(*assets, shot.files.scale))
    inputs.warnings.push_back(std::move(warning));
  if (assets->hairs.empty())
    return Error{ErrorCode::kInvalidArgument,
                 fmt::format("shot '{}': there is no hair in the files", shot.name)};
  for (CachedHair& hair : assets->hairs) inputs.hairs.push_back(shotHair(std::move(hair)));
  inputs.meshes = std::move(assets->meshes);
  inputs.cellSizes.assign(inputs.meshes.size(), 0);
  return {};
}

void poseBy(Skeleton skeleton, std::function<std::vector<AffineTransform>(double)> world,
            ShotInputs& inputs) {
  for (const Bone& bone : skeleton.bones) inputs.bones.push_back(bone.name);
  inputs.pose = [skeleton = std::move(skeleton), world = std::move(world)](double seconds) {
    return skinningTransforms(skeleton, world(seconds));
  };
}

// Loads the motion of the bones, and their names.
Result<void> loadMotion(const Shot& shot, ShotInputs& inputs) {
  inputs.pose = [](double) { return std::vector<AffineTransform>(1); };
  if (!shot.animation.empty()) {
    auto loaded = loadAnimation(shot.animation, shot.clip);
    if (!loaded) return loaded.error();
    const auto animation = std::make_shared<const SkeletonAnimation>(*std::move(loaded));
    poseBy(
        skeletonOf(*animation), [animation](double seconds) { return poseAt(*animation, seconds); },
        inputs);
  } else if (shot.motion) {
    poseBy(
        characterSkeleton(),
        [motion = *shot.motion](double seconds) { return poseCharacter(motion, seconds); }, inputs);
  } else if (!shot.transforms.empty()) {
    auto loaded = loadBoneStream(shot.transforms);
    if (!loaded) return loaded.error();
    inputs.bones = loaded->bones;
    inputs.pose = [stream = std::make_shared<const BoneStream>(*std::move(loaded))](
                      double seconds) { return transformsAt(*stream, seconds); };
  }
  return {};
}

Result<void> loadSkin(const Shot& shot, ShotInputs& inputs) {
  auto mesh = loadSkinMesh(shot.pointMesh, shot.files.scale);
  if (!mesh) return mesh.error();
  auto opened = PointCache::open(shot.points);
  if (!opened) return opened.error();
  if (opened->pointCount() != mesh->positions.size())
    return Error{
        ErrorCode::kInvalidFile,
        fmt::format("{}: byte 16: has {} points, and {} has {} vertices", shot.points.string(),
                    opened->pointCount(), shot.pointMesh.string(), mesh->positions.size())};
  const auto cache = std::make_shared<PointCache>(*std::move(opened));
  inputs.skin = {*std::move(mesh),
                 [cache, scale = shot.files.scale,
                  rate = shot.pointsPerSecond](double seconds) -> Result<std::vector<Float3>> {
                   auto positions = cache->positionsAt(seconds * rate);
                   if (!positions) return positions;
                   for (Float3& p : *positions) p = {scale * p.x, scale * p.y, scale * p.z};
                   return positions;
                 }};
  return {};
}

// Each hair follows its bones, or the skin.
Result<void> attach(const Shot& shot, ShotInputs& inputs) {
  if (!shot.hasBones() && shot.points.empty()) return {};
  for (ShotHair& hair : inputs.hairs) {
    const auto refuse = [&](const char* text) {
      return Error{ErrorCode::kInvalidArgument,
                   fmt::format("shot '{}': the hair '{}' {}", shot.name, hair.hair->name, text)};
    };
    if (hair.hair->bones) {
      if (shot.hasBones()) continue;
      return refuse(
          "has bones, and the animation moves none; leave out \"bones\", so that it "
          "follows the skin");
    }
    if (!inputs.skin)
      return refuse(
          "has no bones that the animation could move; give it \"bones\", a .tfxbone "
          "file, or let it follow the skin by \"points\" and \"mesh\"");
    std::string warning;
    auto table = bindToSkin(hair.hair->asset, inputs.skin->mesh, warning);
    if (!table) return refuse(table.error().message.c_str());
    hair.skin = *std::move(table);
    if (!warning.empty()) inputs.warnings.push_back(hair.hair->name + ": " + warning);
  }
  return {};
}

}  // namespace

Result<ShotInputs> loadAssets(const Shot& shot) {
  ShotInputs inputs;
  Result<void> done;
  if (!shot.generated)
    done = loadFiles(shot, inputs);
  else if (shot.generated->kind == GeneratedKind::kCharacter)
    done = makeCharacter(*shot.generated, inputs);
  else
    done = makeHead(*shot.generated, inputs);
  if (!done) return done.error();
  for (size_t i = 0; i < inputs.hairs.size(); ++i)
    for (size_t j = 0; j < i; ++j)
      if (inputs.hairs[i].hair->name == inputs.hairs[j].hair->name)
        return Error{ErrorCode::kInvalidArgument,
                     fmt::format("shot '{}': two hairs are '{}'; the files of a bake have their "
                                 "names",
                                 shot.name, inputs.hairs[i].hair->name)};
  return inputs;
}

Result<ShotInputs> loadShot(const Shot& shot, ShotInputs inputs) {
  if (shot.cellSize > 0)
    inputs.cellSizes.assign(inputs.meshes.size(), static_cast<float>(shot.cellSize));
  if (!shot.collides) {
    inputs.meshes.clear();
    inputs.cellSizes.clear();
  }
  if (!shot.settings.empty()) {
    auto settings = SettingsFile::load(shot.settings);
    if (!settings) return settings.error();
    inputs.settings = *std::move(settings);
  }
  Result<void> done = loadMotion(shot, inputs);
  if (done && !shot.points.empty()) done = loadSkin(shot, inputs);
  if (done) done = attach(shot, inputs);
  if (!done) return done.error();
  return inputs;
}

Result<ShotInputs> loadShot(const Shot& shot) {
  auto assets = loadAssets(shot);
  return assets ? loadShot(shot, *std::move(assets)) : assets;
}

std::vector<Float3> positionsOf(const BakedHair& hair, std::span<const std::byte> bytes) {
  std::vector<Float3> positions(hair.vertexCount);
  size_t to = 0;
  for (size_t strand = 0; strand < hair.vertexCounts.size(); ++strand) {
    const std::byte* from = bytes.data() + strand * hair.stride * sizeof(Float4);
    for (uint32_t i = 0; i < hair.vertexCounts[strand]; ++i, from += sizeof(Float4))
      std::memcpy(&positions[to++], from, sizeof(Float3));
  }
  return positions;
}

Result<ShotScene> ShotScene::create(const ShotInputs& inputs, const Shot& shot,
                                    double framesPerSecond, std::optional<uint32_t> subSteps) {
  ShotScene made;
  made.inputs_ = &inputs;
  made.shot_ = &shot;
  made.framesPerSecond_ = framesPerSecond;
  made.preRoll_ = shot.preRoll;
  const auto skeleton = made.scene_->addSkeleton(
      {.name = "bones",
       .boneCount = static_cast<uint32_t>(std::max<size_t>(inputs.bones.size(), 1))});
  if (!skeleton) return skeleton.error();
  made.skeleton_ = *skeleton;
  for (const ShotHair& hair : inputs.hairs)
    if (auto done = made.addHair(hair, subSteps ? subSteps : shot.subSteps); !done)
      return done.error();
  if (auto done = made.addColliders(); !done) return done.error();
  return made;
}

// Without an animation all bones are the one that stands still.
Result<std::vector<BoneInfluences>> ShotScene::mapped(
    const std::vector<BoneName>& bones, const std::vector<BoneInfluences>& influences) const {
  const std::vector<std::string>& names = inputs_->bones;
  if (names.empty()) return std::vector<BoneInfluences>();
  return mapBones(bones, influences, [&](std::string_view name) { return indexOf(names, name); });
}

Result<void> ShotScene::addHair(const ShotHair& from, std::optional<uint32_t> subSteps) {
  SceneSettings settings;
  settings.simulation = from.settings;
  settings.follow = from.follow;
  if (inputs_->settings) inputs_->settings->apply(settings);
  if (shot_->solver) settings.simulation.solver = *shot_->solver;
  if (subSteps) settings.simulation.subSteps = *subSteps;
  HairDef def;
  apply(settings.creation, def);
  def.name = from.hair->name;
  def.settings = settings.simulation;
  def.skeleton = skeleton_;
  def.storeFollowHairs = shot_->followHairs;
  std::vector<BoneInfluences> influences;
  if (from.skin) {
    def.skeleton = SkeletonId::kInvalid;
    def.boneCount = from.hair->asset.strandCount;
    influences = oneBoneAStrand(def.boneCount);
  } else if (from.hair->bones) {
    auto found = mapped(from.hair->bones->bones, from.hair->bones->strands);
    if (!found) return found.error();
    influences = *std::move(found);
  }
  def.influences = influences;
  std::vector<FollowHair> follow =
      shot_->followHairs ? from.hair->followHairs : std::vector<FollowHair>();
  if (shot_->followHairs && follow.empty() && settings.follow.countPerGuide > 0) {
    auto generated = from.hair->asset.generateFollowHairs(settings.follow);
    if (!generated) return generated.error();
    follow = *std::move(generated);
  }
  def.followHairs = follow;
  const auto id = scene_->addHair(from.hair->asset, def);
  if (!id) return id.error();
  apply(settings.object, scene_->hair(*id));
  if (from.skin) onSkin_.push_back({*id, &*from.skin, std::vector<AffineTransform>(def.boneCount)});

  BakedHair baked = {from.hair->name, *id, from.hair->asset.verticesPerStrand, {}, 0};
  const std::vector<uint32_t>& counts = from.hair->asset.vertexCounts;
  const auto countOf = [&](uint32_t guide) {
    return counts.empty() ? baked.stride : counts[guide];
  };
  for (uint32_t i = 0; i < from.hair->asset.strandCount; ++i)
    baked.vertexCounts.push_back(countOf(i));
  for (const FollowHair& hair : follow) baked.vertexCounts.push_back(countOf(hair.guide));
  for (const uint32_t count : baked.vertexCounts) baked.vertexCount += count;
  hairs_.push_back(std::move(baked));
  return {};
}

Result<void> ShotScene::addColliders() {
  SceneSettings settings;
  if (inputs_->settings) inputs_->settings->apply(settings);
  for (size_t i = 0; i < inputs_->meshes.size(); ++i) {
    const CachedMesh& cached = inputs_->meshes[i];
    CollisionMesh mesh = cached.mesh;
    auto influences = mapped(mesh.bones, mesh.influences);
    if (!influences) return influences.error();
    mesh.influences = *std::move(influences);
    const auto id = scene_->addCollider(
        mesh, {.name = cached.name, .cellSize = inputs_->cellSizes[i], .skeleton = skeleton_});
    if (!id) return id.error();
    apply(settings.collider, scene_->collider(*id));
    colliders_.push_back(*id);
  }
  return inputs_->skin && shot_->collides ? addSkinCollider() : Result<void>();
}

// A bone for each vertex moves it from the rest shape.
Result<void> ShotScene::addSkinCollider() {
  SceneSettings settings;
  if (inputs_->settings) inputs_->settings->apply(settings);
  const CollisionMesh& mesh = inputs_->skin->mesh;
  const auto id =
      scene_->addCollider(mesh, {.name = "skin",
                                 .cellSize = static_cast<float>(shot_->cellSize),
                                 .boneCount = static_cast<uint32_t>(mesh.positions.size())});
  if (!id) return id.error();
  apply(settings.collider, scene_->collider(*id));
  colliders_.push_back(*id);
  skin_ = *id;
  return {};
}

Result<void> ShotScene::poseSkin(double seconds) {
  const auto positions = inputs_->skin->positions(seconds);
  if (!positions) return positions.error();
  const std::span<const Float3> part = *positions;
  for (SkinnedHair& hair : onSkin_) {
    if (auto done = rootTransforms(*hair.table, std::span(&part, 1), hair.roots); !done)
      return done;
    scene_->hair(hair.id).setBones(hair.roots);
  }
  if (!skin_) return {};
  std::vector<AffineTransform> bones(part.size());
  for (size_t i = 0; i < bones.size(); ++i) {
    const Float3& rest = inputs_->skin->mesh.positions[i];
    bones[i].rows[0].w = part[i].x - rest.x;
    bones[i].rows[1].w = part[i].y - rest.y;
    bones[i].rows[2].w = part[i].z - rest.z;
  }
  scene_->collider(*skin_).setBones(bones);
  return {};
}

Result<void> ShotScene::pose(uint64_t step) {
  const uint64_t frame = step > preRoll_ ? step - preRoll_ : 0;
  const double seconds = shot_->animationStart + static_cast<double>(frame) / framesPerSecond_;
  scene_->skeleton(skeleton_).setBones(inputs_->pose(seconds));
  return inputs_->skin ? poseSkin(seconds) : Result<void>();
}

Result<Frame> ShotScene::simulate(uint64_t step) {
  if (auto posed = pose(step); !posed) return posed.error();
  return scene_->simulate(static_cast<float>(1 / framesPerSecond_));
}

Result<void> ShotScene::run(uint64_t step, HeadlessDevice& device) {
  auto frame = simulate(step);
  if (!frame) return frame.error();
  return device.run(*frame);
}

Result<void> ShotScene::note(uint64_t step) {
  auto frame = simulate(step);
  if (!frame) return frame.error();
  FrameExecutor executor;
  executor.update = [](const ResourceTable&) { return Result<void>(); };
  executor.record = [](const FrameStep& list) {
    setDelivered(list.list->run);
    return Result<void>();
  };
  executor.draw = [](const FrameStep&) { return Result<void>(); };
  return frame->run(executor);
}

void ShotScene::accelerate(const Float3& acceleration) {
  for (const BakedHair& hair : hairs_) {
    Float3& gravity = scene_->hair(hair.id).settings.gravity;
    gravity = {gravity.x + acceleration.x, gravity.y + acceleration.y, gravity.z + acceleration.z};
  }
}

void ShotScene::reset() {
  for (const BakedHair& hair : hairs_) scene_->hair(hair.id).reset();
  for (const ColliderId collider : colliders_) scene_->collider(collider).reset();
}

Result<std::vector<std::byte>> ShotScene::readBytes(const BakedHair& hair,
                                                    HeadlessDevice& device) const {
  return device.read(scene_->hair(hair.id).buffers().positions, 0, hair.bytes());
}

Result<std::vector<Float3>> ShotScene::read(const BakedHair& hair, HeadlessDevice& device) const {
  const auto bytes = readBytes(hair, device);
  if (!bytes) return bytes.error();
  return positionsOf(hair, *bytes);
}

uint32_t ShotScene::subSteps() const {
  uint32_t most = 1;
  for (const BakedHair& hair : hairs_)
    most = std::max(most, scene_->hair(hair.id).settings.subSteps);
  return most;
}

bool ShotScene::isExact() const {
  return std::all_of(hairs_.begin(), hairs_.end(), [&](const BakedHair& hair) {
    return scene_->hair(hair.id).settings.solver == Solver::kExact;
  });
}

}  // namespace pelage::bake
