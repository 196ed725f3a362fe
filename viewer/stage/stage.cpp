#include "stage/stage.h"

#include <algorithm>
#include <span>
#include <utility>

#include "demo_assets.h"
#include "stage/stage_settings.h"

namespace viewer {

using pelage::BufferId;
using pelage::Error;
using pelage::ErrorCode;
using pelage::Result;

namespace {

constexpr uint64_t kMaxTransparencyBytes = uint64_t{2} << 30;
constexpr uint64_t kMeasureEvery = 60;  // frames
constexpr uint64_t kInspectEvery = 15;  // frames

}  // namespace

Result<sample::DemoScene> Stage::make(const StageSource& source, LoadedFiles& loaded) {
  sample::DemoDef def;
  def.scene = &scene_;
  def.solver = source.solver;
  def.motion = look.motion;
  def.wind = look.wind;
  def.preset = source.preset;
  def.headCollider = source.headCollider;
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
  auto files = loadFiles(source.files, source.scale, source.clip);
  if (!files) return files.error();
  loaded = *std::move(files);
  return sample::DemoScene::create(sample::FileAssets{loaded.assets, loaded.motion}, def);
}

Result<void> Stage::show(const StageSource& source) {
  LoadedFiles loaded;
  auto demo = make(source, loaded);
  if (!demo) return demo.error();
  pull.release(scene_);
  if (right_) (void)compare(std::nullopt);
  inspections_[0].clear(scene_);
  demo_.reset();  // removes what it has in the scene
  demo_.emplace(*std::move(demo));
  loaded.assets = {};
  loaded_ = std::move(loaded);
  source_ = source;
  ++shown_[0];
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

bool Stage::resetTarget() {
  const pelage::ViewSettings before = std::exchange(viewSettings, {});
  return before.samples != viewSettings.samples ||
         before.reversedDepth != viewSettings.reversedDepth;
}

// What changed since the last frame.
void Stage::applyLook(uint32_t width, uint32_t height) {
  const bool resized = width != width_ || height != height_;
  if (applied_ == look && !resized) return;
  for (uint32_t side = 0; side < sides(); ++side) {
    sample::DemoScene& demo = demoOf(side);
    if (!applied_ || applied_->motion != look.motion) demo.setMotion(look.motion);
    for (const pelage::HairId hair : demo.hairs()) {
      if (applied_ && !(applied_->wind == look.wind))
        scene_.hair(hair).settings.wind.velocity = look.wind;
      scene_.hair(hair).drawnShare = look.strandShare;
    }
    demo.light.shadow = look.shadow;
  }
  const bool method = !applied_ || applied_->transparency != look.transparency;
  if (method || resized) {
    transparency_.method = look.transparency;
    transparency_.nodeCount = 0;
    frame_ = 0;
    makeDepthBuffers(width, height);
    scene_.trim();
  }
  applied_ = look;
  width_ = width;
  height_ = height;
}

// For methods that want the depth of opaque things; a side has a share of the window.
void Stage::makeDepthBuffers(uint32_t width, uint32_t height) {
  for (BufferId& buffer : depthBuffers_) {
    if (buffer != BufferId::kInvalid) scene_.resources().remove(buffer);
    buffer = BufferId::kInvalid;
  }
  if (look.transparency != pelage::Transparency::kTiles) return;
  for (uint32_t side = 0; side < sides(); ++side)
    depthBuffers_[side] = demo_->addDepthBuffer(std::max(width / sides(), 1u), height);
}

Result<pelage::Frame> Stage::makeFrame(double realSeconds, uint32_t width, uint32_t height) {
  if (look.transparency == pelage::Transparency::kTiles && viewSettings.samples > 1)
    return Error{ErrorCode::kUnsupported,
                 "view.samples is " + std::to_string(viewSettings.samples) +
                     ", but the method tiles reads the depth of meshes, which the viewer copies "
                     "from targets of 1 sample a pixel"};
  applyLook(width, height);
  if (!(inspectionBefore_ == inspection)) {
    for (Inspection& of : inspections_)
      hasPasses(inspection.value) ? of.forget() : of.clear(scene_);
    inspectedFrames_ = 0;
  }
  inspectionBefore_ = inspection;
  const double seconds = clock.advance(realSeconds, demo_->cycle());
  pelage::CapsuleCollider sphere;
  sphere.head = sphere.tail = ball.center;
  sphere.headRadius = sphere.tailRadius = ball.radius;
  for (uint32_t side = 0; side < sides(); ++side)
    demoOf(side).pose(clock.time, {&sphere, ball.present ? size_t{1} : size_t{0}});
  auto frame = scene_.simulate(static_cast<float>(seconds));
  if (!frame) return frame;
  if (pull.holds())
    if (Result<void> done = pull.record(scene_, frame->addListBefore()); !done) return done.error();
  ++frame_;
  views_.clear();
  for (uint32_t side = 0; side < sides(); ++side)
    if (Result<void> done = drawSide(side, ball.present ? &sphere : nullptr, *frame); !done)
      return done.error();
  return frame;
}

// Hides the hair of the other side, and all of it where something else is drawn of it.
std::vector<bool> Stage::showHair(uint32_t side) {
  std::vector<bool> visible;
  for (uint32_t s = 0; s < sides(); ++s) {
    for (const pelage::HairId hair : demoOf(s).hairs()) {
      bool& shown = scene_.hair(hair).visible;
      visible.push_back(shown);
      shown = shown && s == side && drawsHair(inspection.value);
    }
  }
  return visible;
}

void Stage::restoreHair(const std::vector<bool>& visible) {
  size_t at = 0;
  for (uint32_t s = 0; s < sides(); ++s)
    for (const pelage::HairId hair : demoOf(s).hairs()) scene_.hair(hair).visible = visible[at++];
}

Result<void> Stage::drawSide(uint32_t side, const pelage::CapsuleCollider* ballShape,
                             pelage::Frame& frame) {
  sample::DemoScene& demo = demoOf(side);
  const uint32_t width = std::max(width_ / sides(), 1u);
  pelage::View view = camera.view(width, height_, viewSettings.reversedDepth);
  apply(viewSettings, view);
  view.x = static_cast<float>(side * width);
  const Inspected what = {
      &scene_, &demo, clock.time, {ballShape, ballShape != nullptr ? size_t{1} : size_t{0}}};
  const std::vector<bool> visible = showHair(side);
  pelage::PassList before;
  Result<void> done = drawsMeshes(inspection.value) ? demo.drawOpaque(view, before)
                      : inspection.value == InspectedValue::kSdfSurface
                          ? Inspection::drawSurfaces(what, view, before)
                          : Result<void>();
  if (done && ballShape != nullptr)
    done = ballMesh_.draw(ball.center, ball.radius, view, demo.light, scene_.resources(), before);
  if (done) {
    transparency_.opaqueDepth = depthBuffers_[side];
    const auto drawn = frame.draw(view, lightsOf(side), transparency_, std::move(before));
    if (!drawn) done = drawn.error();
  }
  restoreHair(visible);
  const uint32_t first = static_cast<uint32_t>(views_.size());
  if (done) done = inspections_[side].draw(inspection, what, view, frame);
  if (done) done = drawContacts(side, view, frame);
  if (!done) return done;
  views_.resize(frame.viewCount(), {{side * width, 0, width, height_}, BufferId::kInvalid});
  views_[first].depthCopy = depthBuffers_[side];
  return {};
}

Result<void> Stage::drawContacts(uint32_t side, const pelage::View& view, pelage::Frame& frame) {
  if (!look.showsContacts) return {};
  pelage::PassList list;
  for (const pelage::HairId hair : demoOf(side).hairs())
    if (Result<void> done = scene_.drawContacts(hair, view, contactLook, list); !done) return done;
  const auto added = frame.addView(std::move(list));
  if (!added) return added.error();
  return {};
}

// Hair of one side passes through the meshes of the other.
void Stage::separateColliders() {
  for (uint32_t side = 0; side < sides(); ++side)
    for (const pelage::HairId hair : demoOf(side).hairs())
      right_ ? scene_.hair(hair).setMeshColliders(demoOf(side).colliders())
             : scene_.hair(hair).useAllMeshColliders();
}

// The object is another one then, for which the other side's meshes have to be left out again.
Result<void> Stage::makeHairAgain(size_t hair, const sample::DemoScene::HairMaking& making) {
  pull.release(scene_);
  inspections_[side_].clear(scene_);
  Result<void> made = demoOf(side_).makeHairAgain(hair, making);
  if (right_) separateColliders();
  return made;
}

Result<void> Stage::compare(std::optional<pelage::Solver> right) {
  pull.release(scene_);
  if (right) {
    StageSource source = source_;
    source.solver = *right;
    source.scale = loaded_.scale;
    LoadedFiles loaded;
    auto demo = make(source, loaded);
    if (!demo) return demo.error();
    side_ = 0;
    const auto settings = settingsOfAll();
    inspections_[1].clear(scene_);
    right_.reset();
    right_.emplace(*std::move(demo));
    rightSolver_ = *right;
    if (Result<void> done = takeSettings(settings); !done) return done;
    ++shown_[1];
  } else {
    inspections_[1].clear(scene_);
    right_.reset();
    side_ = 0;
  }
  separateColliders();
  applied_.reset();
  reset();
  return {};
}

std::vector<pelage::SceneSettings> Stage::settingsOfAll() const {
  std::vector<pelage::SceneSettings> settings;
  for (size_t i = 0; i < hairs().size(); ++i) settings.push_back(settingsOf(*this, i));
  return settings;
}

// The right side begins with these; another solver keeps what it is set to be for the scene.
Result<void> Stage::takeSettings(const std::vector<pelage::SceneSettings>& left) {
  side_ = 1;
  Result<void> done;
  for (size_t i = 0; i < left.size() && done; ++i) {
    pelage::SceneSettings settings = left[i];
    if (rightSolver_ != source_.solver) settings.simulation = scene_.hair(hairs()[i]).settings;
    settings.simulation.wind = left[i].simulation.wind;
    done = apply(settings, i, *this);
  }
  side_ = 0;
  return done;
}

pelage::Solver Stage::solverOf(uint32_t side) const {
  return side == 0 ? source_.solver : rightSolver_;
}

Result<StageStatistics> Stage::statistics(const pelage::BufferReader& read) const {
  StageStatistics statistics;
  auto counted = hairStatistics(scene_, hairs(), read);
  if (!counted) return counted.error();
  statistics.hairs = *std::move(counted);
  statistics.colliders = colliderStatistics(scene_, colliders());
  const BufferId counters = scene_.transparencyCounters();
  const bool counts = transparency_.method == pelage::Transparency::kWindowed ||
                      transparency_.method == pelage::Transparency::kTiles;
  if (!counts || counters == BufferId::kInvalid) return statistics;
  const auto words = read(counters);
  if (!words) return words.error();
  const auto plan = planView();
  if (!plan) return plan.error();
  statistics.transparency = pelage::readTransparencyCounters(*words, plan->nodeCount);
  return statistics;
}

// Of the transparency of one side.
Result<pelage::TransparencyPlan> Stage::planView() const {
  return pelage::planTransparency(std::max(width_ / sides(), 1u), height_, transparency_,
                                  demo_->vertexCount());
}

Result<void> Stage::measure(const pelage::BufferReader& read) {
  if (pull.isAsked())
    if (Result<void> done = pull.take(scene_, hairs(), read); !done) return done;
  // The lists and tiles of the next frame have room for what this one wanted.
  const bool grows = transparency_.method == pelage::Transparency::kWindowed ||
                     transparency_.method == pelage::Transparency::kTiles;
  if (inspectedFrames_++ % kInspectEvery == 0)
    for (uint32_t side = 0; side < sides(); ++side)
      if (Result<void> done = inspections_[side].measure(inspection, read); !done) return done;
  const BufferId counters = scene_.transparencyCounters();
  if (!grows || counters == BufferId::kInvalid || frame_ % kMeasureEvery != 1) return {};
  const auto words = read(counters);
  if (!words) return words.error();
  const auto plan = planView();
  if (!plan) return plan.error();
  transparency_.nodeCount =
      pelage::growNodes(pelage::readTransparencyCounters(*words, plan->nodeCount), plan->nodeCount);
  return {};
}

std::vector<pelage::Light> Stage::lightsOf(uint32_t side) const {
  const sample::DemoScene& demo = demoOf(side);
  std::vector<pelage::Light> lights = {demo.light};
  lights.insert(lights.end(), demo.moreLights.begin(), demo.moreLights.end());
  return lights;
}

void Stage::setLights(const std::vector<pelage::Light>& lights) {
  sample::DemoScene& demo = demoOf(side_);
  demo.light = {.color = {}, .ambient = {}};
  if (!lights.empty()) demo.light = lights[0];
  demo.moreLights.assign(lights.begin() + (lights.empty() ? 0 : 1), lights.end());
}

void Stage::setTransparency(const pelage::TransparencySettings& settings) {
  transparency_ = settings;
  look.transparency = settings.method;
  frame_ = 0;
}

void Stage::frameAll(float aspect) {
  camera.frame(applied_ ? demo_->cameraFrom(camera.direction(), aspect) : demo_->camera(aspect));
}

void Stage::reset() {
  clock.time = 0;
  for (uint32_t side = 0; side < sides(); ++side) {
    for (const pelage::HairId hair : demoOf(side).hairs()) scene_.hair(hair).reset();
    for (const pelage::ColliderId collider : demoOf(side).colliders())
      scene_.collider(collider).reset();
  }
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
