#include "scenes/drawing_run.h"

#include <algorithm>
#include <string_view>
#include <utility>

#include "engine_lights/code.h"
#include "engine_lights/kernels.h"
#include "scenes/characters.h"
#include "scenes/scene_run.h"

namespace bench {

using pelage::BufferId;
using pelage::HeadlessDevice;
using pelage::Pass;
using pelage::PassList;
using pelage::PassTiming;
using pelage::Result;
using pelage::Transparency;
using sample::DemoScene;

namespace {

constexpr std::string_view kKeepPass = "keep_positions", kMeshPass = "mesh_pixel";
constexpr float kShare = 0.5f;          // of the way from the state before to the last one
constexpr float kBetweenEyes = 0.063f;  // [m]
constexpr uint64_t kMaxBytes = uint64_t{4} << 30;

// Adds passes from `first` on of the timings of several lists.
template <class GroupOf>
void addPasses(FrameFigures& figures, const PassList& list, const std::vector<PassTiming>& timings,
               size_t first, const GroupOf& groupOf) {
  for (size_t i = 0; i < list.passes.size(); ++i) {
    const size_t at = first + i;
    figures.add(list.passes[i].name, groupOf(list, list.passes[i]),
                at < timings.size() ? timings[at].milliseconds : -1);
  }
}

}  // namespace

Result<engine_lights::LightRig> makeLightRig(HeadlessDevice& device, SceneAssets& assets,
                                             const DrawingRow& row) {
  const auto character = assets.character(row.guides);
  if (!character) return character.error();
  device.addCode(engine_lights::allCode());
  const pelage::CollisionMesh& mesh = (*character)->mesh;
  return engine_lights::LightRig::create(device, {mesh.positions, mesh.indices});
}

namespace {

// Strands of Rat Boy as scripts/ratboy.sh has them.
constexpr std::string_view kRatBoySettings = R"({
  "simulation": {"damping": 0.04, "bendLength": 0.3, "globalStiffness": 0.2, "globalRange": 0.4,
                 "vspCoefficient": 0.2},
  "material": {"fiberRadius": 1.5e-4, "tipRadiusRatio": 0.15},
  "follow": {"countPerGuide": 16, "maxRadius": 0.006, "flyaways": 0.03}})";
constexpr std::string_view kDetailSettings = R"({"creation": {"levelOfDetail": true}})";

Result<std::vector<DemoScene>> makeScenes(Workbench& workbench, SceneAssets& assets,
                                          const DrawingRow& row) {
  sample::DemoDef def;
  def.scene = &workbench.scene;
  const bool detail = row.extra == DrawingExtra::kLevelOfDetail;
  if (row.ratBoy || detail) {
    auto settings =
        pelage::SettingsFile::parse(row.ratBoy ? kRatBoySettings : kDetailSettings, row.name());
    if (!settings) return settings.error();
    def.settings = *std::move(settings);
  }
  if (row.ratBoy) {
    const auto files = assets.ratBoy();
    if (!files) return files.error();
    auto demo = DemoScene::create(**files, def);
    if (!demo) return demo.error();
    std::vector<DemoScene> demos;
    demos.push_back(*std::move(demo));
    return demos;
  }
  const auto character = assets.character(row.guides);
  if (!character) return character.error();
  return makeCharacters(**character, def, row.characters);
}

}  // namespace

Result<std::unique_ptr<DrawingRun>> DrawingRun::create(Workbench& workbench, SceneAssets& assets,
                                                       const DrawingRow& row, const DrawingDef& def,
                                                       const engine_lights::LightRig& rig) {
  workbench.scene.setTier(workbench.device.info().tier);
  auto demos = makeScenes(workbench, assets, row);
  if (!demos) return demos.error();
  std::unique_ptr<DrawingRun> run(new DrawingRun(workbench, *std::move(demos), row));
  run->def_ = def;
  if (row.extra == DrawingExtra::kEngineLights) {
    run->lights_ = {.kernels = engine_lights::allKernels(), .resources = rig.resources({})};
    run->settings_.engineLights = &*run->lights_;
  }
  return run;
}

