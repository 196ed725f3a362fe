#include "viewer.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstdio>
#include <ctime>
#include <functional>
#include <utility>

#include "capture/screenshot.h"
#include "input/keys.h"
#include "interface/gizmos.h"
#include "interface/inspection_panel.h"
#include "program_messages.h"

namespace viewer {

using pelage::Error;
using pelage::ErrorCode;
using pelage::Result;

namespace {

double secondsSince(std::chrono::steady_clock::time_point start) {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

// CPU time of this thread.
double cpuSeconds() {
  timespec time = {};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &time);
  return static_cast<double>(time.tv_sec) + 1e-9 * static_cast<double>(time.tv_nsec);
}

constexpr float kSoftwareShare = 0.25f;  // of the strands
constexpr int kMaxWaysBack = 5;          // kernels, settings, target, memory, the default look
constexpr uint32_t kMaxLosses = 3;       // of the device, before the program gives up

}  // namespace

Result<void> Viewer::open() {
  if (!options_.script.empty()) {
    auto events = loadScript(options_.script);
    if (!events) return events.error();
    player_.emplace(*std::move(events));
  }
  if (!options_.record.empty()) {
    auto recorder = Recorder::open(options_.record);
    if (!recorder) return recorder.error();
    recorder_.emplace(*std::move(recorder));
    recorder_->add({0, Resized{options_.width, options_.height}});
  }
  if (Result<void> done = openCaptures(); !done) return done;
  if (Result<void> done = openAnyApi(); !done) return done;
  stage_.look.motion = options_.motion;
  // A driver on the CPU takes seconds for all strands of a head, sorted and with shadows.
  const bool software = canvas_->info().software;
  stage_.look.transparency = options_.transparency.value_or(
      software ? pelage::Transparency::kShortCut : pelage::Transparency::kWindowed);
  stage_.look.strandShare = options_.strandShare.value_or(software ? kSoftwareShare : 1.0f);
  stage_.look.shadow =
      options_.shadow.value_or(software ? pelage::HairShadow::kNone : pelage::HairShadow::kDeep);
  stage_.clock.fixed = options_.fixedClock || recorder_.has_value();
  adopt();
  opened_ = secondsSince(start_);
  showFirst();
  if (!options_.settings.empty() && stage_.shown() > 0) loadSettings(options_.settings);
  if (Result<void> done = openReload(); !done) return done;
  if (options_.compared && stage_.shown() > 0) compare(options_.compared);
  shown_ = secondsSince(start_);
  const WindowSize size = window_->size();
  stage_.frameAll(static_cast<float>(std::max(size.width, 1u)) /
                  static_cast<float>(std::max(size.height, 1u)));
  last_ = std::chrono::steady_clock::now();
  return {};
}

Result<void> Viewer::openApi(pelage::Api api) {
  canvas_.reset();
  interface_.reset();
  window_.reset();
  WindowDef def;
  def.width = options_.width;
  def.height = options_.height;
  def.api = api;
  def.debug = options_.validation;
  def.vsync = options_.vsync && !player_;
  auto window = Window::create(def);
  if (!window) return window.error();
  window_ = *std::move(window);
  interface_ = std::make_unique<UserInterface>(window_->size().interfaceScale);
  CanvasDef canvasDef;
  canvasDef.api = api;
  canvasDef.validation = options_.validation;
  canvasDef.deviceIndex = options_.device;
  canvasDef.cache = options_.cache;
  canvasDef.vsync = def.vsync;
  auto canvas = createCanvas(canvasDef, *window_);
  if (!canvas) return canvas.error();
  canvas_ = *std::move(canvas);
  return {};
}

// OpenGL stands in for a Vulkan that is not there, unless the user chose.
Result<void> Viewer::openAnyApi() {
  if (options_.api) return openApi(*options_.api);
  const Result<void> vulkan = openApi(pelage::Api::kVulkan);
  if (vulkan) {
    options_.api = pelage::Api::kVulkan;
    return {};
  }
  if (const Result<void> gl = openApi(pelage::Api::kGl); !gl)
    return Error{vulkan.error().code,
                 vulkan.error().message + "; nor can OpenGL be used: " + gl.error().message};
  options_.api = pelage::Api::kGl;
  interface_->say("Drawing with OpenGL", "Vulkan cannot be used: " + vulkan.error().message);
  return {};
}

// The stage learns what the device can do.
void Viewer::adopt() {
  const pelage::DeviceInfo& info = canvas_->info();
  stage_.setDevice({info.tier, info.maxBufferBytes});
  if (const Result<void> can = canvas_->supports({.method = stage_.look.transparency}); !can) {
    interface_->say("Another transparency method", can.error().message);
    stage_.look.transparency = pelage::Transparency::kStochastic;
  }
  window_->setTitle(fmt::format("pelage - {}, {}", info.name, pelage::apiName(info.api)));
}

// Where the files cannot be shown, the character is.
void Viewer::showFirst() {
  const Result<void> shown = stage_.show(options_.source);
  if (shown) return;
  interface_->say("The files cannot be shown", shown.error().message);
  const Result<void> character = stage_.show({.solver = options_.source.solver});
  if (!character) interface_->say("There is nothing to show", character.error().message);
}

void Viewer::show(const StageSource& source) {
  const Result<void> shown = stage_.show(source);
  if (!shown) {
    interface_->say("The files cannot be shown", shown.error().message);
    return;
  }
  const WindowSize size = window_->size();
  stage_.frameAll(static_cast<float>(std::max(size.width, 1u)) /
                  static_cast<float>(std::max(size.height, 1u)));
}

// Bones and meshes belong to the hair that is there; hair replaces it.
void Viewer::drop(std::vector<std::filesystem::path> files, bool adds) {
  for (const std::filesystem::path& file : files)
    if (file.extension() == ".json") loadSettings(file);
  std::erase_if(files, [](const auto& file) { return file.extension() == ".json"; });
  if (files.empty()) return;
  StageSource source = stage_.source();
  const bool hair = std::any_of(files.begin(), files.end(), [](const std::filesystem::path& file) {
    const auto extension = file.extension();
    return extension != ".tfxbone" && extension != ".tfxfollow" && extension != ".tfxmesh";
  });
  if ((hair && !adds) || source.kind != StageKind::kFiles) {
    source.files.clear();
    source.scale = 0;
  }
  source.kind = StageKind::kFiles;
  source.files.insert(source.files.end(), files.begin(), files.end());
  show(source);
}

void Viewer::compare(std::optional<pelage::Solver> right) {
  const Result<void> compared = stage_.compare(right);
  if (!compared) interface_->say("There is nothing to compare", compared.error().message);
}

// The other solver beside the one that is there, or that one alone again.
void Viewer::compareSolvers() {
  if (stage_.sides() == 2) return compare(std::nullopt);
  using pelage::Solver;
  compare(stage_.solverOf(0) == Solver::kExact ? Solver::kClassic : Solver::kExact);
}

void Viewer::loadSettings(const std::filesystem::path& file) {
  const Result<void> loaded = settings().load(file, stage_);
  if (!loaded) interface_->say("The settings cannot be loaded", loaded.error().message);
}

// Shortcuts of the interface, also where a text field has the keys. \return whether it is one.
bool Viewer::takeShortcut(const KeyPressed& key) {
  if (key.key == kKeyLeftControl || key.key == kKeyRightControl) control_ = key.down;
  if (!control_ || !key.down || (key.key != 'Z' && key.key != 'Y')) return false;
  if (key.key == 'Z')
    settings().undo(stage_);
  else
    settings().redo(stage_);
  return true;
}

void Viewer::collect() {
  events_.clear();
  if (!player_) {
    window_->poll(events_, window_->size().hidden);
    return;
  }
  // A script has the window to itself; a person can only close it.
  window_->poll(events_, window_->size().hidden);
  std::erase_if(events_, [](const Event& event) { return !std::holds_alternative<Quit>(event); });
  player_->eventsOf(frame_, events_);
}

Result<void> Viewer::take(const Event& event) {
  if (recorder_ && !std::holds_alternative<Quit>(event)) recorder_->add({frame_, event});
  if (std::holds_alternative<Quit>(event)) {
    quits_ = true;
    return {};
  }
  if (const auto* wanted = std::get_if<ScreenshotWanted>(&event)) {
    screenshot_ = wanted->file;
    return {};
  }
  if (const auto* dropped = std::get_if<FilesDropped>(&event)) {
    drop(dropped->files);
    return {};
  }
  if (const auto* resized = std::get_if<Resized>(&event)) {
    if (player_) return window_->resize(resized->width, resized->height);
    return {};
  }
  if (const auto* minimized = std::get_if<Minimized>(&event)) {
    if (player_) return window_->minimize(minimized->minimized);
    return {};
  }
  if (const auto* key = std::get_if<KeyPressed>(&event); key != nullptr && takeShortcut(*key))
    return {};
  if (interface_->take(event)) return {};
  if (const auto* key = std::get_if<KeyPressed>(&event); key != nullptr && key->down) {
    if (key->key == kKeyTab) controls_.hasArrow = showsPanel_ = !showsPanel_;
    if (key->key == 'S') showsSettings_ = !showsSettings_;
    if (key->key == 'O') dialog_.toggle();
    if (key->key == 'I') showsStatistics_ = !showsStatistics_;
    if (key->key == 'D') compareSolvers();
    if (key->key == kKeyF12) screenshot_ = nextFile(".png");
    if (key->key == kKeyF10) toggleRecording();
    if (key->key == kKeyF8) toggleTimes();
    if (key->key == kKeyF9) return loseDevice();
  }
  controls_.take(event, window_->size(), stage_);
  return {};
}

// The target of the views as their settings want it now.
Result<void> Viewer::setTarget(const WindowSize& size) {
  return canvas_->setTarget({size.pixelWidth, size.pixelHeight, stage_.viewSettings.samples,
                             stage_.viewSettings.reversedDepth});
}

Result<void> Viewer::drawFrame(const WindowSize& size) {
  const auto now = std::chrono::steady_clock::now();
  const double seconds = std::chrono::duration<double>(now - last_).count();
  last_ = now;
  if (Result<void> done = reloadKernels(); !done) return done;
  if (Result<void> done = canvas_->begin(); !done) return done;
  history_.add(canvas_->timings());
  if (times_) times_->add(frame_, canvas_->timings());
  PanelWishes wishes;
  std::vector<SettingsMessage> messages;
  std::optional<FileChoice> chosen;
  const auto panels = [&] {
    buildInspectionKey(stage_, size);
    chosen = dialog_.build(size);
    if (!showsPanel_) return;
    wishes = buildStagePanel(stage_, *canvas_, history_, size);
    if (showsSettings_) messages = settings().build(stage_, size);
    if (showsStatistics_) statistics_.build(stage_, *canvas_, history_, size);
    drawGizmos(stage_, size);
  };
  const double before = cpuSeconds();
  interface_->build(size, stage_.clock.fixed ? PlayClock::kStep : seconds, panels);
  interfaceSeconds_ += cpuSeconds() - before;
  ++builtFrames_;
  for (SettingsMessage& message : messages)
    interface_->say(std::move(message.title), std::move(message.text));
  if (Result<void> done = setTarget(size); !done)
    return goesBack(done.error()) ? Result<void>() : done;
  auto frame = stage_.makeFrame(seconds, size.pixelWidth, size.pixelHeight);
  // There is more than one way back.
  for (int i = 0; i < kMaxWaysBack && !frame && goesBack(frame.error()); ++i) {
    // What is back may want another target.
    if (Result<void> done = setTarget(size); !done) return done;
    frame = stage_.makeFrame(0, size.pixelWidth, size.pixelHeight);
  }
  if (!frame) return frame.error();
  CanvasFrame shown;
  shown.frame = &*frame;
  shown.views = stage_.views();
  shown.interface = interface_->drawData();
  if (std::exchange(wantsScreenshot_, false) && screenshot_.empty()) screenshot_ = nextFile(".png");
  shown.captures = !screenshot_.empty() || recording_;
  if (Result<void> done = canvas_->show(shown); !done)
    return goesBack(done.error()) ? Result<void>() : done;
  good_.keep(stage_);
  provenCode_ = code_;
  const auto read = [&](pelage::BufferId buffer) { return canvas_->read(buffer); };
  if (Result<void> measured = stage_.measure(read); !measured) return measured;
  if (showsStatistics_ && showsPanel_)
    if (Result<void> done = statistics_.read(stage_, read); !done) return done;
  if (chosen) drop(std::move(chosen->files), chosen->adds);
  return grant(wishes);
}

// Settings that the library or the device refuses are a message, and the last ones are back.
bool Viewer::goesBack(const Error& refused) {
  if (keepsOldKernels(refused)) return true;
  if (refused.code == ErrorCode::kDeviceLost) return false;
  // The same settings may be refused in a larger window: for their memory.
  if (!good_.restore(stage_) && !stage_.resetTarget() && !stage_.resetMemory() &&
      !applyDefaultLook(stage_))
    return false;
  interface_->say("The settings cannot be used", refused.message);
  return true;
}

Result<void> Viewer::grant(const PanelWishes& wishes) {
  if (wishes.source) show(*wishes.source);
  const WindowSize size = window_->size();
  if (wishes.togglesSettings) showsSettings_ = !showsSettings_;
  if (wishes.opensFiles) dialog_.toggle();
  if (wishes.togglesStatistics) showsStatistics_ = !showsStatistics_;
  if (wishes.compares) compare(wishes.right);
  if (wishes.framesAll)
    stage_.frameAll(static_cast<float>(std::max(size.width, 1u)) /
                    static_cast<float>(std::max(size.height, 1u)));
  if (wishes.resets) stage_.reset();
  if (wishes.takesScreenshot) wantsScreenshot_ = true;
  return wishes.losesDevice ? loseDevice() : Result<void>();
}

// As if the driver had lost it, with a state to go on from.
Result<void> Viewer::loseDevice() {
  Result<void> taken =
      stage_.takeSnapshot([&](pelage::BufferId buffer) { return canvas_->read(buffer); });
  if (!taken) return taken;
  return recoverDevice({ErrorCode::kDeviceLost, "A test of the device's loss"});
}

Result<void> Viewer::saveScreenshot() {
  const std::filesystem::path path = std::exchange(screenshot_, {});
  Result<void> written = writeScreenshot(canvas_->captured(), path);
  if (written) {
    fmt::print("{}\n", path.string());
    return written;
  }
  if (player_) return written;
  interface_->say("No screenshot", written.error().message);
  return {};
}

Result<void> Viewer::recoverDevice(const Error& lost) {
  if (++losses_ > kMaxLosses) return lost;
  const Result<uint32_t> kept = stage_.recover();
  if (!kept) return kept.error();
  history_.clear();
  if (Result<void> done = openApi(*options_.api); !done) return done;
  code_ = provenCode_;
  if (code_)
    if (Result<void> done = canvas_->setCode(code_->list()); !done) return done;
  adopt();
  interface_->say("The device was lost", lost.message + ". " +
                                             (*kept > 0 ? "Hair goes on from its last state."
                                                        : "Hair begins in its bind pose again."));
  return {};
}

Result<void> Viewer::run() {
  for (; !quits_; ++frame_) {
    collect();
    for (const Event& event : events_)
      if (Result<void> done = take(event); !done) return done;
    const WindowSize size = window_->size();
    if (size.hidden) continue;
    Result<void> drawn = drawFrame(size);
    if (!drawn && drawn.error().code == ErrorCode::kDeviceLost) {
      if (Result<void> done = recoverDevice(drawn.error()); !done) return done;
      continue;
    }
    if (!drawn) return drawn;
    losses_ = 0;
    if (Result<void> done = record(); !done) return done;
    if (firstPicture_ == 0) firstPicture_ = secondsSince(start_);
    if (!screenshot_.empty() && canvas_->captured().width > 0)
      if (Result<void> done = saveScreenshot(); !done) return done;
  }
  endRecording();
  canvas_->saveCache();
  if (options_.printsStart)
    fmt::print(
        stderr,
        "{}: window and device {:.2f} s, hair {:.2f} s, first picture {:.2f} s; the interface "
        "takes {:.3f} ms of CPU a frame\n",
        kProgram, opened_, shown_, firstPicture_,
        1e3 * interfaceSeconds_ / static_cast<double>(std::max<uint64_t>(builtFrames_, 1)));
  if (options_.validation && canvas_->messageCount() > 0)
    return Error{ErrorCode::kDevice, fmt::format("validation reported {} messages (printed above)",
                                                 canvas_->messageCount())};
  return {};
}

}  // namespace viewer
