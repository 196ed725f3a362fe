#include "shot_run.h"

#include <fmt/format.h>

#include <algorithm>
#include <atomic>
#include <charconv>
#include <chrono>
#include <future>
#include <thread>
#include <utility>

#include "atomic_file.h"
#include "checkpoint.h"
#include "chunk_writer.h"
#include "common/errors.h"
#include "json_members.h"
#include "pelage/hair_cache.h"
#include "pelage/settings/settings_file.h"
#include "shot_store.h"
#include "usd_output.h"

namespace pelage::bake {
namespace {

using nlohmann::json;
using Path = std::filesystem::path;

uint32_t threadsOf(const RunOptions& options) {
  return options.threads != 0 ? options.threads : std::max(std::thread::hardware_concurrency(), 1u);
}

// Chunks that a range consists of. Errors: it begins or ends within one, or beyond the shot.
Result<std::vector<uint64_t>> chunksOf(const Project& project, const Shot& shot,
                                       const FrameRange& range) {
  std::vector<uint64_t> chunks;
  bool begins = false, ends = false;
  for (uint64_t i = 0; i < chunkCount(project, shot); ++i) {
    const FrameRange chunk = chunkOf(project, shot, i);
    begins |= chunk.first == range.first;
    ends |= chunk.last == range.last;
    if (chunk.first >= range.first && chunk.last <= range.last) chunks.push_back(i);
  }
  if (begins && ends && !chunks.empty()) return chunks;
  return Error{ErrorCode::kInvalidArgument,
               fmt::format("frames {}-{} are not whole chunks of shot '{}', which has frames {}-{} "
                           "in chunks that begin at multiples of {}",
                           range.first, range.last, shot.name, shot.frames.first, shot.frames.last,
                           project.chunkFrames)};
}

// The task of a run, and its report.
struct Run {
  const Project& project;
  const Shot& shot;
  const RunOptions& options;
  RunResources& resources;
  FrameRange range = options.range.value_or(shot.frames);
  ShotStore store{project, shot};
  std::string tag = fmt::format("{}-{}", range.first, range.last);
  uint64_t fingerprint = 0;
  RunReport report = {};

