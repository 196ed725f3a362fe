#include "viewer.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstdio>
#include <optional>

namespace viewer {

using pelage::Error;
using pelage::ErrorCode;
using pelage::Result;

namespace {

double secondsSince(std::chrono::steady_clock::time_point start) {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

// The solver to show at the right: the one that is not shown; nothing if two sides are shown.
std::optional<pelage::Solver> otherSolver(const Stage& stage) {
  using pelage::Solver;
  if (stage.sides() == 2) return std::nullopt;
  return stage.solverOf(0) == Solver::kExact ? Solver::kClassic : Solver::kExact;
}

// Whether files have hair, not only bones, follow hairs and meshes of other hair.
bool haveHair(const std::vector<std::filesystem::path>& files) {
  return std::any_of(files.begin(), files.end(), [](const std::filesystem::path& file) {
    const auto extension = file.extension();
    return extension != ".tfxbone" && extension != ".tfxfollow" && extension != ".tfxmesh";
  });
}

}  // namespace

Result<void> Viewer::open() {
  const Resized size = {options_.screen.width, options_.screen.height};
  if (Result<void> done = input_.open(options_.script, options_.record, size); !done) return done;
  if (Result<void> done = captures_.open(); !done) return done;
  if (Result<void> done = shown_.open(options_); !done) return done;
  times_.opened = secondsSince(times_.start);
  shown_.showFirst(options_.source);
  if (!options_.settings.empty() && shown_.stage.shown() > 0)
    panels_.loadSettings(options_.settings, shown_.stage, *shown_.screen.interface);
  if (Result<void> done = shown_.openKernels(options_.kernels, input_.isScripted()); !done)
    return done;
  if (options_.compared && shown_.stage.shown() > 0) shown_.compare(options_.compared);
  times_.shown = secondsSince(times_.start);
  shown_.frameAll();
  times_.lastFrame = std::chrono::steady_clock::now();
  return {};
}

// Settings are loaded. Bones and meshes join the hair that is shown; hair replaces it, or comes
// beside it where `adds`.
void Viewer::drop(std::vector<std::filesystem::path> files, bool adds) {
  const auto isSettings = [](const std::filesystem::path& file) {
    return file.extension() == ".json";
  };
  for (const std::filesystem::path& file : files)
    if (isSettings(file)) panels_.loadSettings(file, shown_.stage, *shown_.screen.interface);
  std::erase_if(files, isSettings);
  if (files.empty()) return;
  StageSource source = shown_.stage.source();
  if ((haveHair(files) && !adds) || source.kind != StageKind::kFiles) {
    source.files.clear();
    source.scale = 0;
  }
  source.kind = StageKind::kFiles;
  source.files.insert(source.files.end(), files.begin(), files.end());
  shown_.show(source);
}

Result<void> Viewer::take(const Event& event) {
  if (const auto* wanted = std::get_if<ScreenshotWanted>(&event)) {
    captures_.saveFrame(wanted->file);
    return {};
  }
  if (const auto* dropped = std::get_if<FilesDropped>(&event)) {
    drop(dropped->files, false);
    return {};
  }
  // A person has resized or minimized the window already.
  const bool scripted = input_.isScripted();
  Window& window = *shown_.screen.window;
  if (const auto* resized = std::get_if<Resized>(&event))
    return scripted ? window.resize(resized->width, resized->height) : Result<void>();
  if (const auto* minimized = std::get_if<Minimized>(&event))
    return scripted ? window.minimize(minimized->minimized) : Result<void>();
  const auto* key = std::get_if<KeyPressed>(&event);
  if (key != nullptr && panels_.takeShortcut(*key, shown_.stage)) return {};
  if (shown_.screen.interface->take(event)) return {};
  if (key != nullptr && key->down) {
    if (key->key == kKeyF9) return shown_.loseDevice();
    takeKey(key->key);
  }
  controls_.take(event, window.size(), shown_.stage);
  return {};
}

void Viewer::takeKey(Key key) {
  UserInterface& interface = *shown_.screen.interface;
  panels_.takeKey(key);
  controls_.hasArrow = panels_.areShown();
  if (key == 'D') shown_.compare(otherSolver(shown_.stage));
  if (key == kKeyF12) captures_.saveFrame(nextFile(".png"));
  if (key == kKeyF10) captures_.toggleRecording(shown_.stage.clock, interface);
  if (key == kKeyF8) captures_.toggleTimes(interface);
}

Result<void> Viewer::drawFrame(const WindowSize& size) {
  const auto now = std::chrono::steady_clock::now();
  const double seconds = std::chrono::duration<double>(now - times_.lastFrame).count();
  times_.lastFrame = now;
  if (Result<void> done = shown_.begin(); !done) return done;
  const Canvas& canvas = *shown_.screen.canvas;
  captures_.addTimes(input_.frame(), canvas.timings());
  PanelWishes wishes =
      panels_.build(shown_.stage, canvas, shown_.history, size, seconds, *shown_.screen.interface);
  const Result<bool> drawn = shown_.draw(size, seconds, captures_.wantsPicture());
  if (!drawn) return drawn.error();
  if (!*drawn) return {};
  if (Result<void> done = panels_.readStatistics(shown_.stage, shown_.reader()); !done) return done;
  if (wishes.files) drop(std::move(wishes.files->files), wishes.files->adds);
  return grant(wishes);
}

Result<void> Viewer::grant(const PanelWishes& wishes) {
  if (wishes.source) shown_.show(*wishes.source);
  panels_.grant(wishes);
  if (wishes.compares) shown_.compare(wishes.right);
  if (wishes.framesAll) shown_.frameAll();
  if (wishes.resets) shown_.stage.reset();
  if (wishes.takesScreenshot) captures_.saveNextFrame();
  return wishes.losesDevice ? shown_.loseDevice() : Result<void>();
}

Result<void> Viewer::run() {
  for (; !input_.hasEnded(); input_.endFrame()) {
    for (const Event& event : input_.collect(*shown_.screen.window))
      if (Result<void> done = take(event); !done) return done;
    const WindowSize size = shown_.screen.window->size();
    if (size.hidden) continue;
    Result<void> drawn = drawFrame(size);
    if (!drawn && drawn.error().code == ErrorCode::kDeviceLost) {
      if (Result<void> done = shown_.recover(drawn.error()); !done) return done;
      continue;
    }
    if (!drawn) return drawn;
    shown_.end();
    if (times_.firstPicture == 0) times_.firstPicture = secondsSince(times_.start);
    if (Result<void> done = captures_.take(shown_.screen.canvas->captured(), shown_.stage.clock,
                                           *shown_.screen.interface);
        !done)
      return done;
  }
  Canvas& canvas = *shown_.screen.canvas;
  captures_.endRecording(shown_.stage.clock, *shown_.screen.interface);
  canvas.saveCache();
  if (options_.printsStart)
    fmt::print(
        stderr,
        "{}: window and device {:.2f} s, hair {:.2f} s, first picture {:.2f} s; the interface "
        "takes {:.3f} ms of CPU a frame\n",
        kProgram, times_.opened, times_.shown, times_.firstPicture, panels_.buildMilliseconds());
  if (options_.screen.validation && canvas.messageCount() > 0)
    return Error{ErrorCode::kDevice, fmt::format("validation reported {} messages (printed above)",
                                                 canvas.messageCount())};
  return {};
}

}  // namespace viewer
