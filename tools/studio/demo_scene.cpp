#include "demo_scene.h"

#include <algorithm>
#include <cmath>
#include <tuple>
#include <utility>

#include "head_motion.h"
#include "names.h"
#include "scene_setup.h"

namespace sample {

namespace {

// Capsules inside the generated head, in bind space: along its middle, each end as large as the
// head lets it be.
std::vector<pelage::CapsuleCollider> headCapsules() {
  // The first one belongs to the neck bone.
  constexpr Float3 kEnds[][2] = {
      {{0, 0.030f, -0.036f}, {0, 0.200f, -0.030f}},             // neck
      {{0, 0.266f, -0.012f}, {0, 0.245f, -0.042f}},             // top to back
      {{0, 0.244f, -0.020f}, {0, 0.256f, 0.024f}},              // middle to forehead
      {{0, 0.235f, 0.000f}, {0, 0.145f, 0.042f}},               // middle to chin
      {{0.032f, 0.262f, -0.016f}, {-0.032f, 0.262f, -0.016f}},  // sides of the top
  };
  constexpr float kInside = 0.001f;  // roots lie on the surface
  std::vector<pelage::CapsuleCollider> capsules;
  for (const auto& [head, tail] : kEnds) {
    const float headRadius = std::max(-pelage::headDistance(head) - kInside, 0.0f);
    const float tailRadius = std::max(-pelage::headDistance(tail) - kInside, 0.0f);
    capsules.push_back({.head = head,
                        .headRadius = headRadius,
                        .tail = tail,
                        .tailRadius = tailRadius,
                        .friction = 0.3f});
  }
  return capsules;
}

// How a groom is lit, coloured and simulated.
struct Look {
  pelage::StrandMaterial material;
  pelage::SimulationSettings settings;
  uint32_t followPerGuide = 0;
  float followRadius = 0;  // m
  float flyaways = 0;
  CameraDef camera;
};

// A generated groom that swings.
Look generatedLook(GroomPreset preset, pelage::Solver solver) {
  const PresetLook from = presetLook(preset);
  Look look;
  look.material = from.material;
  look.followPerGuide = from.followPerGuide;
  look.followRadius = from.followRadius;
  look.flyaways = from.flyaways;
  look.camera.direction = {0.40f, 0.16f, 1};
  look.settings.solver = solver;
  look.settings.damping = 0.04f;
  look.settings.vspCoefficient = 0.2f;
  if (solver == pelage::Solver::kExact) {
    look.settings.bendLength = from.bendLength;
    look.settings.globalStiffness = from.globalStiffness;
    look.settings.globalRange = 0.4f;
  } else {
    look.settings.globalStiffness = kClassicGlobalStiffness;
    look.settings.globalRange = 1;
  }
  return look;
}

bool areSame(const pelage::FollowDef& a, const pelage::FollowDef& b) {
  const auto membersOf = [](const pelage::FollowDef& def) {
    const auto& [count, guides, radius, tip, flyaways, seed] = def;
    return std::tie(count, guides, radius, tip, flyaways, seed);
  };
  return membersOf(a) == membersOf(b);
}

}  // namespace

DemoScene::DemoScene(const DemoDef& def)
    : ownScene_(def.scene == nullptr ? std::make_unique<pelage::Scene>() : nullptr),
      scene_(def.scene == nullptr ? ownScene_.get() : def.scene) {}

// A scene that was moved from has none of these.
DemoScene::~DemoScene() {
  for (MeshObject& mesh : meshes_) mesh.remove(scene_->resources());
  if (!hairs_.empty())
    for (const pelage::BufferId depth : opaqueDepths_)
      if (depth != pelage::BufferId::kInvalid) scene_->resources().remove(depth);
  for (const pelage::HairId hair : drawnHairs()) (void)scene_->removeHair(hair);
  for (const pelage::ColliderId collider : colliders_) (void)scene_->removeCollider(collider);
}

// How what is drawn looks.
void DemoScene::takeLook(std::vector<pelage::Light> from, const DemoDef& def) {
  drawSdf_ = def.drawSdf;
  drawContacts_ = def.drawContacts;
  pelage::SceneSettings scene;
  scene.lights = std::move(from);
  if (def.settings) def.settings->apply(scene);
  // A scene without lights is dark.
  if (scene.lights.empty()) scene.lights = {{.color = {0, 0, 0}, .ambient = {0, 0, 0}}};
  light = scene.lights[0];
  moreLights.assign(scene.lights.begin() + 1, scene.lights.end());
  colliderLook_ = scene.colliderLook;
  contactLook_ = scene.contactLook;
}

void DemoScene::setShadow(pelage::HairShadow shadow) {
  light.shadow = shadow;
  // A shadow that it removed comes back.
  unshadowed_.resize(moreLights.size());
  for (size_t i = 0; i < moreLights.size(); ++i) {
    pelage::HairShadow& own = moreLights[i].shadow;
    if (own == pelage::HairShadow::kNone && !unshadowed_[i]) continue;
    own = shadow;
    unshadowed_[i] = shadow == pelage::HairShadow::kNone;
  }
}

std::vector<pelage::Light> DemoScene::allLights() const {
  std::vector<pelage::Light> lights = {light};
  lights.insert(lights.end(), moreLights.begin(), moreLights.end());
  return lights;
}

Result<DemoScene> DemoScene::create(const DemoAssets& assets, const DemoDef& def) {
  DemoScene demo(def);
  demo.boneCount_ = assets.boneCount();
  demo.pose_ = [skeleton = assets.skeleton](double seconds) {
    return poseSkeleton(skeleton, headPose(seconds));
  };
  demo.cycle_ = {0, kHeadMotionSeconds};
  const Look look = generatedLook(def.preset, def.solver);
  demo.cameraDef_ = look.camera;
  demo.takeLook(studioLights(look.camera.direction), def);

  pelage::HairDef hairDef;
  hairDef.name = assets.name;
  hairDef.material = look.material;
  hairDef.settings = look.settings;
  hairDef.influences = assets.weights.strands;
  Result<void> added = demo.addHair(assets.hair, hairDef,
                                    {.countPerGuide = look.followPerGuide,
                                     .maxRadius = look.followRadius,
                                     .flyaways = look.flyaways,
                                     .seed = def.seed},
                                    def);
  if (!added) return added.error();
  if (added = demo.addHead(assets, def); !added) return added.error();

  for (int i = 0; i * kSweptStep < kHeadMotionSeconds; ++i) {
    const std::vector<AffineTransform> bones = demo.pose_(i * kSweptStep);
    sweepHair(assets.hair, assets.weights.strands, bones, demo.sweptPoints_);
    if (assets.mesh) sweepMesh(*assets.mesh, bones, demo.sweptPoints_);
  }
  return demo;
}

// Adds the collider and the mesh that is drawn.
Result<void> DemoScene::addHead(const DemoAssets& assets, const DemoDef& def) {
  const bool collides = def.headCollider == HeadCollider::kMesh && assets.mesh;
  if (def.drawSdf && !collides)
    return pelage::Error{pelage::ErrorCode::kInvalidArgument,
                         "the hair collides with no signed distance field that could be drawn"};
  if (!collides) capsules_ = headCapsules();
  if (collides)
    if (Result<void> done = addCollider(*assets.mesh, {.name = assets.name + "/field"}, def); !done)
      return done;
  if (def.drawSdf || !assets.mesh) return {};
  std::vector<float> scalp;
  if (assets.rootSpacing > 0) {
    scalp = coveredShares(*assets.mesh, assets.hair, kScalpRange * assets.rootSpacing);
    if (Result<void> done = addFaceHair(assets.skeleton); !done) return done;
  }
  Result<void> added = addMesh(
      *assets.mesh,
      {.name = assets.name + "/mesh", .influences = assets.mesh->influences, .scalp = scalp});
  if (added) meshes_.back().material.scalp = underHair(hairs_[0]);
  return added;
}

Result<void> DemoScene::addHair(const HairAsset& hair, const pelage::HairDef& look,
                                pelage::FollowDef followDef, const DemoDef& def) {
  pelage::SceneSettings scene;
  scene.simulation = look.settings;
  scene.material = look.material;
  scene.follow = followDef;
  if (def.settings) def.settings->apply(scene);
  HairSource source;
  source.def.name = look.name;
  source.def.settings = scene.simulation;
  source.def.material = scene.material;
  source.follow = scene.follow;
  source.influences.assign(look.influences.begin(), look.influences.end());
  source.followHairs.assign(look.followHairs.begin(), look.followHairs.end());
  apply(scene.creation, source.def);
  if (source.followHairs.empty()) {
    source.follow.countPerGuide = def.followPerGuide.value_or(source.follow.countPerGuide);
    auto generated = hair.generateFollowHairs(source.follow);
    if (!generated) return generated.error();
    source.followHairs = *std::move(generated);
  }
  source.def.settings.solver = def.solver;
  if (def.subSteps) source.def.settings.subSteps = *def.subSteps;
  if (def.wind) source.def.settings.wind.velocity = *def.wind;
  source.def.skinning = def.skinning;
  source.def.collidingHair = def.collidingHair;
  source.asset = std::make_shared<const HairAsset>(hair);
  const auto added = addToScene(source);
  if (!added) return added.error();
  hairs_.push_back(*added);
  sources_.push_back(std::move(source));
  restLengths_.push_back(hair.restLengths);
  apply(scene.object, scene_->hair(*added));
  return {};
}

Result<pelage::HairId> DemoScene::addToScene(const HairSource& source) {
  pelage::HairDef def = source.def;
  def.influences = source.influences;
  def.followHairs = source.followHairs;
  def.boneCount = boneCount_;
  return scene_->addHair(source.asset, def);
}

DemoScene::HairMaking DemoScene::making(size_t hair) const {
  const HairSource& source = sources_[hair];
  const pelage::HairDef& def = source.def;
  return {{def.skinning, def.levelOfDetail, def.storeFollowHairs, def.collidingHair},
          source.follow};
}

Result<void> DemoScene::makeHairAgain(size_t hair, const HairMaking& making) {
  HairSource source = sources_[hair];
  const pelage::HairObject& old = scene_->hair(hairs_[hair]);
  const pelage::HairObjectSettings object = settingsOf(old);
  source.def.settings = old.settings;
  source.def.material = old.material;
  apply(making.creation, source.def);
  if (!areSame(making.follow, source.follow)) {
    auto generated = source.asset->generateFollowHairs(making.follow);
    if (!generated) return generated.error();
    source.followHairs = *std::move(generated);
    source.follow = making.follow;
  }
  const auto added = addToScene(source);
  if (!added) return added.error();
  (void)scene_->removeHair(hairs_[hair]);
  hairs_[hair] = *added;
  sources_[hair] = std::move(source);
  apply(object, scene_->hair(*added));
  return {};
}

// The color of skin with the stubs of a hair's strands.
Float3 DemoScene::underHair(pelage::HairId hair) const {
  constexpr float kSkin = 0.06f, kRoots = 0.9f;
  const Float3& skin = MeshMaterial().skin;
  const Float3& root = scene_->hair(hair).material.rootColor;
  return {kSkin * skin.x + kRoots * root.x, kSkin * skin.y + kRoots * root.y,
          kSkin * skin.z + kRoots * root.z};
}

Result<void> DemoScene::addFaceHair(const pelage::Skeleton& skeleton) {
  const auto head = std::find_if(skeleton.bones.begin(), skeleton.bones.end(),
                                 [](const pelage::Bone& bone) { return bone.name == "head"; });
  const auto bone = static_cast<uint32_t>(head - skeleton.bones.begin());
  auto hair = pelage::generateFaceHair();
  if (!hair) return hair.error();
  if (Result<void> done = hair->process(); !done) return done;
  const std::vector<BoneInfluences> influences(hair->strandCount, {{bone, 0, 0, 0}, {1, 0, 0, 0}});
  pelage::HairDef def;
  def.name = "face";
  def.influences = influences;
  def.boneCount = boneCount_;
  // Darker than the tips of the hair, which the sun bleaches.
  const pelage::StrandMaterial& hairs = scene_->hair(hairs_[0]).material;
  def.material.rootColor = hairs.rootColor;
  def.material.tipColor = {(hairs.rootColor.x + hairs.tipColor.x) / 2,
                           (hairs.rootColor.y + hairs.tipColor.y) / 2,
                           (hairs.rootColor.z + hairs.tipColor.z) / 2};
  def.material.fiberRadius = 60e-6f;
  def.material.tipRadiusRatio = 0.2f;
  const auto added = scene_->addHair(std::make_shared<const HairAsset>(*std::move(hair)), def);
  if (!added) return added.error();
  scene_->hair(*added).simulated = false;
  faceHair_.push_back(*added);
  return {};
}

Result<void> DemoScene::addMesh(const pelage::CollisionMesh& mesh, MeshDef def) {
  def.boneCount = boneCount_;
  auto object = MeshObject::create(scene_->resources(), mesh, def);
  if (!object) return object.error();
  meshes_.push_back(*std::move(object));
  return {};
}

Result<void> DemoScene::addCollider(const pelage::CollisionMesh& mesh,
                                    const pelage::SdfColliderDef& from, const DemoDef& demo) {
  pelage::SdfColliderDef def = from;
  def.boneCount = boneCount_;
  const auto added = scene_->addCollider(mesh, def);
  if (!added) return added.error();
  colliders_.push_back(*added);
  pelage::SceneSettings scene;
  if (demo.settings) demo.settings->apply(scene);
  apply(scene.collider, scene_->collider(*added));
  return {};
}

Result<void> DemoScene::advance(pelage::PassList& list) {
  ++frame_;
  const std::vector<AffineTransform> posed = bones();
  poseHair(posed);
  if (Result<void> done = scene_->simulate(static_cast<float>(kFrameSeconds), list); !done)
    return done;
  for (MeshObject& mesh : meshes_) mesh.setBones(posed);
  return {};
}

void DemoScene::poseHair(const std::vector<AffineTransform>& posed) {
  for (const pelage::HairId hair : drawnHairs()) scene_->hair(hair).setBones(posed);
  scene_->hair(hairs_[0]).setColliders(capsulesIn(posed));
  for (const pelage::ColliderId collider : colliders_) scene_->collider(collider).setBones(posed);
}

void DemoScene::pose(double seconds, std::span<const pelage::CapsuleCollider> others) {
  const std::vector<AffineTransform> posed = pose_(seconds);
  poseHair(posed);
  for (size_t i = 0; i < hairs_.size(); ++i) {
    std::vector<pelage::CapsuleCollider> colliders;
    if (i == 0) colliders = capsulesIn(posed);
    colliders.insert(colliders.end(), others.begin(), others.end());
    scene_->hair(hairs_[i]).setColliders(colliders);
  }
  for (MeshObject& mesh : meshes_) mesh.setBones(posed);
}

void DemoScene::setMotion(pelage::CharacterMotion motion) {
  if (!isCharacter_) return;
  pose_ = [skeleton = pelage::characterSkeleton(), motion, place = place_](double seconds) {
    std::vector<AffineTransform> bones =
        pelage::skinningTransforms(skeleton, pelage::poseCharacter(motion, seconds));
    for (AffineTransform& bone : bones) {
      bone.rows[0].w += place.x;
      bone.rows[1].w += place.y;
      bone.rows[2].w += place.z;
    }
    return bones;
  };
  cycle_ = pelage::characterCycle(motion);
}

std::vector<pelage::CapsuleCollider> DemoScene::capsules() const { return capsulesIn(bones()); }

std::vector<pelage::CapsuleCollider> DemoScene::capsules(double seconds) const {
  return capsulesIn(pose_(seconds));
}

std::vector<pelage::CapsuleCollider> DemoScene::capsulesIn(
    const std::vector<AffineTransform>& posed) const {
  std::vector<pelage::CapsuleCollider> capsules = capsules_;
  for (size_t i = 0; i < capsules.size(); ++i) {
    const AffineTransform& bone = posed[i == 0 ? 0 : 1];
    capsules[i].head = pelage::transformPoint(bone, capsules[i].head);
    capsules[i].tail = pelage::transformPoint(bone, capsules[i].tail);
  }
  return capsules;
}

Result<void> DemoScene::drawMeshes(const pelage::View& view, pelage::PassList& list) {
  if (drawSdf_)
    for (const pelage::ColliderId collider : colliders_)
      if (Result<void> done = scene_->drawCollider(collider, view, light, colliderLook_, list);
          !done)
        return done;
  const std::optional<HairShadowMaps> maps = hairShadowMaps();
  for (const MeshObject& mesh : meshes_) {
    Result<void> done = mesh.draw(view, light, list, maps ? &*maps : nullptr);
    if (!done) return done;
  }
  return {};
}

std::optional<HairShadowMaps> DemoScene::hairShadowMaps() const {
  if (!hairShadowsMeshes_) return std::nullopt;
  const auto range = [&](pelage::BufferId buffer) -> pelage::BufferRange {
    return scene_->resources().whole(buffer);
  };
  return HairShadowMaps{range(scene_->shadowWords()), range(scene_->shadowViews())};
}

Result<void> DemoScene::castOpaqueShadow(pelage::HeadlessDevice& device) {
  if (Result<void> done = castOpaqueShadow(0, light, device); !done) return done;
  for (size_t i = 0; i < moreLights.size(); ++i)
    if (Result<void> done = castOpaqueShadow(i + 1, moreLights[i], device); !done) return done;
  return {};
}

Result<void> DemoScene::castOpaqueShadow(size_t index, pelage::Light& from,
                                         pelage::HeadlessDevice& device) {
  constexpr uint32_t kSize = 1024;  // texels: 0.7 mm on a head
  from.opaque = {.bias = from.opaque.bias};
  if (from.shadow == pelage::HairShadow::kNone || meshes_.empty()) return {};
  opaqueDepths_.resize(std::max(opaqueDepths_.size(), index + 1), pelage::BufferId::kInvalid);
  pelage::BufferId& depth = opaqueDepths_[index];
  if (depth == pelage::BufferId::kInvalid) {
    depth = scene_->resources().add({.name = "opaque shadow",
                                     .size = uint64_t{kSize} * kSize * sizeof(float),
                                     .stride = sizeof(float)});
  }
  const pelage::View view = lightView(sweptPoints_, from.direction, kSize);
  pelage::PassList list;
  for (const MeshObject& mesh : meshes_)
    if (Result<void> done = mesh.draw(view, light, list); !done) return done;
  finish(list);
  if (Result<void> done = device.update(resources()); !done) return done;
  const auto image = device.render(list, {.width = kSize, .height = kSize, .depthCopy = depth});
  if (!image) return image.error();
  from.opaque = {.depth = depth,
                 .width = kSize,
                 .height = kSize,
                 .worldToClip = view.worldToClip,
                 .bias = from.opaque.bias};
  return {};
}

void DemoScene::setDetail(const pelage::View& view, float pixels, float most) {
  for (const pelage::HairId hair : drawnHairs())
    scene_->hair(hair).drawnShare = std::min(scene_->shareForView(hair, view, pixels), most);
}

// Before the meshes are drawn: the draws of hair find the map done.
Result<void> DemoScene::castHairShadow(pelage::PassList& list) {
  hairShadowsMeshes_ = false;
  if (light.shadow == pelage::HairShadow::kNone || meshes_.empty()) return {};
  const Result<uint32_t> maps = scene_->castShadows(allLights(), list);
  if (!maps) return maps.error();
  hairShadowsMeshes_ = *maps > 0;
  return {};
}

Result<void> DemoScene::drawOpaque(const pelage::View& view, pelage::PassList& list) {
  if (Result<void> done = castHairShadow(list); !done) return done;
  return drawMeshes(view, list);
}

Result<void> DemoScene::draw(const pelage::View& view, pelage::PassList& list) {
  if (Result<void> done = drawOpaque(view, list); !done) return done;
  if (Result<void> done = scene_->draw(view, light, list); !done) return done;
  return drawContacts(view, list);
}

Result<void> DemoScene::draw(const pelage::View& view, const pelage::TransparencySettings& settings,
                             std::vector<pelage::PassList>& lists) {
  // Without the list of contacts of the last frame.
  if (lists.empty() || drawContacts_) lists.resize(1);
  if (Result<void> done = drawOpaque(view, lists[0]); !done) return done;
  if (Result<void> done = scene_->draw(view, allLights(), settings, lists); !done) return done;
  if (!drawContacts_) return {};
  // After the last list of any method, over what is blended there.
  return drawContacts(view, lists.emplace_back());
}

Result<void> DemoScene::drawContacts(const pelage::View& view, pelage::PassList& list) {
  if (!drawContacts_) return {};
  for (const pelage::HairId hair : hairs_)
    if (Result<void> done = scene_->drawContacts(hair, view, contactLook_, list); !done)
      return done;
  return {};
}

pelage::BufferId DemoScene::addDepthBuffer(uint32_t width, uint32_t height) {
  return scene_->resources().add({.name = "opaque depth",
                                  .size = uint64_t{width} * height * sizeof(float),
                                  .stride = sizeof(float)});
}

Result<void> DemoScene::checkDraw(pelage::HeadlessDevice& device) const {
  for (const pelage::ColliderId collider : colliders_) {
    const pelage::BufferId counts = scene_->collider(collider).buffers().isoCounts;
    if (counts == pelage::BufferId::kInvalid) continue;
    const auto bytes = device.read(counts);
    if (!bytes) return bytes.error();
    if (Result<void> done = scene_->checkColliderDraw(collider, *bytes); !done) return done;
  }
  return {};
}

Result<std::optional<DemoScene::ContactFigures>> DemoScene::contactFigures(
    pelage::HairId id, pelage::HeadlessDevice& device) const {
  const pelage::HairBuffers& buffers = scene_->hair(id).buffers();
  if (buffers.contactWords == pelage::BufferId::kInvalid) return std::optional<ContactFigures>();
  const auto words = device.read(buffers.contactWords);
  if (!words) return words.error();
  const auto contacts = device.read(buffers.contacts);
  if (!contacts) return contacts.error();
  const auto positions = device.read(buffers.positions);
  if (!positions) return positions.error();
  const auto deepest = scene_->deepestContact(id, *contacts, *words, *positions);
  if (!deepest) return deepest.error();
  return std::optional(ContactFigures{pelage::readContactCounters(*words), *deepest});
}

std::vector<pelage::HairId> DemoScene::drawnHairs() const {
  std::vector<pelage::HairId> drawn = hairs_;
  drawn.insert(drawn.end(), faceHair_.begin(), faceHair_.end());
  return drawn;
}

uint64_t DemoScene::vertexCount() const {
  uint64_t count = 0;
  for (const pelage::HairId id : drawnHairs()) {
    const pelage::HairObject& hair = scene_->hair(id);
    count += uint64_t{hair.strandCount()} * hair.verticesPerStrand();
  }
  return count;
}

Camera DemoScene::camera(float aspect, const CameraPlace& place) const {
  return placeCamera(sweptPoints_, place, cameraDef_, aspect);
}

DemoScene::Extent DemoScene::extent() const {
  Extent extent = {sweptPoints_[0], sweptPoints_[0]};
  for (const Float3& p : sweptPoints_) {
    extent.low = {std::min(extent.low.x, p.x), std::min(extent.low.y, p.y),
                  std::min(extent.low.z, p.z)};
    extent.high = {std::max(extent.high.x, p.x), std::max(extent.high.y, p.y),
                   std::max(extent.high.z, p.z)};
  }
  return extent;
}

Camera DemoScene::cameraFrom(const Float3& direction, float aspect) const {
  CameraDef def = cameraDef_;
  def.direction = direction;
  return frameAll(sweptPoints_, def, aspect);
}

}  // namespace sample