  bool stopped() const { return options.interrupted && options.interrupted(); }
  void warn(const std::string& text) const {
    if (options.warn) options.warn(text);
  }
  CheckpointKey key(uint64_t steps) const { return {fingerprint, steps, report.device}; }
};

// \param hashes  reads the files; false: compares their sizes alone
Result<bool> isComplete(Run& run, bool hashes) {
  const auto done = run.store.done();
  if (!done) return done.error();
  if (!*done) return false;
  const auto known = run.store.fingerprint(&run.report.device);
  if (!known) return known.error();
  if (**known != run.fingerprint)
    return Error{ErrorCode::kInvalidArgument,
                 fmt::format("{}: is complete, with other settings or files than the project has "
                             "now; --restart begins anew, or give the shot another name",
                             run.store.folder().string())};
  const auto files = filesOf(**done, "done.json");
  const std::string fault = files ? faultOf(*files, run.store.folder(), hashes) : "";
  if (!fault.empty())
    return Error{ErrorCode::kInvalidFile, fmt::format("{}: {}; begin anew by --restart",
                                                      run.store.folder().string(), fault)};
  return true;
}

// A shot on a device. The scene refers to the inputs.
struct OpenShot {
  ShotInputs inputs;
  std::optional<ShotScene> scene;
  std::unique_ptr<HeadlessDevice> device;
  uint64_t steps = 0;  ///< that the scene has run
};

// An earlier run has chosen, or this one does.
Result<void> chooseSteps(Run& run, const ShotInputs& inputs) {
  const Path path = run.store.subStepsFile();
  if (std::error_code ignored; std::filesystem::exists(path, ignored)) {
    const auto loaded = loadJson(path.string());
    if (!loaded) return loaded.error();
    auto choice = subStepsOf(*loaded, path.string());
    if (!choice) return choice.error();
    run.report.choice = *std::move(choice);
    return {};
  }
  const std::string& wanted = run.options.device.empty() ? run.project.device : run.options.device;
  auto choice = chooseSubSteps(inputs, run.shot, run.project.framesPerSecond,
                               [&] { return run.resources.device(run.project.api, wanted); });
  if (!choice) return choice.error();
  run.report.choice = *std::move(choice);
  return writeAtomic(path, run.tag, toJson(*run.report.choice).dump(1) + "\n");
}

// Opens inputs, device and scene, and notes in the folder which shot it has.
Result<void> openShot(Run& run, OpenShot& opened) {
  const std::string& wanted = run.options.device.empty() ? run.project.device : run.options.device;
  // Opens beside the loading; a context of OpenGL belongs to the thread that makes it.
  auto opening =
      std::async(run.project.api == Api::kVulkan ? std::launch::async : std::launch::deferred,
                 [&] { return run.resources.device(run.project.api, wanted); });
  auto inputs = run.resources.inputs(run.shot);
  if (!inputs) return inputs.error();
  opened.inputs = *std::move(inputs);
  for (const std::string& warning : opened.inputs.warnings) run.warn(warning);
  auto device = opening.get();
  if (!device) return device.error();
  run.report.device = deviceName((*device)->info());
  if (auto begun = run.store.begin(run.fingerprint, run.report.device, run.tag); !begun)
    return begun;
  if (run.shot.errorBound) {
    if (auto chosen = chooseSteps(run, opened.inputs); !chosen) return chosen;
  }
  opened.device = *std::move(device);
  std::optional<uint32_t> subSteps;
  if (run.report.choice) subSteps = run.report.choice->tried.back().subSteps;
  auto scene = ShotScene::create(opened.inputs, run.shot, run.project.framesPerSecond, subSteps);
  if (!scene) return scene.error();
  opened.scene.emplace(*std::move(scene));
  run.report.subSteps = opened.scene->subSteps();
  for (const BakedHair& hair : opened.scene->hairs()) {
    run.report.vertices += hair.vertexCount;
    run.report.strands += hair.vertexCounts.size();
  }
  return {};
}

// Brings the scene to the latest checkpoint that is not behind the first frame to write.
Result<void> resume(Run& run, OpenShot& opened, uint64_t firstMissing) {
  std::vector<uint64_t> checkpoints = run.store.checkpoints();
  while (!checkpoints.empty()) {
    const uint64_t steps = checkpoints.back();
    checkpoints.pop_back();
    if (steps == 0 || steps > firstMissing) continue;
    const Path path = run.store.checkpointFile(steps);
    const auto loaded = loadCheckpoint(path, run.key(steps), *opened.scene);
    if (loaded) {
      opened.steps = run.report.resumedSteps = steps;
      break;
    }
    run.warn(loaded.error().message + "; going on from an earlier frame");
    std::error_code ignored;
    std::filesystem::remove(path, ignored);
    auto scene = ShotScene::create(opened.inputs, run.shot, run.project.framesPerSecond,
                                   run.report.subSteps);
    if (!scene) return scene.error();
    opened.scene.emplace(*std::move(scene));
  }
  opened.scene->scene().setTier(opened.device->info().tier);
  return run.store.log({{"event", "start"},
                        {"frames", {run.range.first, run.range.last}},
                        {"from", opened.steps},
                        {"device", run.report.device}});
}

// Times steps, and the time since the run was asked to stop.
class StepClock {
 public:
  using Clock = std::chrono::steady_clock;

  void endStep() {
    const auto now = Clock::now();
    stepSeconds_ = secondsBetween(std::exchange(stepEnd_, now), now);
  }
  // Call it once the run was asked to stop: whether frames end within this time from the first
  // call.
  bool endsWithin(double seconds, int64_t frames) {
    const auto now = Clock::now();
    if (!stoppedAt_) stoppedAt_ = now;
    return secondsBetween(*stoppedAt_, now) + static_cast<double>(frames) * stepSeconds_ <= seconds;
  }
  double sinceStart() const { return secondsBetween(start_, Clock::now()); }

 private:
  static double secondsBetween(Clock::time_point a, Clock::time_point b) {
    return std::chrono::duration<double>(b - a).count();
  }

  Clock::time_point start_ = Clock::now(), stepEnd_ = start_;
  double stepSeconds_ = 0;  // of the last step, with what is read and waited for
  std::optional<Clock::time_point> stoppedAt_;
};

// Simulates the frames of chunks, and hands them to the writer.
class ShotSimulation {
 public:
  ShotSimulation(Run& run, OpenShot& opened, uint64_t lastChunk)
      : run_(run),
        scene_(*opened.scene),
        device_(*opened.device),
        steps_(opened.steps),
        firstStep_(opened.steps),
        lastStep_(scene_.stepOf(chunkOf(run.project, run.shot, lastChunk).last) + 1),
        writer_(run.project, run.shot, scene_.hairs(), run.tag, threadsOf(run.options)) {}

