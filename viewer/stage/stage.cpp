#include "stage/stage.h"

#include <algorithm>
#include <cmath>
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

Result<sample::DemoScene> makeDemo(const StageSource& source, const StageLook& look,
                                   pelage::Scene& scene, LoadedFiles& loaded) {
  sample::DemoDef def;
  def.scene = &scene;
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

// Makes the depth buffers of methods that read the depth of meshes; a side has a share of the
// window.
void makeDepthBuffers(pelage::Transparency method, uint32_t width, uint32_t height,
                      pelage::Scene& scene, std::span<StageSide> sides) {
  const uint32_t shown = sides[1].demo ? 2 : 1;
  for (StageSide& side : sides) {
    if (side.depth != BufferId::kInvalid) scene.resources().remove(side.depth);
    side.depth = BufferId::kInvalid;
  }
  if (method != pelage::Transparency::kTiles) return;
  for (StageSide& side : sides.first(shown))
    side.depth = sides[0].demo->addDepthBuffer(std::max(width / shown, 1u), height);
}

// Hides the hair of the other side, and all hair where a view of errors draws it. \return the
// visibility until now, for restoreHair().
std::vector<bool> showHair(const StageSide& chosen, bool drawsIt, std::span<const StageSide> sides,
                           pelage::Scene& scene) {
  std::vector<bool> visible;
  for (const StageSide& side : sides) {
    for (const pelage::HairId hair : side.demo->drawnHairs()) {
      bool& shown = scene.hair(hair).visible;
      visible.push_back(shown);
      shown = shown && &side == &chosen && drawsIt;
    }
  }
  return visible;
}

void restoreHair(const std::vector<bool>& visible, std::span<const StageSide> sides,
                 pelage::Scene& scene) {
  size_t at = 0;
  for (const StageSide& side : sides)
    for (const pelage::HairId hair : side.demo->drawnHairs())
      scene.hair(hair).visible = visible[at++];
}

// Makes hair of one side pass through the meshes of the other.
void separateColliders(std::span<const StageSide> sides, pelage::Scene& scene) {
  for (const StageSide& side : sides)
    for (const pelage::HairId hair : side.demo->hairs())
      sides.size() > 1 ? scene.hair(hair).setMeshColliders(side.demo->colliders())
                       : scene.hair(hair).useAllMeshColliders();
}

Result<void> drawContacts(const sample::DemoScene& demo, const pelage::View& view,
                          const pelage::ContactLook& look, pelage::Scene& scene,
                          pelage::Frame& frame) {
  pelage::PassList list;
  for (const pelage::HairId hair : demo.hairs())
    if (Result<void> done = scene.drawContacts(hair, view, look, list); !done) return done;
  const auto added = frame.addView(std::move(list));
  if (!added) return added.error();
  return {};
}

std::vector<pelage::Light> lightsOf(const sample::DemoScene& demo) {
  std::vector<pelage::Light> lights = {demo.light};
  lights.insert(lights.end(), demo.moreLights.begin(), demo.moreLights.end());
  return lights;
}

std::vector<pelage::SceneSettings> settingsOfAll(const Stage& stage) {
  std::vector<pelage::SceneSettings> settings;
  for (size_t i = 0; i < stage.hairs().size(); ++i) settings.push_back(settingsOf(stage, i));
  return settings;
}

// Gives the settings of the left side to the right one; another solver keeps its own simulation.
Result<void> takeSettings(const std::vector<pelage::SceneSettings>& left, Stage& stage) {
  stage.chooseSide(1);
  Result<void> done;
  for (size_t i = 0; i < left.size() && done; ++i) {
    pelage::SceneSettings settings = left[i];
    if (stage.solverOf(1) != stage.solverOf(0))
      settings.simulation = stage.scene().hair(stage.hairs()[i]).settings;
    settings.simulation.wind = left[i].simulation.wind;
    done = apply(settings, i, stage);
  }
  stage.chooseSide(0);
  return done;
}

}  // namespace

