#include "lit_character.h"

#include <pelage/demo/character.h>
#include <pelage/engine_lights.h>

#include <algorithm>
#include <iterator>
#include <span>
#include <string>
#include <utility>

#include "engine_body/code.h"
#include "engine_body/gpu_structs.h"
#include "engine_body/kernels.h"
#include "engine_lights/code.h"
#include "engine_lights/kernels.h"

namespace engine_lights {

using pelage::BufferId;
using pelage::Float3;
using pelage::Float4;
using pelage::Result;

namespace {

constexpr uint32_t kLeastNodes = 1u << 20;
constexpr Float3 kSkin = {0.46f, 0.31f, 0.24f};

// Two bars of a window cast shadows of the sun; the picture does not show them.
void addBars(OpaqueGeometry& opaque) {
  const Float3 sun = sunDirection();
  const Float3 center = {0.6f * sun.x, 0.12f + 0.6f * sun.y, 0.6f * sun.z};
  for (const float height : {-0.02f, 0.10f}) {
    const auto first = static_cast<uint32_t>(opaque.positions.size());
    for (const float side : {-0.5f, 0.5f})
      for (const float edge : {-0.02f, 0.02f})
        opaque.positions.push_back(
            {center.x + side, center.y + height + edge, center.z + side * 0.5f});
    for (const uint32_t corner : {0u, 1u, 2u, 2u, 1u, 3u}) opaque.indices.push_back(first + corner);
  }
}

pelage::CharacterDef characterDef(float hairShare) {
  pelage::CharacterDef def;
  def.cellSize = 0.006f;
  for (pelage::CharacterHairDef* hair : {&def.longHair, &def.fur, &def.mohawk}) {
    hair->strandCount =
        std::max(1u, static_cast<uint32_t>(hairShare * static_cast<float>(hair->strandCount)));
  }
  return def;
}

pelage::View viewOf(const PictureDef& def) {
  pelage::View view;
  view.eye = {0.30f, 0.24f, 1.15f};
  view.worldToClip = pelage::lookAt(view.eye, {0, 0.07f, 0}, {0, 1, 0}, 0.52f, 1, 0.1f, 10);
  view.width = view.height = def.size;
  view.samples = def.samples;
  return view;
}

}  // namespace

Result<LitCharacter> LitCharacter::create(pelage::HeadlessDevice& device, float hairShare) {
  // This program's own kernels; the device knows pelage's.
  device.addCode(engine_body::allCode());
  device.addCode(allCode());
  LitCharacter lit(device);
  lit.scene_.setTier(device.info().tier);
  const auto character = pelage::generateCharacter(characterDef(hairShare));
  if (!character) return character.error();
  for (const pelage::CharacterGroom& groom : character->grooms) {
    pelage::HairAsset asset = groom.hair;
    if (Result<void> done = asset.process(); !done) return done.error();
    const auto follows = asset.generateFollowHairs(groom.follow);
    if (!follows) return follows.error();
    pelage::HairDef def;
    def.name = groom.name;
    def.material = groom.material;
    def.settings = groom.settings;
    def.followHairs = *follows;
    const Result<pelage::HairId> added = lit.scene_.addHair(asset, def);
    if (!added) return added.error();
    // It stands still: its hair is where it was combed.
    lit.scene_.hair(*added).simulated = false;
    lit.hairs_.push_back(*added);
  }

  const pelage::CollisionMesh& mesh = character->mesh;
  std::vector<Float4> vertices;
  for (size_t i = 0; i < mesh.positions.size(); ++i) {
    const Float3 &p = mesh.positions[i], &n = mesh.normals[i];
    vertices.insert(vertices.end(), {{p.x, p.y, p.z, 1}, {n.x, n.y, n.z, 0}});
  }
  lit.vertexCount_ = static_cast<uint32_t>(mesh.positions.size());
  lit.indexCount_ = static_cast<uint32_t>(mesh.indices.size());
  lit.vertices_ =
      lit.scene_.resources().add("body/vertices", vertices, pelage::BufferUsage::kVertex);
  lit.indices_ =
      lit.scene_.resources().add("body/indices", mesh.indices, pelage::BufferUsage::kIndex);

  OpaqueGeometry opaque = {mesh.positions, mesh.indices};
  addBars(opaque);
  Result<LightRig> rig = LightRig::create(device, opaque);
  if (!rig) return rig.error();
  lit.rig_ = *rig;
  return lit;
}

Result<void> LitCharacter::drawBody(const pelage::View& view, const LightsOn& on,
                                    pelage::PassList& list) const {
  engine_body::BodyLook look = {};
  std::copy(std::begin(view.worldToClip.rows), std::end(view.worldToClip.rows),
            std::begin(look.bodyRows));
  look.bodyColor = {kSkin.x, kSkin.y, kSkin.z, 1};
  const std::vector<pelage::NamedResource> lights = rig_.resources(on);
  pelage::PassBuilder draw(list);
  return draw
      .draw(engine_body::bodyVertexVariant(), engine_body::bodyPixelVariant(), {}, indexCount_, 1,
            indices_)
      .vertices({vertices_, uint64_t{vertexCount_} * 2 * sizeof(Float4)})
      .constants("BodyLook", look)
      .offer(lights)
      .finish();
}

BufferId LitCharacter::depthOf(uint32_t size) {
  if (depthSize_ != size) {
    if (depth_ != BufferId::kInvalid) scene_.resources().remove(depth_);
    depth_ = scene_.resources().add(
        {.name = "depth", .size = uint64_t{size} * size * sizeof(float), .stride = sizeof(float)});
    depthSize_ = size;
  }
  return depth_;
}

Result<pelage::RenderedImage> LitCharacter::draw(const PictureDef& def) {
  for (const pelage::HairId hair : hairs_) scene_.hair(hair).visible = def.hair;
  Result<pelage::Frame> frame = scene_.simulate(0);
  if (!frame) return frame.error();
  const pelage::View view = viewOf(def);
  pelage::PassList body;
  if (Result<void> drawn = drawBody(view, def.lights, body); !drawn) return drawn.error();

  // pelage: the shadow that the hair casts on itself. Its lights give no light here.
  pelage::Light sun;
  sun.direction = sunDirection();
  sun.shadow = pelage::HairShadow::kDeep;
  sun.shadowSize = 512;
  const pelage::EngineLights lights{.kernels = allKernels(),
                                    .resources = rig_.resources(def.lights)};
  pelage::TransparencySettings settings = {.method = def.method, .engineLights = &lights};
  // Much hair in few pixels: lists need room for its layers, whatever the size of the picture.
  if (def.method == pelage::Transparency::kWindowed)
    settings.nodeCount = std::max(kLeastNodes, 16 * def.size * def.size);
  pelage::RenderTargetDef target = {.width = def.size, .height = def.size, .samples = def.samples};
  if (def.method == pelage::Transparency::kTiles)
    settings.opaqueDepth = target.depthCopy = depthOf(def.size);
  const Result<uint32_t> added = frame->draw(view, {&sun, 1}, settings, std::move(body));
  if (!added) return added.error();
  auto images = device_->render(*frame, {&target, 1});
  if (!images) return images.error();
  return std::move(images->front());
}

}  // namespace engine_lights
