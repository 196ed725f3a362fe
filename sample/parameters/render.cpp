// From a setup to a picture.
#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

#include "camera.h"
#include "device.h"
#include "image.h"
#include "mesh_object.h"
#include "pelage/scene.h"
#include "scene_setup.h"
#include "setup.h"
#include "subject.h"

namespace sample {

using pelage::AffineTransform;
using pelage::Float3;
using pelage::HairObject;
using pelage::PassList;
using pelage::Result;
using pelage::Scene;

namespace {

constexpr float kFov = 0.3f;  // rad
constexpr Float3 kSteel = {0.16f, 0.22f, 0.30f};
constexpr Float3 kPaper = {0.58f, 0.60f, 0.62f};

pelage::View viewOf(const Setup& setup, uint32_t size) {
  const Float3& d = setup.toEye;
  const float distance = setup.extent / (2 * std::tan(kFov / 2));
  const float scale = distance / std::sqrt(d.x * d.x + d.y * d.y + d.z * d.z);
  Camera camera;
  camera.eye = {setup.center.x + scale * d.x, setup.center.y + scale * d.y,
                setup.center.z + scale * d.z};
  camera.target = setup.center;
  camera.verticalFov = kFov;
  camera.near = 0.2f * distance;
  camera.far = 4 * distance + 1;
  return makeView(camera, size, size, setup.samples);
}

// Stripes of two colours.
std::vector<pelage::Float4> makeTexture(uint32_t size) {
  std::vector<pelage::Float4> texels;
  for (uint32_t y = 0; y < size; ++y)
    for (uint32_t x = 0; x < size; ++x)
      texels.push_back(x % 2 == 0 ? pelage::Float4{0.55f, 0.06f, 0.04f, 1}
                                  : pelage::Float4{0.75f, 0.60f, 0.32f, 1});
  return texels;
}

// Meshes have no point lights: as it is in the middle of the picture.
pelage::Light distantLight(pelage::Light light, const Float3& center) {
  if (!light.hasPosition) return light;
  const Float3& p = light.position;
  light.direction = {p.x - center.x, p.y - center.y, p.z - center.z};
  const Float3& d = light.direction;
  const float square = d.x * d.x + d.y * d.y + d.z * d.z;
  light.color = {light.color.x / square, light.color.y / square, light.color.z / square};
  return light;
}

pelage::CollisionMesh meshOf(const pelage::CapsuleCollider& capsule) {
  return makeCapsule(capsule.head, capsule.headRadius, capsule.tail, capsule.tailRadius);
}

// A scene that lives for one picture.
class Stage {
 public:
  Stage(const Setup& setup, SubjectAssets assets) : setup_(setup), assets_(std::move(assets)) {}

  Result<void> build() {
    if (Result<void> done = addHair(); !done) return done;
    if (Result<void> done = addBodies(); !done) return done;
    return {};
  }

  // The passes of one frame; the first is 0.
  Result<void> advance(uint32_t frame, PassList& list) {
    const double seconds = (frame + 1) * static_cast<double>(setup_.frameSeconds);
    std::vector<AffineTransform> bones(assets_.boneCount);
    if (setup_.motion) bones.back() = setup_.motion(seconds);
    hair().setBones(bones);
    if (!setup_.hasField) hair().setColliders(setup_.capsules);
    if (Result<void> done = scene_.simulate(setup_.frameSeconds, list); !done) return done;
    if (body_) body_->setBones(bones);
    return {};
  }

  Result<void> draw(const pelage::View& view, std::vector<PassList>& lists) {
    std::vector<pelage::Light> lights = setup_.lights;
    if (lights.empty()) lights.push_back(studioLight(setup_.toEye));
    const pelage::Light distant = distantLight(lights[0], setup_.center);
    if (body_ && !setup_.drawsField)
      if (Result<void> done = body_->draw(view, distant, lists[0]); !done) return done;
    for (const MeshObject& object : stillObjects_)
      if (Result<void> done = object.draw(view, distant, lists[0]); !done) return done;
    if (setup_.drawsField)
      if (Result<void> done =
              scene_.drawCollider(*field_, view, lights[0], setup_.colliderLook, lists[0]);
          !done)
        return done;
    return scene_.draw(view, lights, setup_.transparency, lists);
  }

  Scene& scene() { return scene_; }

 private:
  HairObject& hair() { return scene_.hair(*hair_); }