double PlayClock::advance(double realSeconds, const pelage::CharacterCycle& cycle) {
  double seconds = 0;
  if (steps) {
    playing = false;
    seconds = kStep * std::min(speed, 1.0);
  } else if (playing) {
    seconds = speed * (fixed ? kStep : std::max(realSeconds, 0.0));
  }
  steps = false;
  seconds = std::min(seconds, kLongest);
  time += seconds;
  const double length = cycle.end - cycle.start;
  if (!(length > 0) || time < cycle.end) return seconds;
  if (loops) {
    time = cycle.start + std::fmod(time - cycle.start, length);
  } else {
    seconds = std::max(seconds - (time - cycle.end), 0.0);
    time = cycle.end;
    playing = false;
  }
  return seconds;
}

void StageTransparency::set(const pelage::TransparencySettings& settings) {
  settings_ = settings;
  forgetFrames();
}

void StageTransparency::setDevice(uint64_t maxBufferBytes) {
  maxBufferBytes_ = maxBufferBytes;
  resetMemory();
}

bool StageTransparency::resetMemory() {
  const bool had =
      settings_.maxBytes >= kMaxTransparencyBytes && settings_.maxBufferBytes >= maxBufferBytes_;
  settings_.maxBytes = kMaxTransparencyBytes;
  settings_.maxBufferBytes = maxBufferBytes_;
  return !had;
}

void StageTransparency::restart(pelage::Transparency method) {
  settings_.method = method;
  settings_.nodeCount = 0;
  forgetFrames();
}

void StageTransparency::beginFrame(uint32_t width, uint32_t height, uint64_t strandVertices) {
  width_ = width;
  height_ = height;
  strandVertices_ = strandVertices;
  ++frame_;
}

Result<std::optional<StageTransparency::Counted>> StageTransparency::count(
    const pelage::Scene& scene, const pelage::BufferReader& read) const {
  const BufferId counters = scene.transparencyCounters();
  const bool counts = settings_.method == pelage::Transparency::kWindowed ||
                      settings_.method == pelage::Transparency::kTiles;
  if (!counts || counters == BufferId::kInvalid) return std::optional<Counted>();
  const auto words = read(counters);
  if (!words) return words.error();
  const auto plan = pelage::planTransparency(width_, height_, settings_, strandVertices_);
  if (!plan) return plan.error();
  return std::optional(
      Counted{pelage::readTransparencyCounters(*words, plan->nodeCount), plan->nodeCount});
}

Result<void> StageTransparency::measure(const pelage::Scene& scene,
                                        const pelage::BufferReader& read) {
  if (frame_ % kMeasureEvery != 1) return {};
  const auto counted = count(scene, read);
  if (!counted) return counted.error();
  if (*counted)
    settings_.nodeCount = pelage::growNodes((*counted)->counters, (*counted)->nodeCount);
  return {};
}

Result<void> Stage::show(const StageSource& source) {
  LoadedFiles loaded;
  auto demo = makeDemo(source, look, scene_, loaded);
  if (!demo) return demo.error();
  pull.release(scene_);
  if (sides() == 2) (void)compare(std::nullopt);
  StageSide& left = sides_[0];
  left.inspection.clear(scene_);
  left.demo.reset();  // its objects leave the scene
  left.demo.emplace(*std::move(demo));
  left.solver = source.solver;
  left.environment = left.demo->light.environment;
  ++left.shown;
  loaded.assets = {};
  loaded_ = std::move(loaded);
  source_ = source;
  applied_.reset();
  clock.time = 0;
  return {};
}

void Stage::setDevice(const StageDevice& device) {
  scene_.setTier(device.tier);
  transparency.setDevice(device.maxBufferBytes);
}

bool Stage::resetTarget() {
  const pelage::ViewSettings before = std::exchange(viewSettings, {});
  return before.samples != viewSettings.samples ||
         before.reversedDepth != viewSettings.reversedDepth;
}

