#include "demo_scene.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "head_motion.h"

namespace sample {

using pelage::AffineTransform;
using pelage::BoneInfluences;
using pelage::Float3;
using pelage::Float4;
using pelage::HairAsset;
using pelage::Result;

namespace {

constexpr float kScalpReach = 1.8f;           // root spacings that the scalp's colour reaches
constexpr uint32_t kSweptStrands = 500;       // strands that the camera looks at, at most
constexpr uint32_t kSweptMeshVertices = 600;  // the same for the mesh
constexpr double kSweptStep = 0.1;            // s between the poses it looks at

struct Bounds {
  Float3 low = {std::numeric_limits<float>::max(), std::numeric_limits<float>::max(),
                std::numeric_limits<float>::max()};
  Float3 high = {std::numeric_limits<float>::lowest(), std::numeric_limits<float>::lowest(),
                 std::numeric_limits<float>::lowest()};
};

Bounds boundsOf(const HairAsset& hair) {
  Bounds bounds;
  for (const Float4& p : hair.positions) {
    bounds.low = {std::min(bounds.low.x, p.x), std::min(bounds.low.y, p.y),
                  std::min(bounds.low.z, p.z)};
    bounds.high = {std::max(bounds.high.x, p.x), std::max(bounds.high.y, p.y),
                   std::max(bounds.high.z, p.z)};
  }
  return bounds;
}

// A neck below the middle of the groom.
Float3 pivotUnder(const HairAsset& hair) {
  const Bounds b = boundsOf(hair);
  const float below = 0.4f * (b.high.y - b.low.y);
  return {(b.low.x + b.high.x) / 2, b.low.y - below, (b.low.z + b.high.z) / 2};
}

Float3 blend(const std::vector<AffineTransform>& bones, const BoneInfluences& influences,
             const Float3& point) {
  Float3 sum;
  float weights = 0;
  for (int i = 0; i < 4; ++i) {
    const float weight = influences.weights[i];
    if (!(weight > 0)) continue;
    const Float3 moved = pelage::transformPoint(bones[influences.bones[i]], point);
    sum = {sum.x + weight * moved.x, sum.y + weight * moved.y, sum.z + weight * moved.z};
    weights += weight;
  }
  if (!(weights > 0)) return pelage::transformPoint(bones[0], point);
  return {sum.x / weights, sum.y / weights, sum.z / weights};
}

void sweepHair(const DemoAssets& assets, const std::vector<AffineTransform>& bones,
               std::vector<Float3>& points) {
  const HairAsset& hair = assets.hair;
  const uint32_t stride = std::max(1u, hair.strandCount / kSweptStrands);
  for (uint32_t strand = 0; strand < hair.strandCount; strand += stride) {
    const BoneInfluences influences =
        assets.weights.strands.empty() ? BoneInfluences{} : assets.weights.strands[strand];
    for (const uint32_t vertex : {0u, hair.verticesPerStrand / 2, hair.verticesPerStrand - 1}) {
      const Float4& p = hair.positions[size_t{strand} * hair.verticesPerStrand + vertex];
      points.push_back(blend(bones, influences, {p.x, p.y, p.z}));
    }
  }
}

void sweepMesh(const DemoAssets& assets, const std::vector<AffineTransform>& bones,
               std::vector<Float3>& points) {
  const pelage::CollisionMesh& mesh = *assets.mesh;
  const size_t stride = std::max<size_t>(1, mesh.positions.size() / kSweptMeshVertices);
  for (size_t i = 0; i < mesh.positions.size(); i += stride)
    points.push_back(blend(bones, mesh.influences[i], mesh.positions[i]));
}

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
  CameraDef camera;
};

// A generated groom that swings.
Look generatedLook(GroomPreset preset, pelage::Solver solver) {
  const PresetLook from = presetLook(preset);
  Look look;
  look.material = from.material;
  look.followPerGuide = from.followPerGuide;
  look.followRadius = from.followRadius;
  look.camera.direction = {0.40f, 0.16f, 1};
  look.settings.solver = solver;
  look.settings.damping = 0.04f;
  look.settings.vspCoefficient = 0.2f;
  if (solver == pelage::Solver::kExact) {
    look.settings.bendLength = from.bendLength;
    look.settings.globalStiffness = from.globalStiffness;
    look.settings.globalRange = 0.4f;
  } else {
    // Local shape alone does not carry the hair's weight.
    look.settings.gravity = {0, -2.5f, 0};
    look.settings.globalStiffness = 0.04f;
    look.settings.globalRange = 1;
  }
  return look;
}

// A groom from files, of which nothing is known: stiff enough to keep its style, seen from the
// side.
Look fileLook(pelage::Solver solver) {
  const bool exact = solver == pelage::Solver::kExact;
  Look look;
  look.material.rootColor = {0.16f, 0.026f, 0.010f};
  look.material.tipColor = {0.46f, 0.15f, 0.040f};
  look.material.fiberRadius = 200e-6f;
  look.material.primaryStrength = 0.06f;
  look.material.secondaryStrength = 0.8f;
  look.followPerGuide = 8;
  look.followRadius = 0.006f;
  look.settings.solver = solver;
  if (!exact) look.settings.gravity = {0, -2.5f, 0};
  look.settings.bendLength = 0.2f;
  look.settings.globalStiffness = 0.06f;
  look.settings.globalRange = 1;
  look.settings.vspCoefficient = 0.2f;
  look.camera.direction = {1, 0.25f, -0.3f};
  return look;
}

// A warm light from the upper left of a camera in this direction, and a cool sky.
pelage::Light studioLight(const Float3& camera) {
  const float length = std::hypot(camera.x, camera.z);
  const Float3 back =
      length > 0 ? Float3{camera.x / length, 0, camera.z / length} : Float3{0, 0, 1};
  constexpr float kLeft = 0.55f, kUp = 0.70f, kBack = 0.62f;
  pelage::Light light;
  light.direction = {kBack * back.x - kLeft * back.z, kUp, kBack * back.z + kLeft * back.x};
  light.color = {1.32f, 1.24f, 1.12f};
  light.ambient = {0.19f, 0.22f, 0.27f};
  return light;
}

}  // namespace