  Result<void> simulate(const std::vector<uint64_t>& chunks);

 private:
  Result<void> runChunk(uint64_t chunk);
  Result<void> runStep();
  bool isCheckpoint(uint64_t chunk, bool stops) const;
  Result<void> checkpoint();

  Run& run_;
  ShotScene& scene_;
  HeadlessDevice& device_;
  uint64_t& steps_;
  const uint64_t firstStep_, lastStep_;  // for progress
  ChunkWriter writer_;
  StepClock clock_;
};

Result<void> ShotSimulation::runStep() {
  if (auto done = scene_.run(steps_, device_); !done) return done;
  ++steps_;
  ++run_.report.stepsRun;
  clock_.endStep();
  if (run_.options.progress) run_.options.progress(steps_ - firstStep_, lastStep_ - firstStep_);
  return {};
}

Result<void> ShotSimulation::simulate(const std::vector<uint64_t>& chunks) {
  Result<void> done;
  for (const uint64_t chunk : chunks) {
    const FrameRange frames = chunkOf(run_.project, run_.shot, chunk);
    while (done && !run_.stopped() && steps_ < scene_.stepOf(frames.first)) done = runStep();
    if (done && !run_.stopped()) done = runChunk(chunk);
    if (!done) break;
    const bool between =
        steps_ <= scene_.stepOf(frames.first) || steps_ > scene_.stepOf(frames.last);
    const bool stops = run_.stopped();
    if (between && isCheckpoint(chunk, stops)) done = checkpoint();
    if (!done || stops) break;
  }
  if (done && run_.stopped() && steps_ < lastStep_) run_.report.outcome = RunOutcome::kInterrupted;
  // Complete chunks are written, whatever ended the run.
  const Result<void> written = writer_.close();
  run_.report.framesWritten = writer_.report().frames;
  run_.report.encodingSeconds = writer_.report().seconds;
  run_.report.waitingSeconds = writer_.report().waitedFor;
  run_.report.seconds = clock_.sinceStart();
  return done ? written : done;
}

Result<void> ShotSimulation::runChunk(uint64_t chunk) {
  const FrameRange frames = chunkOf(run_.project, run_.shot, chunk);
  for (int64_t frame = frames.first; frame <= frames.last; ++frame) {
    if (run_.stopped() && !clock_.endsWithin(run_.options.graceSeconds, frames.last - frame + 1))
      return {};
    if (auto done = runStep(); !done) return done;
    const auto start = std::chrono::steady_clock::now();
    std::vector<std::vector<std::byte>> positions;
    for (const BakedHair& hair : scene_.hairs()) {
      auto bytes = scene_.readBytes(hair, device_);
      if (!bytes) return bytes.error();
      positions.push_back(*std::move(bytes));
    }
    run_.report.readingSeconds +=
        std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    if (auto done = writer_.add(chunk, frame, std::move(positions)); !done) return done;
  }
  return {};
}

// Behind every n-th chunk, behind the range where another one goes on, and where the run ends
// early.
bool ShotSimulation::isCheckpoint(uint64_t chunk, bool stops) const {
  if (stops) return run_.options.graceSeconds > 0 && steps_ > run_.report.resumedSteps;
  const FrameRange frames = chunkOf(run_.project, run_.shot, chunk);
  return (chunk + 1) % run_.project.checkpointChunks == 0 || frames.last == run_.range.last;
}

Result<void> ShotSimulation::checkpoint() {
  if (steps_ == scene_.stepCount()) return {};
  const auto saved = saveCheckpoint(run_.store.checkpointFile(steps_), run_.tag, run_.key(steps_),
                                    scene_, device_);
  if (!saved) return saved.error();
  // Earlier ones of this range are of no more use once the chunks between are on the disk.
  if (auto written = writer_.flush(); !written) return written;
  std::error_code ignored;
  for (const uint64_t steps : run_.store.checkpoints())
    if (steps < steps_ && (steps > scene_.stepOf(run_.range.first) || steps < run_.shot.preRoll))
      std::filesystem::remove(run_.store.checkpointFile(steps), ignored);
  return {};
}

// Gives a file of the shot, which has been written under its temporary name, its own.
Result<void> keep(const Run& run, const Path& path, std::vector<StoredFile>& files) {
  const Path temporary = temporaryName(path, run.tag);
  auto file = storedFile(temporary, path.filename().string());
  if (!file) return file.error();
  if (auto done = commitFile(temporary, path); !done) return done;
  files.push_back(*std::move(file));
  return {};
}

// The files of a groom.
Result<std::vector<StoredFile>> joinHair(const Run& run, const std::string& hair, float width,
                                         uint32_t threads) {
  std::vector<StoredFile> files;
  std::vector<Path> parts;
  for (uint64_t i = 0; i < chunkCount(run.project, run.shot); ++i)
    parts.push_back(run.store.chunkFile(hair, i));
  const Path cache = run.store.folder() / (hair + ".pelagecache");
  if (auto done = joinHairCaches(parts, temporaryName(cache, run.tag)); !done) return done.error();
  if (auto done = keep(run, cache, files); !done) return done.error();
  if (!run.project.usd) return files;
  const Path usd = run.store.folder() / (hair + ".usda");
  if (auto done = writeUsd(cache, width, temporaryName(usd, run.tag), threads); !done)
    return done.error();
  if (auto done = keep(run, usd, files); !done) return done.error();
  return files;
}

Result<std::vector<StoredFile>> joinChunks(const Run& run, const std::vector<std::string>& hairs) {
  SceneSettings settings;
  if (!run.shot.settings.empty()) {
    const auto loaded = SettingsFile::load(run.shot.settings);
    if (!loaded) return loaded.error();
    loaded->apply(settings);
  }
  const float width = 2 * settings.material.fiberRadius;
  const uint32_t threads = threadsOf(run.options);
  const uint32_t atOnce = std::clamp(static_cast<uint32_t>(hairs.size()), 1u, threads);
  std::vector<Result<std::vector<StoredFile>>> joined(hairs.size(), std::vector<StoredFile>());
  std::atomic<size_t> next = 0;
  const auto join = [&] {
    for (size_t i = next++; i < hairs.size(); i = next++)
      joined[i] = tools::guarded([&] { return joinHair(run, hairs[i], width, threads / atOnce); });
  };
  {
    std::vector<std::jthread> others;
    while (others.size() + 1 < atOnce) others.emplace_back(join);
    join();
  }
  std::vector<StoredFile> files;
  for (auto& one : joined) {
    if (!one) return one.error();
    files.insert(files.end(), one->begin(), one->end());
  }
  return files;
}

Result<void> commit(Run& run, const std::vector<StoredFile>& files) {
  std::string device;
  const auto known = run.store.fingerprint(&device);
  if (!known) return known.error();
  json done = {{"inputs", fmt::format("{:016x}", run.fingerprint)},
               {"device", device},
               {"frames", {run.shot.frames.first, run.shot.frames.last}},
               {"files", toJson(files)}};
  if (std::error_code ignored; std::filesystem::exists(run.store.subStepsFile(), ignored)) {
    const auto loaded = loadJson(run.store.subStepsFile().string());
    if (!loaded) return loaded.error();
    const auto choice = subStepsOf(*loaded, run.store.subStepsFile().string());
    if (!choice) return choice.error();
    const SubStepError& chosen = choice->tried.back();
    done["subSteps"] = chosen.subSteps;
    done["error"] = chosen.error;
    done["errorBound"] = choice->bound.length;
    done["errorShare"] = choice->bound.share;
  }
  if (auto written = writeAtomic(run.store.folder() / "done.json", run.tag, done.dump(1) + "\n");
      !written)
    return written;
  std::error_code ignored;
  std::filesystem::remove_all(run.store.work(), ignored);
  run.report.outcome = RunOutcome::kComplete;
  return run.store.log({{"event", "done"},
                        {"steps", run.report.stepsRun},
                        {"resumed", run.report.resumedSteps},
                        {"seconds", run.report.seconds}});
}

// Completes the shot if no chunk is missing. Whoever is last does it.
Result<void> finish(Run& run) {
  const auto lock = FileLock::take(run.store.lockPath(), FileLock::Wait::kYes);
  if (!lock) return lock.error();
  const auto complete = isComplete(run, false);
  if (!complete) return complete.error();
  if (*complete) return {};
  const uint64_t count = chunkCount(run.project, run.shot);
  std::vector<std::string> hairs;
  for (uint64_t i = 0; i < count; ++i) {
    const std::vector<StoredFile> files = run.store.chunk(i, false);
    if (files.empty()) {
      run.report.outcome = RunOutcome::kRangeDone;
      return run.store.log({{"event", "range"},
                            {"frames", {run.range.first, run.range.last}},
                            {"steps", run.report.stepsRun}});
    }
    if (i > 0) continue;
    // GROOM.000000.pelagecache
    for (const StoredFile& file : files)
      hairs.push_back(Path(Path(file.name).stem()).stem().string());
  }
  auto files = joinChunks(run, hairs);
  if (!files) return files.error();
  return commit(run, *files);
}

Result<void> work(Run& run, const std::vector<uint64_t>& chunks) {
  std::vector<uint64_t> missing;
  for (const uint64_t chunk : chunks)
    if (run.store.chunk(chunk, true).empty()) missing.push_back(chunk);
  if (!missing.empty()) {
    OpenShot opened;
    if (auto done = openShot(run, opened); !done) return done;
    const int64_t firstFrame = chunkOf(run.project, run.shot, missing.front()).first;
    if (auto done = resume(run, opened, opened.scene->stepOf(firstFrame)); !done) return done;
    if (auto done = ShotSimulation(run, opened, missing.back()).simulate(missing); !done)
      return done;
    if (run.report.outcome == RunOutcome::kInterrupted)
      return run.store.log({{"event", "interrupted"}, {"steps", opened.steps}});
  }
  return finish(run);
}

}  // namespace

Result<std::unique_ptr<HeadlessDevice>> RunResources::device(Api api, const std::string& wanted) {
  if (api != Api::kVulkan) return openDevice(api, wanted);
  const std::lock_guard lock(deviceMutex_);
  if (device_ == nullptr) {
    auto opened = openDevice(api, wanted, jobs_);
    if (!opened) return opened;
    device_ = *std::move(opened);
  }
  return device_->another();
}

Result<uint64_t> RunResources::fingerprint(const Project& project, const Shot& shot) {
  const std::lock_guard lock(assetsMutex_);
  return fingerprintOf(project, shot, hashes_);
}

Result<ShotInputs> RunResources::inputs(const Shot& shot) {
  std::shared_ptr<Assets> assets;
  {
    const std::lock_guard lock(assetsMutex_);
    const auto key = assetKeyOf(shot, hashes_);
    if (!key) return key.error();
    const auto found = std::find_if(assets_.begin(), assets_.end(),
                                    [&](const auto& one) { return one->key == *key; });
    assets = found != assets_.end() ? *found : std::make_shared<Assets>();
    assets->key = *key;
    if (found != assets_.end()) assets_.erase(found);
    assets_.push_back(assets);
    if (assets_.size() > jobs_) assets_.pop_front();
  }
  std::unique_lock lock(assets->mutex);
  if (!assets->loaded) {
    auto loaded = loadAssets(shot);
    if (!loaded) return loaded;
    assets->loaded = *std::move(loaded);
  }
  ShotInputs inputs = *assets->loaded;
  lock.unlock();
  return loadShot(shot, std::move(inputs));
}

double RunResources::busySeconds() const {
  const std::lock_guard lock(deviceMutex_);
  return device_ != nullptr ? device_->busySeconds() : 0;
}

Result<RunReport> runShot(const Project& project, const Shot& shot, const RunOptions& options) {
  RunResources resources;
  return runShot(project, shot, options, resources);
}

Result<RunReport> runShot(const Project& project, const Shot& shot, const RunOptions& options,
                          RunResources& resources) {
  Run run = {project, shot, options, resources};
  auto chunks = chunksOf(run.project, run.shot, run.range);
  if (!chunks) return chunks.error();
  const auto fingerprint = resources.fingerprint(run.project, run.shot);
  if (!fingerprint) return fingerprint.error();
  run.fingerprint = *fingerprint;
  if (auto made = makeFolder(run.store.folder()); !made) return made.error();
  const auto lock = FileLock::take(run.store.lockPath(run.range),
                                   run.options.wait ? FileLock::Wait::kYes : FileLock::Wait::kNo);
  if (!lock) return lock.error();
  if (!lock->holds()) {
    run.report.outcome = RunOutcome::kBusy;
    return run.report;
  }
  if (run.options.restart)
    if (auto cleared = run.store.clear(); !cleared) return cleared.error();
  auto complete = isComplete(run, true);
  if (!complete) return complete.error();
  run.report.wasComplete = *complete;
  if (*complete) {
    // A run that was killed behind done.json has left it.
    std::error_code ignored;
    std::filesystem::remove_all(run.store.work(), ignored);
    removeTemporaries(run.store.folder(), run.tag);
    if (auto noted = run.store.log({{"event", "complete already"}}); !noted) return noted.error();
    return run.report;
  }
  removeTemporaries(run.store.work(), run.tag);
  removeTemporaries(run.store.folder(), run.tag);
  const Result<void> done = work(run, *chunks);
  if (done) return run.report;
  // Another process, of a range that overlaps, may have completed the shot and removed its work.
  complete = isComplete(run, false);
  if (complete && *complete) {
    run.report.outcome = RunOutcome::kComplete;
    return run.report;
  }
  (void)run.store.log({{"event", "error"}, {"message", done.error().message}});
  return done.error();
}

RunsReport runShots(const Project& project, std::span<const Shot> shots, const RunOptions& options,
                    uint32_t jobs) {
  jobs = static_cast<uint32_t>(std::min<size_t>(jobs, shots.size()));
  RunResources resources(std::max(jobs, 1u));
  RunsReport report;
  RunReport unbegun;
  unbegun.outcome = RunOutcome::kInterrupted;
  report.shots.assign(shots.size(), unbegun);
  std::mutex mutex;  // of the functions of `options`, and of `left`
  std::vector<uint64_t> left(shots.size());
  uint64_t all = 0;
  for (size_t i = 0; i < shots.size(); ++i)
    all += left[i] = shots[i].preRoll + shots[i].frames.count();
  uint64_t allLeft = all;
  const auto progress = [&](size_t i, uint64_t stillLeft) {
    const std::lock_guard lock(mutex);
    allLeft -= std::exchange(left[i], stillLeft) - stillLeft;
    if (options.progress) options.progress(all - allLeft, all);
  };
  std::atomic<size_t> next = 0;
  const auto work = [&] {
    for (size_t i = next++; i < shots.size(); i = next++) {
      if (options.interrupted && options.interrupted()) return;
      RunOptions own = options;
      own.threads = std::max(threadsOf(options) / jobs, 1u);
      own.progress = [&, i](uint64_t done, uint64_t total) { progress(i, total - done); };
      own.warn = [&, i](const std::string& text) {
        const std::lock_guard lock(mutex);
        if (options.warn) options.warn(shots.size() > 1 ? shots[i].name + ": " + text : text);
      };
      report.shots[i] = tools::guarded([&] { return runShot(project, shots[i], own, resources); });
      progress(i, 0);
    }
  };
  {
    std::vector<std::jthread> others;
    while (others.size() + 1 < jobs) others.emplace_back(work);
    work();
  }
  report.busySeconds = resources.busySeconds();
  return report;
}

Result<std::unique_ptr<HeadlessDevice>> openDevice(Api api, const std::string& device,
                                                   uint32_t queues) {
  HeadlessDef def;
  def.api = api;
  def.queues = queues;
  if (!device.empty()) {
    int index = 0;
    const char* const end = device.data() + device.size();
    const auto [stop, failed] = std::from_chars(device.data(), end, index);
    if (failed == std::errc() && stop == end && index >= 0)
      def.deviceIndex = index;
    else
      def.deviceUuid = device;
  }
  if (api == Api::kVulkan) {
#ifdef PELAGE_BAKE_VULKAN
    return createHeadlessVulkan(def);
#endif
  } else {
#ifdef PELAGE_BAKE_GL
    return createHeadlessGl(def);
#endif
  }
  return Error{ErrorCode::kUnsupported,
               fmt::format("this program was built without {}: configure with -D{}=ON",
                           apiName(api), api == Api::kVulkan ? "PELAGE_VULKAN" : "PELAGE_GL")};
}

}  // namespace pelage::bake