// Applies the changes of the look since the last frame to all hair.
void Stage::applyLook(uint32_t width, uint32_t height) {
  const bool resized = !applied_ || width != applied_->width || height != applied_->height;
  if (!resized && applied_->look == look) return;
  for (StageSide& side : std::span(sides_).first(sides())) {
    if (!applied_ || applied_->look.motion != look.motion) side.demo->setMotion(look.motion);
    for (const pelage::HairId hair : side.demo->hairs())
      if (applied_ && !(applied_->look.wind == look.wind))
        scene_.hair(hair).settings.wind.velocity = look.wind;
    side.demo->setShadow(look.shadow);
  }
  if (resized || applied_->look.transparency != look.transparency) {
    transparency.restart(look.transparency);
    makeDepthBuffers(look.transparency, width, height, scene_, sides_);
    scene_.trim();
  }
  applied_ = {look, width, height};
}

Result<pelage::Frame> Stage::makeFrame(double realSeconds, uint32_t width, uint32_t height) {
  if (look.transparency == pelage::Transparency::kTiles && viewSettings.samples > 1)
    return Error{ErrorCode::kUnsupported,
                 "view.samples is " + std::to_string(viewSettings.samples) +
                     ", but the method tiles reads the depth of meshes, which the viewer copies "
                     "from targets of 1 sample a pixel"};
  applyLook(width, height);
  for (StageSide& side : sides_) side.inspection.follow(inspection, scene_);
  const double seconds = clock.advance(realSeconds, sides_[0].demo->cycle());
  pelage::CapsuleCollider sphere;
  sphere.head = sphere.tail = ball.center;
  sphere.headRadius = sphere.tailRadius = ball.radius;
  for (StageSide& side : std::span(sides_).first(sides()))
    side.demo->pose(clock.time, {&sphere, ball.present ? size_t{1} : size_t{0}});
  auto frame = scene_.simulate(static_cast<float>(seconds));
  if (!frame) return frame;
  if (pull.holds())
    if (Result<void> done = pull.record(scene_, frame->addListBefore()); !done) return done.error();
  transparency.beginFrame(std::max(width / sides(), 1u), height, sides_[0].demo->vertexCount());
  views_.clear();
  for (uint32_t side = 0; side < sides(); ++side)
    if (Result<void> done = drawSide(side, ball.present ? &sphere : nullptr, *frame); !done)
      return done.error();
  return frame;
}

Result<void> Stage::drawSide(uint32_t index, const pelage::CapsuleCollider* ballShape,
                             pelage::Frame& frame) {
  const std::span<StageSide> shown = std::span(sides_).first(sides());
  StageSide& side = shown[index];
  sample::DemoScene& demo = *side.demo;
  const uint32_t width = std::max(applied_->width / sides(), 1u), height = applied_->height;
  pelage::View view = camera.view(width, height, viewSettings.reversedDepth);
  apply(viewSettings, view);
  view.x = static_cast<float>(index * width);
  const Inspected what = {
      &scene_, &demo, clock.time, {ballShape, ballShape != nullptr ? size_t{1} : size_t{0}}};
  const std::vector<bool> visible = showHair(side, drawsHair(inspection.value), shown, scene_);
  demo.setDetail(view, look.detailPixels, look.strandShare);
  pelage::PassList before;
  Result<void> done = drawsMeshes(inspection.value) ? demo.drawOpaque(view, before)
                      : inspection.value == InspectedValue::kSdfSurface
                          ? Inspection::drawSurfaces(what, colliderLook, view, before)
                          : Result<void>();
  if (done && look.showsGround && drawsMeshes(inspection.value))
    done = groundMesh_.draw(demo, view, scene_.resources(), before);
  if (done && ballShape != nullptr)
    done = ballMesh_.draw(ball.center, ball.radius, view, demo.light, scene_.resources(), before);
  if (done) {
    transparency.setDepth(side.depth);
    const auto drawn = frame.draw(view, lightsOf(demo), transparency.settings(), std::move(before));
    if (!drawn) done = drawn.error();
  }
  restoreHair(visible, shown, scene_);
  const uint32_t first = static_cast<uint32_t>(views_.size());
  if (done) done = side.inspection.draw(what, view, frame);
  if (done && look.showsContacts) done = drawContacts(demo, view, contactLook, scene_, frame);
  if (!done) return done;
  views_.resize(frame.viewCount(), {{index * width, 0, width, height}, BufferId::kInvalid});
  views_[first].depthCopy = side.depth;
  return {};
}