Result<DemoScene> DemoScene::create(const DemoAssets& assets, const DemoDef& def) {
  const bool generated = !assets.skeleton.bones.empty();
  DemoScene demo;
  demo.skeleton_ = assets.skeleton;
  demo.boneCount_ = assets.boneCount();
  demo.pivot_ = pivotUnder(assets.hair);
  const Look look = generated ? generatedLook(def.preset, def.solver) : fileLook(def.solver);
  demo.cameraDef_ = look.camera;
  demo.light = studioLight(look.camera.direction);

  pelage::FollowDef followDef;
  followDef.countPerGuide = def.followPerGuide.value_or(look.followPerGuide);
  followDef.maxRadius = look.followRadius;
  followDef.seed = def.seed;
  auto follow = assets.hair.generateFollowHairs(followDef);
  if (!follow) return follow.error();

  pelage::HairDef hairDef;
  hairDef.name = assets.name;
  hairDef.material = look.material;
  hairDef.settings = look.settings;
  hairDef.settings.subSteps = def.subSteps;
  hairDef.settings.wind.velocity = def.wind;
  hairDef.skinning = def.skinning;
  hairDef.influences = assets.weights.strands;
  hairDef.boneCount = demo.boneCount_;
  hairDef.followHairs = *follow;
  const auto hair = demo.scene_.addHair(assets.hair, hairDef);
  if (!hair) return hair.error();
  demo.hair_ = *hair;

  if (generated && !def.drawSdf) demo.capsules_ = headCapsules();
  if (assets.mesh) {
    Result<void> added = def.drawSdf ? demo.addCollider(assets) : demo.addMesh(assets);
    if (!added) return added.error();
  }

  for (int i = 0; i * kSweptStep < kHeadMotionSeconds; ++i) {
    const std::vector<AffineTransform> bones = demo.pose(i * kSweptStep);
    sweepHair(assets, bones, demo.sweptPoints_);
    if (assets.mesh && generated) sweepMesh(assets, bones, demo.sweptPoints_);
  }
  return demo;
}