DrawingRun::DrawingRun(Workbench& workbench, std::vector<DemoScene> demos, const DrawingRow& row)
    : workbench_(workbench), demos_(std::move(demos)), demo_(demos_[0]), row_(row) {
  for (const pelage::HairId id : demo_.hairs()) {
    pelage::HairObject& hair = workbench.scene.hair(id);
    hair.tracksMotion = row.extra == DrawingExtra::kMotion;
    hair.interpolates = row.extra == DrawingExtra::kInterpolation;
  }
  // One shadow map for all rows: that of the engine's sun.
  demo_.light.direction = engine_lights::sunDirection();
  demo_.light.shadow = pelage::HairShadow::kDeep;
  demo_.light.shadowSize = row.shadowSize;
  const float aspect = static_cast<float>(row.width) / static_cast<float>(row.height);
  sample::Camera camera = demo_.camera(aspect);
  if (row.distance != 1) {
    const auto moved = [&](float eye, float target) {
      return target + row.distance * (eye - target);
    };
    const pelage::Float3 eye = {moved(camera.eye.x, camera.target.x),
                                moved(camera.eye.y, camera.target.y),
                                moved(camera.eye.z, camera.target.z)};
    camera = demo_.camera(aspect, {.eye = eye, .target = camera.target});
  }
  view_ = sample::makeView(camera, row.width, row.height, 1);
  camera.eye.x += kBetweenEyes;
  camera.target.x += kBetweenEyes;
  otherView_ = sample::makeView(camera, row.width, row.height, 1);
  target_ = {.width = row.width, .height = row.height};
  settings_.maxBytes = kMaxBytes;
  settings_.maxBufferBytes = workbench.device.info().maxBufferBytes;
}

DrawingRun::~DrawingRun() {
  if (settings_.opaqueDepth != BufferId::kInvalid)
    workbench_.scene.resources().remove(settings_.opaqueDepth);
}

bool DrawingRun::drawsDepth() const {
  return row_.extra == DrawingExtra::kDepth || row_.extra == DrawingExtra::kMotion;
}

// Once, so that all frames have one method. The same in all rows: hair decides, and it is the same.
void DrawingRun::choose() {
  if (chosen_) return;
  chosen_ = true;
  settings_.method = def_.method.value_or(
      pelage::chooseTransparency(workbench_.scene.predictWork(view_),
                                 workbench_.device.info().software, Transparency::kWindowed));
  if (settings_.method != Transparency::kTiles) return;
  settings_.opaqueDepth = demo_.addDepthBuffer(row_.width, row_.height);
  target_.depthCopy = settings_.opaqueDepth;
}

// A view of its own behind the picture; opaque geometry hides hair in it, too.
Result<void> DrawingRun::drawDepth() {
  depth_.clear();
  if (Result<void> done = demo_.drawMeshes(view_, depth_); !done) return done;
  pelage::HairDepthSettings settings;
  if (row_.extra == DrawingExtra::kMotion) {
    settings.color = pelage::HairDepthColor::kMotion;
    settings.previousWorldToClip = view_.worldToClip;
  }
  settings.maxBytes = settings_.maxBytes;
  settings.maxBufferBytes = settings_.maxBufferBytes;
  return workbench_.scene.drawDepth(view_, settings, depth_);
}

// As the last frame's positions have it: those of this frame are not there yet.
void DrawingRun::chooseDetail() {
  for (const DemoScene& demo : demos_)
    for (const pelage::HairId id : demo.drawnHairs()) {
      pelage::HairObject& hair = workbench_.scene.hair(id);
      hair.drawnShare = workbench_.scene.shareForView(id, view_);
      if (hair.simulated) hair.simulatedShare = hair.drawnShare;
    }
}

// All lists of the next frame, complete.
Result<void> DrawingRun::write() {
  pelage::Scene& scene = workbench_.scene;
  if (playback_.plays()) {
    const auto us = playback_.show(scene, demo_);
    if (!us) return us.error();
    showUs_ = *us;
  }
  if (row_.extra == DrawingExtra::kLevelOfDetail) chooseDetail();
  if (Result<void> done = advanceAll(demos_, simulation_); !done) return done;
  choose();
  between_.clear();
  if (row_.extra == DrawingExtra::kInterpolation)
    if (Result<void> done = scene.interpolate(kShare, between_); !done) return done;
  lists_.resize(std::max<size_t>(lists_.size(), 1));
  lists_[0].clear();
  for (size_t i = 1; i < demos_.size(); ++i)
    if (Result<void> done = demos_[i].drawMeshes(view_, lists_[0]); !done) return done;
  if (Result<void> done = demo_.draw(view_, settings_, lists_); !done) return done;
  otherLists_.resize(std::max<size_t>(otherLists_.size(), 1));
  otherLists_[0].clear();
  if (row_.extra == DrawingExtra::kStereo)
    if (Result<void> done = demo_.draw(otherView_, settings_, otherLists_); !done) return done;
  if (drawsDepth())
    if (Result<void> done = drawDepth(); !done) return done;

  scene.finish(simulation_);
  if (!between_.passes.empty()) scene.finish(between_);
  for (PassList& list : lists_) scene.finish(list);
  if (row_.extra == DrawingExtra::kStereo)
    for (PassList& list : otherLists_) scene.finish(list);
  if (drawsDepth()) scene.finish(depth_);
  return workbench_.device.update(scene.resources());
}