  Result<void> addHair() {
    const pelage::HairAsset& asset = assets_.hair;
    const auto follow = asset.generateFollowHairs(setup_.follow);
    if (!follow) return follow.error();
    std::vector<pelage::StrandFactors> factors(asset.strandCount);
    for (size_t i = 0; i < factors.size(); i += 2)
      factors[i] = {setup_.strandStiffness, setup_.strandGlobalStiffness, setup_.strandDamping};
    const std::vector<pelage::Float4> texels = makeTexture(setup_.textureSize);
    pelage::HairDef def = setup_.hair;
    def.influences = assets_.influences;
    def.boneCount = assets_.boneCount;
    def.strandFactors = factors;
    def.followHairs = *follow;
    def.levelOfDetail = setup_.simulatedShare < 1;
    def.baseTexture = {setup_.textureSize, setup_.textureSize, texels};
    const auto added = scene_.addHair(asset, def);
    if (!added) return added.error();
    hair_ = *added;
    hair().simulatedShare = setup_.simulatedShare;
    hair().drawnShare = setup_.drawnShare;
    hair().usesMeshColliders = setup_.usesMeshColliders;
    hair().drawnStrands = static_cast<uint32_t>(
        std::lround(setup_.drawnStrands * static_cast<float>(hair().strandCount())));
    return {};
  }

  Result<void> addBodies() {
    if (assets_.body) {
      MeshDef def;
      def.name = "body";
      def.influences = assets_.body->influences;
      def.boneCount = assets_.boneCount;
      def.scalp = assets_.scalp;
      auto body = MeshObject::create(scene_.resources(), *assets_.body, def);
      if (!body) return body.error();
      body_ = *body;
      body_->material.scalp = setup_.hair.material.rootColor;
    }
    for (const pelage::CapsuleCollider& capsule : setup_.capsules)
      if (Result<void> done = addStill(meshOf(capsule)); !done) return done;
    if (!setup_.hasField) return {};
    const pelage::CollisionMesh mesh =
        setup_.capsules.empty() ? *assets_.body : meshOf(setup_.capsules[0]);
    pelage::SdfColliderDef def = setup_.collider;
    def.boneCount = assets_.boneCount;
    const auto added = scene_.addCollider(mesh, def);
    if (!added) return added.error();
    field_ = *added;
    scene_.collider(*field_).margin = setup_.margin;
    scene_.collider(*field_).friction = setup_.friction;
    return {};
  }

  Result<void> addStill(const pelage::CollisionMesh& mesh) {
    MeshDef def;
    def.name = "collider " + std::to_string(stillObjects_.size());
    auto object = MeshObject::create(scene_.resources(), mesh, def);
    if (!object) return object.error();
    object->material.skin = kSteel;
    stillObjects_.push_back(*object);
    return {};
  }

  const Setup& setup_;
  SubjectAssets assets_;
  Scene scene_;
  std::optional<pelage::HairId> hair_;
  std::optional<pelage::ColliderId> field_;
  std::optional<MeshObject> body_;
  std::vector<MeshObject> stillObjects_;
};

}  // namespace

Result<pelage::RenderedImage> render(const pelage::HeadlessDef& def, const Setup& setup,
                                     uint32_t size) {
  const auto made = createDevice(def);
  if (!made) return made.error();
  pelage::HeadlessDevice& device = **made;
  auto assets = makeSubject(setup);
  if (!assets) return assets.error();
  Stage stage(setup, std::move(*assets));
  if (Result<void> done = stage.build(); !done) return done.error();

  const uint32_t scale = setup.supersample;
  pelage::RenderTargetDef target;
  target.width = target.height = size * scale;
  target.samples = setup.samples;
  std::vector<PassList> lists(1);
  for (uint32_t frame = 0; frame < setup.frames; ++frame) {
    const bool last = frame + 1 == setup.frames;
    if (Result<void> done = stage.advance(frame, lists[0]); !done) return done.error();
    if (last)
      if (Result<void> done = stage.draw(viewOf(setup, size * scale), lists); !done)
        return done.error();
    for (PassList& list : lists) stage.scene().finish(list);
    if (Result<void> done = device.update(stage.scene().resources()); !done) return done.error();
    if (last) break;
    if (Result<void> done = device.execute(lists[0]); !done) return done.error();
  }
  std::vector<const PassList*> order;
  for (const PassList& list : lists) order.push_back(&list);
  auto image = device.render(order, target);
  if (!image) return image;
  pelage::RenderedImage result = boxDownsample(*image, scale);
  compositeOver(result, {.top = kPaper, .bottom = kPaper, .glow = 0});
  return result;
}

}  // namespace sample