Result<void> DemoScene::addMesh(const DemoAssets& assets) {
  std::vector<float> scalp;
  if (assets.rootSpacing > 0) scalp = scalpShares(assets, kScalpReach * assets.rootSpacing);
  MeshDef def;
  def.name = assets.name + "/mesh";
  def.influences = assets.mesh->influences;
  def.boneCount = boneCount_;
  def.scalp = scalp;
  auto mesh = MeshObject::create(scene_.resources(), *assets.mesh, def);
  if (!mesh) return mesh.error();
  mesh_ = *mesh;
  return {};
}

Result<void> DemoScene::addCollider(const DemoAssets& assets) {
  pelage::SdfColliderDef def;
  def.name = assets.name + "/field";
  def.boneCount = boneCount_;
  const auto added = scene_.addCollider(*assets.mesh, def);
  if (!added) return added.error();
  collider_ = *added;
  return {};
}

std::vector<AffineTransform> DemoScene::pose(double seconds) const {
  const HeadPose head = headPose(seconds);
  if (!skeleton_.bones.empty()) return poseSkeleton(skeleton_, head);
  return std::vector<AffineTransform>(boneCount_, rotationAbout(poseRotation(head), pivot_));
}

Result<void> DemoScene::advance(pelage::PassList& list) {
  ++frame_;
  const std::vector<AffineTransform> bones = pose(frame_ * kFrameSeconds);
  scene_.hair(hair_).setBones(bones);
  std::vector<pelage::CapsuleCollider> capsules = capsules_;
  for (size_t i = 0; i < capsules.size(); ++i) {
    const AffineTransform& bone = bones[i == 0 ? 0 : 1];
    capsules[i].head = pelage::transformPoint(bone, capsules[i].head);
    capsules[i].tail = pelage::transformPoint(bone, capsules[i].tail);
  }
  scene_.hair(hair_).setColliders(capsules);
  if (collider_ != pelage::ColliderId::kInvalid) scene_.collider(collider_).setBones(bones);
  if (Result<void> done = scene_.simulate(static_cast<float>(kFrameSeconds), list); !done)
    return done;
  if (mesh_) mesh_->setBones(bones, list);
  return {};
}

Result<void> DemoScene::drawMesh(const pelage::View& view, pelage::PassList& list) {
  if (collider_ != pelage::ColliderId::kInvalid)
    return scene_.drawCollider(collider_, view, light, {}, list);
  if (mesh_) return mesh_->draw(view, light, list);
  return {};
}

Result<void> DemoScene::draw(const pelage::View& view, pelage::PassList& list) {
  if (Result<void> done = drawMesh(view, list); !done) return done;
  return scene_.draw(view, light, list);
}

Result<void> DemoScene::draw(const pelage::View& view, const pelage::TransparencySettings& settings,
                             std::vector<pelage::PassList>& lists) {
  if (lists.empty()) lists.resize(1);
  if (Result<void> done = drawMesh(view, lists[0]); !done) return done;
  return scene_.draw(view, {&light, 1}, settings, lists);
}

pelage::BufferId DemoScene::addDepthBuffer(uint32_t width, uint32_t height) {
  return scene_.resources().add({.name = "opaque depth",
                                 .size = uint64_t{width} * height * sizeof(float),
                                 .stride = sizeof(float)});
}

Result<void> DemoScene::checkDraw(pelage::HeadlessDevice& device) const {
  if (collider_ == pelage::ColliderId::kInvalid) return {};
  const pelage::BufferId counts = scene_.collider(collider_).buffers().isoCounts;
  if (counts == pelage::BufferId::kInvalid) return {};
  const auto bytes = device.read(counts);
  if (!bytes) return bytes.error();
  return scene_.checkColliderDraw(collider_, *bytes);
}

Camera DemoScene::camera(float aspect) const { return frameAll(sweptPoints_, cameraDef_, aspect); }

}  // namespace sample
