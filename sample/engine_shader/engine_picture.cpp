#include "engine_picture.h"

#include <pelage/demo/groom.h>
#include <pelage/scene.h>

#include <algorithm>
#include <iterator>
#include <span>
#include <string>
#include <vector>

#include "engine_shader/code.h"
#include "engine_shader/gpu_structs.h"
#include "engine_shader/kernels.h"

namespace engine_shader {

using pelage::BufferId;
using pelage::Float3;
using pelage::Float4;
using pelage::PassBuilder;
using pelage::PassList;
using pelage::Result;

namespace {

constexpr Float3 kKeyDirection = {-0.50f, 0.66f, 0.56f};  // unit vectors
constexpr Float3 kRimDirection = {0.64f, 0.38f, -0.67f};
constexpr float kRootRadius = 110e-6f, kTipRadius = 30e-6f;  // [m]

Result<pelage::HairId> addHair(pelage::Scene& scene, pelage::HairAsset asset) {
  if (Result<void> done = asset.process(); !done) return done.error();
  const auto follow = asset.generateFollowHairs({.countPerGuide = 8, .maxRadius = 0.004f});
  if (!follow) return follow.error();
  pelage::HairDef def;
  def.name = "hair";
  def.followHairs = *follow;
  // This engine's vertex shader reads them where the guides are.
  def.storeFollowHairs = true;
  def.settings.globalStiffness = 0.3f;
  // The radii of the fibers in the shadow map.
  def.material.fiberRadius = kRootRadius;
  def.material.tipRadiusRatio = kTipRadius / kRootRadius;
  return scene.addHair(asset, def);
}

std::vector<Float4> toFloat4(const std::vector<Float3>& vectors) {
  std::vector<Float4> result;
  for (const Float3& v : vectors) result.push_back({v.x, v.y, v.z, 0});
  return result;
}

struct Head {
  BufferId positions = BufferId::kInvalid, normals = BufferId::kInvalid,
           indices = BufferId::kInvalid;
  uint32_t vertexCount = 0, indexCount = 0;
};

Head addHead(pelage::Scene& scene, const pelage::CollisionMesh& mesh) {
  Head head;
  head.vertexCount = static_cast<uint32_t>(mesh.positions.size());
  head.indexCount = static_cast<uint32_t>(mesh.indices.size());
  head.positions = scene.resources().add("head/positions", toFloat4(mesh.positions),
                                         pelage::BufferUsage::kStorage);
  head.normals =
      scene.resources().add("head/normals", toFloat4(mesh.normals), pelage::BufferUsage::kStorage);
  head.indices = scene.resources().add("head/indices", mesh.indices, pelage::BufferUsage::kIndex);
  return head;
}

LightRig lightRig(const PictureDef& def, uint32_t shadows) {
  constexpr Float3 kEye = {-0.26f, 0.30f, 0.88f}, kTarget = {0, 0.20f, -0.01f};
  const pelage::Matrix4 clip = pelage::lookAt(kEye, kTarget, {0, 1, 0}, 0.46f, 1, 0.1f, 10);
  LightRig rig = {};
  std::copy(std::begin(clip.rows), std::end(clip.rows), std::begin(rig.cameraRows));
  rig.cameraEye = {kEye.x, kEye.y, kEye.z, 1};
  const auto pixels = static_cast<float>(def.size);
  rig.cameraTarget = {pixels, pixels, static_cast<float>(def.samples), 0};
  rig.keyDirection = {kKeyDirection.x, kKeyDirection.y, kKeyDirection.z,
                      static_cast<float>(shadows)};
  rig.keyColor = {1.5f, 1.38f, 1.20f, 0};
  rig.rimDirection = {kRimDirection.x, kRimDirection.y, kRimDirection.z, 0};
  rig.rimColor = {0.45f, 0.60f, 0.95f, 0};
  rig.skyColor = {0.26f, 0.30f, 0.38f, 0};
  rig.groundColor = {0.10f, 0.08f, 0.06f, 0};
  return rig;
}

Result<void> drawHead(pelage::Scene& scene, const Head& head, const LightRig& rig, PassList& list) {
  HeadLook look = {};
  look.headColor = {0.50f, 0.36f, 0.29f, 1};
  look.headVertexCount = head.vertexCount;
  const uint64_t bytes = uint64_t{head.vertexCount} * sizeof(Float4);
  PassBuilder draw(list);
  return draw.draw(headVertexVariant(), headPixelVariant(), {}, head.indexCount, 1, head.indices)
      .bind("g_headPositions", head.positions, bytes)
      .bind("g_headNormals", head.normals, bytes)
      .bind("g_headShadowWords", scene.shadowWords(),
            scene.resources().find(scene.shadowWords())->size)
      .bind("g_headShadowViews", scene.shadowViews(),
            scene.resources().find(scene.shadowViews())->size)
      .constants("LightRig", rig)
      .constants("HeadLook", look)
      .finish();
}

Result<void> drawHair(pelage::Scene& scene, pelage::HairId id, const LightRig& rig,
                      PassList& list) {
  const pelage::HairObject& hair = scene.hair(id);
  HairLook look = {};
  look.lookRoot = {0.10f, 0.035f, 0.014f, 1};
  look.lookTip = {0.34f, 0.135f, 0.048f, 1};
  look.lookBody = {1, 1, 0, 0};
  look.lookPrimary = {0.16f, 70, -0.06f, 0};
  look.lookSecondary = {0.8f, 14, 0.12f, 1};
  look.lookRootRadius = kRootRadius;
  look.lookTipRadius = kTipRadius;
  look.lookVertexCount = hair.verticesPerStrand();
  look.lookStrandCount = hair.strandCount();
  const uint64_t bytes = uint64_t{hair.strandCount()} * hair.verticesPerStrand() * sizeof(Float4);
  PassBuilder draw(list);
  return draw
      .draw(hairVertexVariant(), hairPixelVariant(), {}, (hair.verticesPerStrand() - 1) * 6,
            hair.strandCount(), hair.buffers().indices)
      .bind("g_hairPositions", hair.buffers().positions, bytes)
      .bind("g_hairTangents", hair.buffers().tangents, bytes)
      .bind("g_hairShadowWords", scene.shadowWords(),
            scene.resources().find(scene.shadowWords())->size)
      .bind("g_hairShadowViews", scene.shadowViews(),
            scene.resources().find(scene.shadowViews())->size)
      .constants("LightRig", rig)
      .constants("HairLook", look)
      .finish();
}

}  // namespace

Result<pelage::RenderedImage> drawPicture(pelage::HeadlessDevice& device, const PictureDef& def) {
  // This program's own kernels; the device knows pelage's.
  device.addCode(allCode());
  auto groom =
      pelage::generateGroom({.seed = 5, .strandCount = def.guides, .verticesPerStrand = 20});
  if (!groom) return groom.error();
  pelage::Scene scene;
  const Result<pelage::HairId> hair = addHair(scene, std::move(groom->hair));
  if (!hair) return hair.error();
  const Head head = addHead(scene, groom->head);

  // 1. pelage moves the hair, and fills the shadow map of the key light.
  Result<pelage::Frame> frame = scene.simulate(1.0f / 60);
  if (!frame) return frame.error();
  scene.hair(*hair).visible = def.hair;
  pelage::Light key;
  key.direction = kKeyDirection;
  key.shadow = def.keyShadow ? pelage::HairShadow::kDeep : pelage::HairShadow::kNone;
  key.shadowSize = 512;
  const Result<uint32_t> shadows = frame->castShadows({&key, 1});
  if (!shadows) return shadows.error();

  // 2. The engine draws, with its own kernels and constants.
  const LightRig rig = lightRig(def, *shadows);
  PassList list;
  if (Result<void> done = drawHead(scene, head, rig, list); !done) return done.error();
  if (def.hair)
    if (Result<void> done = drawHair(scene, *hair, rig, list); !done) return done.error();

  // 3. Into a target of its own.
  if (const Result<uint32_t> view = frame->addView(std::move(list)); !view) return view.error();
  const pelage::RenderTargetDef target = {
      .width = def.size, .height = def.size, .samples = def.samples};
  auto images = device.render(*frame, {&target, 1});
  if (!images) return images.error();
  return std::move(images->front());
}

}  // namespace engine_shader