PassGroup DrawingRun::groupInSimulation(const PassList& list, const Pass& pass) const {
  if (pass.name == kKeepPass) return PassGroup::kKept;
  const bool buildsSdf = writesTo(workbench_.scene.resources(), list, pass,
                                  [&](std::string_view name) { return isSdfBuffer(demo_, name); });
  return buildsSdf ? PassGroup::kSdf : PassGroup::kSimulation;
}

PassGroup DrawingRun::groupInPicture(const PassList& list, const Pass& pass) const {
  if (pass.name == kMeshPass) return PassGroup::kOpaque;
  for (const pelage::PassBinding& binding : list.bindingsOf(pass))
    if (pelage::writes(binding.access) && binding.buffer == demo_.shadowWords())
      return PassGroup::kShadow;
  return PassGroup::kPicture;
}

Result<void> DrawingRun::simulate(FrameFigures* figures) {
  std::vector<PassTiming> timings;
  std::vector<PassTiming>* const wanted = figures != nullptr ? &timings : nullptr;
  if (Result<void> done = workbench_.device.execute(simulation_, wanted); !done) return done;
  if (figures != nullptr)
    addPasses(*figures, simulation_, timings, 0, [&](const PassList& list, const Pass& pass) {
      return groupInSimulation(list, pass);
    });
  if (between_.passes.empty()) return {};
  if (Result<void> done = workbench_.device.execute(between_, wanted); !done) return done;
  if (figures != nullptr)
    addPasses(*figures, between_, timings, 0, [](const PassList&, const Pass& pass) {
      return pass.name == kKeepPass ? PassGroup::kKept : PassGroup::kInterpolation;
    });
  return {};
}

Result<pelage::RenderedImage> DrawingRun::showView(const std::vector<PassList>& view,
                                                   FrameFigures* figures) {
  std::vector<PassTiming> timings;
  std::vector<const PassList*> lists;
  for (const PassList& list : view) lists.push_back(&list);
  auto picture = workbench_.device.render(lists, target_, figures != nullptr ? &timings : nullptr);
  if (!picture || figures == nullptr) return picture;
  size_t first = 0;
  for (const PassList& list : view) {
    addPasses(*figures, list, timings, first,
              [&](const PassList& of, const Pass& pass) { return groupInPicture(of, pass); });
    first += list.passes.size();
  }
  return picture;
}

// The picture, then that of the other eye or depth in targets of their own.
Result<void> DrawingRun::show(FrameFigures* figures) {
  auto picture = showView(lists_, figures);
  if (!picture) return picture.error();
  picture_ = *std::move(picture);
  if (row_.extra == DrawingExtra::kStereo) {
    const auto other = showView(otherLists_, figures);
    return other ? Result<void>() : other.error();
  }
  if (!drawsDepth()) return {};
  std::vector<PassTiming> timings;
  const auto depth = workbench_.device.render(depth_, {.width = row_.width, .height = row_.height},
                                              figures != nullptr ? &timings : nullptr);
  if (!depth) return depth.error();
  if (figures != nullptr)
    addPasses(*figures, depth_, timings, 0, [](const PassList&, const Pass& pass) {
      return pass.name == kMeshPass ? PassGroup::kOpaque : PassGroup::kDepth;
    });
  return {};
}

Result<void> DrawingRun::recordFrames(int frames) {
  for (int frame = 0; frame < frames; ++frame) {
    if (Result<void> done = runFrame(nullptr); !done) return done;
    if (Result<void> done = playback_.record(workbench_, demo_); !done) return done;
  }
  return playback_.begin();
}

Result<void> DrawingRun::runFrame(FrameFigures* figures) {
  if (Result<void> done = write(); !done) return done;
  if (figures != nullptr) figures->beginFrame();
  if (Result<void> done = simulate(figures); !done) return done;
  return show(figures);
}

uint64_t DrawingRun::vertexCount() const {
  uint64_t count = 0;
  for (const DemoScene& demo : demos_) count += demo.vertexCount();
  return count;
}

Result<pelage::TransparencyCounters> DrawingRun::counters() {
  const auto words = workbench_.device.read(demo_.transparencyCounters());
  if (!words) return words.error();
  const auto plan = pelage::planTransparency(view_.width, view_.height, settings_, vertexCount());
  if (!plan) return plan.error();
  return pelage::readTransparencyCounters(*words, plan->nodeCount);
}

Result<void> DrawingRun::grow() {
  const auto held = counters();
  if (!held) return held.error();
  const auto plan = pelage::planTransparency(view_.width, view_.height, settings_, vertexCount());
  if (!plan) return plan.error();
  settings_.nodeCount = pelage::growNodes(*held, plan->nodeCount);
  return {};
}

}  // namespace bench
