#include "presentation.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

namespace viewer {

using pelage::Error;
using pelage::ErrorCode;
using pelage::Result;

namespace {

constexpr uint32_t kSoftwareCoarseness = 2;
constexpr uint32_t kMaxLosses = 3;  // of the device, before the program gives up

}  // namespace

Result<void> Presentation::open(const Options& options) {
  if (Result<void> done = screen.open(options.screen); !done) return done;
  stage.look.motion = options.motion;
  // A driver on the CPU takes seconds for all pixels of a head, sorted. Hair with fewer strands, or
  // without shadows, looks like straw: it gets fewer pixels.
  const bool software = screen.canvas->info().software;
  stage.look.transparency = options.transparency.value_or(
      software ? pelage::Transparency::kShortCut : pelage::Transparency::kWindowed);
  stage.look.strandShare = options.strandShare.value_or(1.0f);
  stage.look.detailPixels = options.detailPixels;
  stage.look.shadow = options.shadow.value_or(pelage::HairShadow::kDeep);
  coarseness_ = options.coarseness.value_or(software ? kSoftwareCoarseness : 1);
  stage.clock.fixed = options.fixedClock;
  adoptDevice();
  return {};
}

Result<void> Presentation::openKernels(const std::filesystem::path& folder, bool scripted) {
  if (Result<void> done = kernels_.open(folder, scripted); !done) return done;
  return folder.empty() ? Result<void>() : takeKernels(kernels_.build());
}

void Presentation::adoptDevice() {
  const pelage::DeviceInfo& info = screen.canvas->info();
  stage.setDevice({info.tier, info.maxBufferBytes});
  if (!report("Another transparency method",
              screen.canvas->supports({.method = stage.look.transparency})))
    stage.look.transparency = pelage::Transparency::kStochastic;
  screen.window->setTitle(fmt::format("pelage - {}, {}", info.name, pelage::apiName(info.api)));
}

bool Presentation::report(const char* title, const Result<void>& result) {
  if (!result) screen.interface->say(title, result.error().message);
  return result.ok();
}

void Presentation::showFirst(const StageSource& source) {
  if (!report("The files cannot be shown", stage.show(source)))
    report("There is nothing to show", stage.show({.solver = source.solver}));
}

void Presentation::show(const StageSource& source) {
  if (report("The files cannot be shown", stage.show(source))) frameAll();
}

void Presentation::compare(std::optional<pelage::Solver> right) {
  report("There is nothing to compare", stage.compare(right));
}

Result<void> Presentation::begin() {
  if (const std::optional<KernelBuild> built = kernels_.take())
    if (Result<void> done = takeKernels(*built); !done) return done;
  if (Result<void> done = screen.canvas->begin(); !done) return done;
  history.add(screen.canvas->timings());
  return {};
}

Result<bool> Presentation::draw(const WindowSize& size, double seconds, bool captures) {
  const auto setTarget = [&] {
    return screen.canvas->setTarget({size.pixelWidth, size.pixelHeight, stage.viewSettings.samples,
                                     stage.viewSettings.reversedDepth});
  };
  WaysBack ways(good_, stage);
  const auto goBack = [&](const Error& refused) -> Result<bool> {
    if (!goesBack(refused, ways)) return refused;
    return false;
  };
  if (Result<void> done = setTarget(); !done) return goBack(done.error());
  const uint32_t width = std::max(size.pixelWidth / coarseness_, 1u);
  const uint32_t height = std::max(size.pixelHeight / coarseness_, 1u);
  auto frame = stage.makeFrame(seconds, width, height);
  // Several ways back may be needed in turn, and earlier settings may need another target.
  while (!frame && goesBack(frame.error(), ways)) {
    if (Result<void> done = setTarget(); !done) return done.error();
    frame = stage.makeFrame(0, width, height);
  }
  if (!frame) return frame.error();
  CanvasFrame shown;
  shown.frame = &*frame;
  shown.views = stage.views();
  shown.interface = screen.interface->drawData();
  shown.captures = captures;
  shown.coarseness = coarseness_;
  if (Result<void> done = screen.canvas->show(shown); !done) return goBack(done.error());
  good_.keep(stage);
  kernels_.prove();
  if (Result<void> measured = stage.measure(reader()); !measured) return measured.error();
  return true;
}

void Presentation::end() {
  losses_ = 0;
  hasFrames_ = true;
}

// Gives way where the library or the device refuses settings or kernels: with a message, the last
// good ones are back.
bool Presentation::goesBack(const Error& refused, WaysBack& ways) {
  if (keepsOldKernels(refused)) return true;
  if (refused.code == ErrorCode::kDeviceLost || !ways.take()) return false;
  return !report("The settings cannot be used", refused);
}

Result<void> Presentation::loseDevice() {
  if (Result<void> taken = stage.takeSnapshot(reader()); !taken) return taken;
  return recover({ErrorCode::kDeviceLost, "A test of the device's loss"});
}

Result<void> Presentation::recover(const Error& lost) {
  if (++losses_ > kMaxLosses) return lost;
  const Result<uint32_t> kept = stage.recover();
  if (!kept) return kept.error();
  history.clear();
  if (Result<void> done = screen.reopen(); !done) return done;
  kernels_.use(kernels_.proven());
  if (kernels_.code())
    if (Result<void> done = screen.canvas->setCode(kernels_.list()); !done) return done;
  adoptDevice();
  screen.interface->say("The device was lost",
                        lost.message + ". " +
                            (*kept > 0 ? "Hair goes on from its last state."
                                       : "Hair begins in its bind pose again."));
  return {};
}

Result<void> Presentation::takeKernels(const KernelBuild& build) {
  if (!build.tables) {
    screen.interface->say("The old kernels stay", build.error);
    return {};
  }
  // Tables of the program's own source are empty.
  const bool isOwn = build.tables->kernels().empty();
  if (isOwn && !kernels_.code()) return {};
  std::string names;
  for (const std::string& name : build.tables->kernels())
    names += (names.empty() ? "" : ", ") + name;
  fmt::print("kernels: {}\n", isOwn ? "those of the program" : names);
  return useCode(isOwn ? nullptr : build.tables);
}

// Makes the runtime with other code; the hair goes on from its state.
Result<void> Presentation::useCode(std::shared_ptr<const KernelTables> code) {
  if (hasFrames_)
    if (Result<void> taken = stage.takeSnapshot(reader()); !taken) return taken;
  const auto old = kernels_.use(std::move(code));
  if (Result<void> set = screen.canvas->setCode(kernels_.list()); !set) return set;
  if (hasFrames_)
    if (const auto kept = stage.recover(); !kept) return kept.error();
  history.clear();
  adoptDevice();
  return {};
}

// Goes back to the kernels of the last frame where a driver refuses new ones that codegen accepts.
// \return whether that helps.
bool Presentation::keepsOldKernels(const Error& refused) {
  if (refused.code == ErrorCode::kDeviceLost || kernels_.code() == kernels_.proven()) return false;
  if (!useCode(kernels_.proven())) return false;
  return !report("The old kernels stay", refused);
}

}  // namespace viewer