Result<void> Stage::makeHairAgain(size_t hair, const sample::DemoScene::HairMaking& making) {
  pull.release(scene_);
  StageSide& side = sides_[side_];
  side.inspection.clear(scene_);
  Result<void> made = side.demo->makeHairAgain(hair, making);
  // The new object collides with all meshes at first.
  if (sides() == 2) separateColliders(sides_, scene_);
  return made;
}

Result<void> Stage::compare(std::optional<pelage::Solver> right) {
  pull.release(scene_);
  StageSide& side = sides_[1];
  if (right) {
    StageSource source = source_;
    source.solver = *right;
    source.scale = loaded_.scale;
    LoadedFiles loaded;
    auto demo = makeDemo(source, look, scene_, loaded);
    if (!demo) return demo.error();
    side_ = 0;
    const auto settings = settingsOfAll(*this);
    side.inspection.clear(scene_);
    side.demo.reset();
    side.demo.emplace(*std::move(demo));
    side.solver = *right;
    side.environment = side.demo->light.environment;
    if (Result<void> done = takeSettings(settings, *this); !done) return done;
    ++side.shown;
  } else {
    side.inspection.clear(scene_);
    side.demo.reset();
    side_ = 0;
  }
  separateColliders(std::span(sides_).first(sides()), scene_);
  applied_.reset();
  reset();
  return {};
}

Result<StageStatistics> Stage::statistics(const pelage::BufferReader& read) const {
  StageStatistics statistics;
  auto counted = hairStatistics(scene_, hairs(), read);
  if (!counted) return counted.error();
  statistics.hairs = *std::move(counted);
  statistics.colliders = colliderStatistics(scene_, colliders());
  const auto fragments = transparency.count(scene_, read);
  if (!fragments) return fragments.error();
  if (*fragments) statistics.transparency = (*fragments)->counters;
  return statistics;
}

Result<void> Stage::measure(const pelage::BufferReader& read) {
  if (pull.isAsked())
    if (Result<void> done = pull.take(scene_, hairs(), read); !done) return done;
  for (StageSide& side : sides_)
    if (Result<void> done = side.inspection.measure(read); !done) return done;
  return transparency.measure(scene_, read);
}

std::vector<pelage::Light> Stage::lights() const { return lightsOf(chosen()); }

void Stage::setLights(const std::vector<pelage::Light>& lights) {
  sample::DemoScene& demo = *sides_[side_].demo;
  demo.light = {.color = {}, .ambient = {}};
  if (!lights.empty()) demo.light = lights[0];
  demo.moreLights.assign(lights.begin() + (lights.empty() ? 0 : 1), lights.end());
}

void Stage::frameAll(float aspect) {
  const sample::DemoScene& demo = *sides_[0].demo;
  camera.frame(applied_ ? demo.cameraFrom(camera.direction(), aspect) : demo.camera(aspect));
}

void Stage::reset() {
  clock.time = 0;
  for (const StageSide& side : std::span(sides_).first(sides())) {
    for (const pelage::HairId hair : side.demo->hairs()) scene_.hair(hair).reset();
    for (const pelage::ColliderId collider : side.demo->colliders())
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
  transparency.forgetFrames();
  auto kept = scene_.recover(snapshot_.value_or(pelage::SceneSnapshot{}));
  snapshot_.reset();
  return kept;
}

}  // namespace viewer
