#include "stage/stage.h"

#include <algorithm>
#include <span>
#include <utility>

#include "demo_assets.h"

namespace viewer {

using pelage::BufferId;
using pelage::Error;
using pelage::ErrorCode;
using pelage::Result;

namespace {

constexpr uint64_t kMaxTransparencyBytes = uint64_t{2} << 30;
constexpr uint64_t kMeasureEvery = 60;  // frames

}  // namespace

Result<sample::DemoScene> Stage::make(const StageSource& source, LoadedFiles& loaded) {
  sample::DemoDef def;
  def.scene = &scene_;
  def.solver = source.solver;
  def.motion = look.motion;
  def.wind = look.wind;
  def.preset = source.preset;
  if (source.kind == StageKind::kCharacter) {
    const auto character = pelage::generateCharacter();
    if (!character) return character.error();
    return sample::DemoScene::create(*character, def);
  }
  if (source.kind == StageKind::kHead) {
    const auto assets = sample::generateAssets(sample::presetLook(source.preset).groom);
    if (!assets) return assets.error();
    return sample::DemoScene::create(*assets, def);
  }
  auto files = loadFiles(source.files, source.scale);
  if (!files) return files.error();
  loaded = *std::move(files);
  return sample::DemoScene::create(sample::FileAssets{loaded.assets, {}}, def);
}

Result<void> Stage::show(const StageSource& source) {
  LoadedFiles loaded;
  auto demo = make(source, loaded);
  if (!demo) return demo.error();
  pull.release(scene_);
  demo_.reset();  // removes what it has in the scene
  demo_.emplace(*std::move(demo));
  loaded.assets = {};
  loaded_ = std::move(loaded);
  source_ = source;
  ++shown_;
  applied_.reset();
  clock.time = 0;
  return {};
}

void Stage::setDevice(const StageDevice& device) {
  device_ = device;
  scene_.setTier(device.tier);
  resetMemory();
}

bool Stage::resetMemory() {
  const bool had = transparency_.maxBytes >= kMaxTransparencyBytes &&
                   transparency_.maxBufferBytes >= device_.maxBufferBytes;
  transparency_.maxBytes = kMaxTransparencyBytes;
  transparency_.maxBufferBytes = device_.maxBufferBytes;
  return !had;
}

// What changed since the last frame.
void Stage::applyLook(uint32_t width, uint32_t height) {
  const bool resized = width != width_ || height != height_;
  if (applied_ == look && !resized) return;
  if (!applied_ || applied_->motion != look.motion) demo_->setMotion(look.motion);
  if (applied_ && !(applied_->wind == look.wind))
    for (const pelage::HairId hair : hairs()) scene_.hair(hair).settings.wind.velocity = look.wind;
  for (const pelage::HairId hair : hairs()) scene_.hair(hair).drawnShare = look.strandShare;
  demo_->light.shadow = look.shadow;
  const bool method = !applied_ || applied_->transparency != look.transparency;
  if (method || resized) {
    transparency_.method = look.transparency;
    transparency_.nodeCount = 0;
    frame_ = 0;
    if (depthBuffer_ != BufferId::kInvalid) scene_.resources().remove(depthBuffer_);
    depthBuffer_ = BufferId::kInvalid;
    if (look.transparency == pelage::Transparency::kTiles)
      depthBuffer_ = demo_->addDepthBuffer(width, height);
    transparency_.opaqueDepth = depthBuffer_;
    scene_.trim();
  }
  applied_ = look;
  width_ = width;
  height_ = height;
}

Result<pelage::Frame> Stage::makeFrame(double realSeconds, uint32_t width, uint32_t height) {
  applyLook(width, height);
  const double seconds = clock.advance(realSeconds, demo_->cycle());
  pelage::CapsuleCollider sphere;
  sphere.head = sphere.tail = ball.center;
  sphere.headRadius = sphere.tailRadius = ball.radius;
  demo_->pose(clock.time, {&sphere, ball.present ? size_t{1} : size_t{0}});
  auto frame = scene_.simulate(static_cast<float>(seconds));
  if (!frame) return frame;
  if (pull.holds())
    if (Result<void> done = pull.record(scene_, frame->addListBefore()); !done) return done.error();
  ++frame_;
  const pelage::View view = camera.view(width, height);
  pelage::PassList before;
  if (Result<void> done = demo_->drawOpaque(view, before); !done) return done.error();
  if (ball.present) {
    Result<void> done =
        ballMesh_.draw(ball.center, ball.radius, view, demo_->light, scene_.resources(), before);
    if (!done) return done.error();
  }
  const auto drawn = frame->draw(view, lights(), transparency_, std::move(before));
  if (!drawn) return drawn.error();
  if (Result<void> done = drawContacts(view, *frame); !done) return done.error();
  return frame;
}

Result<void> Stage::drawContacts(const pelage::View& view, pelage::Frame& frame) {
  if (!look.showsContacts) return {};
  pelage::PassList list;
  for (const pelage::HairId hair : hairs())
    if (Result<void> done = scene_.drawContacts(hair, view, contactLook, list); !done) return done;
  const auto added = frame.addView(std::move(list));
  if (!added) return added.error();
  return {};
}

Result<void> Stage::measure(const pelage::BufferReader& read) {
  if (pull.isAsked())
    if (Result<void> done = pull.take(scene_, hairs(), read); !done) return done;
  // The lists and tiles of the next frame have room for what this one wanted.
  const bool grows = transparency_.method == pelage::Transparency::kWindowed ||
                     transparency_.method == pelage::Transparency::kTiles;
  const BufferId counters = scene_.transparencyCounters();
  if (!grows || counters == BufferId::kInvalid || frame_ % kMeasureEvery != 1) return {};
  const auto words = read(counters);
  if (!words) return words.error();
  const auto plan = pelage::planTransparency(width_, height_, transparency_, demo_->vertexCount());
  if (!plan) return plan.error();
  transparency_.nodeCount =
      pelage::growNodes(pelage::readTransparencyCounters(*words, plan->nodeCount), plan->nodeCount);
  return {};
}

std::vector<pelage::Light> Stage::lights() const {
  std::vector<pelage::Light> lights = {demo_->light};
  lights.insert(lights.end(), demo_->moreLights.begin(), demo_->moreLights.end());
  return lights;
}

void Stage::setLights(const std::vector<pelage::Light>& lights) {
  demo_->light = {.color = {}, .ambient = {}};
  if (!lights.empty()) demo_->light = lights[0];
  demo_->moreLights.assign(lights.begin() + (lights.empty() ? 0 : 1), lights.end());
}

void Stage::setTransparency(const pelage::TransparencySettings& settings) {
  transparency_ = settings;
  transparency_.opaqueDepth = depthBuffer_;
  look.transparency = settings.method;
  frame_ = 0;
}

void Stage::frameAll(float aspect) {
  camera.frame(applied_ ? demo_->cameraFrom(camera.direction(), aspect) : demo_->camera(aspect));
}

void Stage::reset() {
  clock.time = 0;
  for (const pelage::HairId hair : hairs()) scene_.hair(hair).reset();
  for (const pelage::ColliderId collider : demo_->colliders()) scene_.collider(collider).reset();
}

Result<void> Stage::takeSnapshot(const pelage::BufferReader& read) {
  auto snapshot = scene_.takeSnapshot(read);
  if (!snapshot) return snapshot.error();
  snapshot_ = *std::move(snapshot);
  return {};
}

Result<uint32_t> Stage::recover() {
  frame_ = 0;
  auto kept = scene_.recover(snapshot_.value_or(pelage::SceneSnapshot{}));
  snapshot_.reset();
  return kept;
}

}  // namespace viewer
