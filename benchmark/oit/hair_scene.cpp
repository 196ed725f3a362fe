#include "oit/hair_scene.h"

#include <cmath>
#include <utility>

#include "pelage/demo/character.h"

namespace bench {

using pelage::Float3;
using pelage::PassList;
using pelage::Result;

namespace {

// Grey, so that what comes through shows beside the mesh, too.
constexpr pelage::Float4 kBackground = {0.25f, 0.25f, 0.25f, 1};

// A camera from `eye` to `target`, of the lens of the study. The near plane is not nearer than need
// be, so that few fragments tie: for these there is more than one exact composite.
sample::Camera cameraAt(const Float3& eye, const Float3& target, float near) {
  constexpr float kFov = 0.785398f;
  return {.eye = eye, .target = target, .verticalFov = kFov, .near = near, .far = 50};
}

pelage::Light keyLight(const Float3& direction) {
  pelage::Light light;
  light.direction = direction;
  light.color = {1.32f, 1.24f, 1.12f};
  light.ambient = {0.19f, 0.22f, 0.27f};
  light.shadow = pelage::HairShadow::kDeep;
  return light;
}

}  // namespace

Result<std::optional<HairSceneDef>> mohawkScene(const std::filesystem::path& data) {
  const std::filesystem::path folder = data / "ratboy";
  const std::filesystem::path hair = folder / "Ratboy_mohawk.tfx";
  const std::filesystem::path body = folder / "Ratboy_body.tfxmesh";
  if (data.empty() || !std::filesystem::exists(hair) || !std::filesystem::exists(body))
    return std::optional<HairSceneDef>();
  auto asset = pelage::loadTfx(hair, {.repair = true});
  if (!asset) return asset.error();
  auto mesh = pelage::loadTfxMesh(body);
  if (!mesh) return mesh.error();
  HairSceneDef def;
  def.name = "mohawk";
  def.assets.name = hair.stem().string();
  def.assets.hair = std::move(*asset);
  if (Result<void> done = def.assets.hair.process(); !done) return done.error();
  def.assets.mesh = std::move(*mesh);
  // The figures of methods are of this model.
  def.material.model = pelage::ShadingModel::kKajiyaKay;
  def.material.rootColor = {0.26f, 0.17f, 0.11f};
  def.material.tipColor = {0.85f, 0.60f, 0.36f};
  def.material.fiberRadius = 1.4e-3f;
  def.material.tipRadiusRatio = 1;
  def.follow = {.countPerGuide = 16, .maxRadius = 0.012f, .tipSeparation = 3};
  def.light = keyLight({0.5f, 0.7f, 0.6f});
  def.whole = cameraAt({1.90f, 0.70f, 2.50f}, {0, 0.40f, 0}, 1.5f);
  def.close = cameraAt({0.70f, 0.95f, 0.95f}, {0, 0.78f, 0}, 0.5f);
  return std::optional(std::move(def));
}

Result<HairSceneDef> groomScene(uint32_t guides, float aspect) {
  pelage::GroomDef groom;
  groom.strandCount = guides;
  auto assets = sample::generateAssets(groom);
  if (!assets) return assets.error();
  HairSceneDef def;
  def.name = "groom";
  def.assets = std::move(*assets);
  def.material.model = pelage::ShadingModel::kKajiyaKay;
  def.material.rootColor = {0.10f, 0.045f, 0.02f};
  def.material.tipColor = {0.33f, 0.166f, 0.080f};
  def.material.fiberRadius = 115e-6f;
  def.follow = {.countPerGuide = 10, .maxRadius = 0.004f};
  def.light = keyLight({0.5f, 0.7f, 0.6f});
  std::vector<Float3> points;
  if (def.assets.mesh) points = def.assets.mesh->positions;
  for (const pelage::Float4& p : def.assets.hair.positions) points.push_back({p.x, p.y, p.z});
  sample::CameraDef camera;
  camera.direction = {0.40f, 0.16f, 1};
  def.whole = sample::frameAll(points, camera, aspect);
  def.close = def.whole;
  // The side of the head.
  def.close.target = {def.whole.target.x + 0.03f, def.whole.target.y + 0.05f, def.whole.target.z};
  def.close.verticalFov *= 0.4f;
  return def;
}

Result<HairSceneDef> characterScene(float aspect) {
  auto character = pelage::generateCharacter();
  if (!character) return character.error();
  pelage::CharacterGroom& hair = character->grooms[0];
  HairSceneDef def;
  def.name = "character";
  def.assets.name = def.name;
  def.assets.hair = std::move(hair.hair);
  if (Result<void> done = def.assets.hair.process(); !done) return done.error();
  def.assets.mesh = std::move(character->mesh);
  def.material = hair.material;
  def.follow = hair.follow;
  def.light = keyLight({0.5f, 0.7f, 0.6f});
  std::vector<Float3> points;
  for (const pelage::Float4& p : def.assets.hair.positions) points.push_back({p.x, p.y, p.z});
  sample::CameraDef camera;
  camera.direction = {0.40f, 0.16f, 1};
  def.whole = sample::frameAll(points, camera, aspect);
  def.close = def.whole;
  // The side of the head.
  def.close.target = {def.whole.target.x + 0.04f, def.whole.target.y + 0.03f, def.whole.target.z};
  def.close.verticalFov *= 0.4f;
  return def;
}

Result<std::unique_ptr<HairScene>> HairScene::create(const HairSceneDef& def,
                                                     pelage::HeadlessDevice& device) {
  std::unique_ptr<HairScene> made(new HairScene(device));
  made->light_ = def.light;
  const auto follow = def.assets.hair.generateFollowHairs(def.follow);
  if (!follow) return follow.error();
  pelage::HairDef hair;
  hair.name = def.name;
  hair.material = def.material;
  hair.settings.gravity = {0, 0, 0};
  hair.followHairs = *follow;
  const auto added = made->scene_.addHair(def.assets.hair, hair);
  if (!added) return added.error();
  made->hair_ = *added;
  if (def.assets.mesh) {
    sample::MeshDef mesh;
    mesh.name = def.name + "/mesh";
    auto object = sample::MeshObject::create(made->scene_.resources(), *def.assets.mesh, mesh);
    if (!object) return object.error();
    made->mesh_ = *object;
  }
  if (Result<void> done = made->settle(); !done) return done.error();
  return made;
}

// One step without gravity leaves the bind pose, and fills what the drawing reads.
Result<void> HairScene::settle() {
  PassList list;
  if (Result<void> done = scene_.simulate(1.0f / 60, list); !done) return done;
  const pelage::AffineTransform bone;
  if (mesh_) mesh_->setBones({&bone, 1});
  scene_.finish(list);
  if (Result<void> done = device_.update(scene_.resources()); !done) return done;
  return device_.execute(list);
}

Result<void> HairScene::draw(const pelage::View& view, const pelage::TransparencySettings& settings,
                             std::vector<PassList>& lists) {
  if (lists.empty()) lists.resize(1);
  lists[0].clear();
  // Another frame: each method is measured with its shadow maps.
  PassList begin;
  if (Result<void> done = scene_.simulate(0, begin); !done) return done;
  if (mesh_)
    if (Result<void> done = mesh_->draw(view, light_, lists[0]); !done) return done;
  return scene_.draw(view, {&light_, 1}, settings, lists);
}

Result<pelage::RenderedImage> HairScene::render(std::vector<PassList>& lists,
                                                const pelage::View& view,
                                                pelage::BufferId depthCopy,
                                                std::vector<pelage::PassTiming>* timings,
                                                int times) {
  // Each list runs once.
  std::vector<PassList> runs;
  for (int i = 0; i < times; ++i) runs.insert(runs.end(), lists.begin(), lists.end());
  std::vector<const PassList*> pointers;
  for (PassList& list : runs) {
    scene_.finish(list);
    pointers.push_back(&list);
  }
  if (Result<void> done = device_.update(scene_.resources()); !done) return done.error();
  pelage::RenderTargetDef target;
  target.width = view.width;
  target.height = view.height;
  target.samples = view.samples;
  target.clearColor = kBackground;
  target.depthCopy = depthCopy;
  return device_.render(pointers, target, timings);
}

}  // namespace bench
