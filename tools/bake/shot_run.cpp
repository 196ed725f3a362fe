#include "shot_run.h"

#include <fmt/format.h>

#include <algorithm>
#include <atomic>
#include <charconv>
#include <chrono>
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

// One run of one range.
class ShotRun {
 public:
  ShotRun(const Project& project, const Shot& shot, const RunOptions& options)
      : project_(project),
        shot_(shot),
        options_(options),
        range_(options.range.value_or(shot.frames)),
        store_(project, shot),
        tag_(fmt::format("{}-{}", range_.first, range_.last)) {}

  Result<RunReport> run();

 private:
  Result<bool> isComplete();
  Result<void> work();
  Result<void> chooseSteps(const ShotInputs& inputs);
  Result<void> prepare();
  Result<void> resume(uint64_t firstMissing);
  Result<void> simulate(const std::vector<uint64_t>& missing);
  Result<void> runChunk(uint64_t chunk);
  Result<void> runStep();
  bool isInGrace(int64_t frames);
  bool isCheckpoint(uint64_t chunk, bool stops) const;
  Result<void> checkpoint();
  Result<void> finish();
  Result<void> keep(const Path& path, std::vector<StoredFile>& files) const;
  Result<std::vector<StoredFile>> joinChunks(const std::vector<std::string>& hairs) const;
  Result<std::vector<StoredFile>> joinHair(const std::string& hair, float width,
                                           uint32_t threads) const;
  Result<void> commit(std::vector<StoredFile> files);
  bool stopped() const { return options_.interrupted && options_.interrupted(); }
  void warn(const std::string& text) const {
    if (options_.warn) options_.warn(text);
  }
  CheckpointKey key(uint64_t steps) const { return {fingerprint_, steps, report_.device}; }

  const Project& project_;
  const Shot& shot_;
  const RunOptions& options_;
  FrameRange range_;
  ShotStore store_;
  std::string tag_;
  uint64_t fingerprint_ = 0;
  std::vector<uint64_t> chunks_;
  RunReport report_;

  std::optional<ShotInputs> inputs_;
  std::optional<ShotScene> scene_;
  std::unique_ptr<HeadlessDevice> device_;
  std::optional<ChunkWriter> writer_;
  uint64_t steps_ = 0;                     ///< that the scene has run
  uint64_t firstStep_ = 0, lastStep_ = 0;  ///< of this run, for progress
  std::chrono::steady_clock::time_point stepEnd_;
  double stepSeconds_ = 0;  ///< of the last step, with what is read and waited for
  std::optional<std::chrono::steady_clock::time_point> stoppedAt_;
};

Result<bool> ShotRun::isComplete() {
  const auto done = store_.done();
  if (!done) return done.error();
  if (!*done) return false;
  const auto known = store_.fingerprint(&report_.device);
  if (!known) return known.error();
  if (**known != fingerprint_)
    return Error{ErrorCode::kInvalidArgument,
                 fmt::format("{}: is complete, with other settings or files than the project has "
                             "now; --restart begins anew, or give the shot another name",
                             store_.folder().string())};
  const auto files = filesOf(**done, "done.json");
  const std::string fault = files ? faultOf(*files, store_.folder(), false) : "";
  if (!fault.empty())
    return Error{ErrorCode::kInvalidFile,
                 fmt::format("{}: {}; begin anew by --restart", store_.folder().string(), fault)};
  return true;
}

Result<RunReport> ShotRun::run() {
  auto chunks = chunksOf(project_, shot_, range_);
  if (!chunks) return chunks.error();
  chunks_ = *std::move(chunks);
  FileHashes hashes;
  const auto fingerprint = fingerprintOf(project_, shot_, hashes);
  if (!fingerprint) return fingerprint.error();
  fingerprint_ = *fingerprint;
  if (auto made = makeFolder(store_.folder()); !made) return made.error();
  const auto lock = FileLock::take(store_.lockPath(range_),
                                   options_.wait ? FileLock::Wait::kYes : FileLock::Wait::kNo);
  if (!lock) return lock.error();
  if (!lock->holds()) {
    report_.outcome = RunOutcome::kBusy;
    return report_;
  }
  if (options_.restart)
    if (auto cleared = store_.clear(); !cleared) return cleared.error();
  auto complete = isComplete();
  if (!complete) return complete.error();
  report_.wasComplete = *complete;
  if (*complete) {
    // A run that was killed behind done.json has left it.
    std::error_code ignored;
    std::filesystem::remove_all(store_.work(), ignored);
    removeTemporaries(store_.folder(), tag_);
    if (auto noted = store_.log({{"event", "complete already"}}); !noted) return noted.error();
    return report_;
  }
  removeTemporaries(store_.work(), tag_);
  removeTemporaries(store_.folder(), tag_);
  const Result<void> done = work();
  if (done) return report_;
  // Another process, of a range that overlaps, may have completed the shot and removed its work.
  complete = isComplete();
  if (complete && *complete) {
    report_.outcome = RunOutcome::kComplete;
    return report_;
  }
  (void)store_.log({{"event", "error"}, {"message", done.error().message}});
  return done.error();
}

Result<void> ShotRun::work() {
  std::vector<uint64_t> missing;
  for (const uint64_t chunk : chunks_)
    if (store_.chunk(chunk, true).empty()) missing.push_back(chunk);
  if (!missing.empty()) {
    if (auto done = prepare(); !done) return done;
    if (auto done = resume(scene_->stepOf(chunkOf(project_, shot_, missing.front()).first)); !done)
      return done;
    if (auto done = simulate(missing); !done) return done;
    if (report_.outcome == RunOutcome::kInterrupted)
      return store_.log({{"event", "interrupted"}, {"steps", steps_}});
  }
  return finish();
}

// Device, inputs and scene, and what the folder is of.
Result<void> ShotRun::prepare() {
  auto inputs = loadShot(shot_);
  if (!inputs) return inputs.error();
  inputs_ = *std::move(inputs);
  for (const std::string& warning : inputs_->warnings) warn(warning);
  const std::string& wanted = options_.device.empty() ? project_.device : options_.device;
  auto device = openDevice(project_.api, wanted);
  if (!device) return device.error();
  report_.device = deviceName((*device)->info());
  if (auto begun = store_.begin(fingerprint_, report_.device, tag_); !begun) return begun;
  if (shot_.errorBound) {
    if (auto chosen = chooseSteps(*inputs_); !chosen) return chosen;
  }
  device_ = *std::move(device);
  std::optional<uint32_t> subSteps;
  if (report_.choice) subSteps = report_.choice->tried.back().subSteps;
  auto scene = ShotScene::create(*inputs_, shot_, project_.framesPerSecond, subSteps);
  if (!scene) return scene.error();
  scene_.emplace(*std::move(scene));
  report_.subSteps = scene_->subSteps();
  for (const BakedHair& hair : scene_->hairs()) {
    report_.vertices += hair.vertexCount;
    report_.strands += hair.vertexCounts.size();
  }
  return {};
}

// An earlier run has chosen, or this one does.
Result<void> ShotRun::chooseSteps(const ShotInputs& inputs) {
  const Path path = store_.subStepsFile();
  if (std::error_code ignored; std::filesystem::exists(path, ignored)) {
    const auto loaded = loadJson(path.string());
    if (!loaded) return loaded.error();
    auto choice = subStepsOf(*loaded, path.string());
    if (!choice) return choice.error();
    report_.choice = *std::move(choice);
    return {};
  }
  const std::string& wanted = options_.device.empty() ? project_.device : options_.device;
  auto choice = chooseSubSteps(inputs, shot_, project_.framesPerSecond,
                               [&] { return openDevice(project_.api, wanted); });
  if (!choice) return choice.error();
  report_.choice = *std::move(choice);
  return writeAtomic(path, tag_, toJson(*report_.choice).dump(1) + "\n");
}

// Brings the scene to the latest checkpoint that is not behind the first frame to write.
Result<void> ShotRun::resume(uint64_t firstMissing) {
  std::vector<uint64_t> checkpoints = store_.checkpoints();
  while (!checkpoints.empty()) {
    const uint64_t steps = checkpoints.back();
    checkpoints.pop_back();
    if (steps == 0 || steps > firstMissing) continue;
    const Path path = store_.checkpointFile(steps);
    const auto loaded = loadCheckpoint(path, key(steps), *scene_);
    if (loaded) {
      steps_ = report_.resumedSteps = steps;
      break;
    }
    warn(loaded.error().message + "; going on from an earlier frame");
    std::error_code ignored;
    std::filesystem::remove(path, ignored);
    auto scene = ShotScene::create(*inputs_, shot_, project_.framesPerSecond, report_.subSteps);
    if (!scene) return scene.error();
    scene_.emplace(*std::move(scene));
  }
  scene_->scene().setTier(device_->info().tier);
  return store_.log({{"event", "start"},
                     {"frames", {range_.first, range_.last}},
                     {"from", steps_},
                     {"device", report_.device}});
}

Result<void> ShotRun::runStep() {
  if (auto done = scene_->run(steps_, *device_); !done) return done;
  ++steps_;
  ++report_.stepsRun;
  const auto now = std::chrono::steady_clock::now();
  stepSeconds_ = std::chrono::duration<double>(now - std::exchange(stepEnd_, now)).count();
  if (options_.progress) options_.progress(steps_ - firstStep_, lastStep_ - firstStep_);
  return {};
}

Result<void> ShotRun::simulate(const std::vector<uint64_t>& missing) {
  const auto start = std::chrono::steady_clock::now();
  firstStep_ = steps_;
  lastStep_ = scene_->stepOf(chunkOf(project_, shot_, missing.back()).last) + 1;
  writer_.emplace(project_, shot_, scene_->hairs(), tag_, threadsOf(options_));
  Result<void> done;
  stepEnd_ = start;
  for (const uint64_t chunk : missing) {
    const FrameRange frames = chunkOf(project_, shot_, chunk);
    while (done && !stopped() && steps_ < scene_->stepOf(frames.first)) done = runStep();
    if (done && !stopped()) done = runChunk(chunk);
    if (!done) break;
    const bool between =
        steps_ <= scene_->stepOf(frames.first) || steps_ > scene_->stepOf(frames.last);
    const bool stops = stopped();
    if (between && isCheckpoint(chunk, stops)) done = checkpoint();
    if (!done || stops) break;
  }
  if (done && stopped() && steps_ < lastStep_) report_.outcome = RunOutcome::kInterrupted;
  // Complete chunks are written, whatever ended the run.
  const Result<void> written = writer_->close();
  report_.framesWritten = writer_->report().frames;
  report_.encodingSeconds = writer_->report().seconds;
  report_.waitingSeconds = writer_->report().waitedFor;
  report_.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  return done ? written : done;
}

// Simulates the frames of a chunk, and hands them to the writer.
Result<void> ShotRun::runChunk(uint64_t chunk) {
  const FrameRange frames = chunkOf(project_, shot_, chunk);
  for (int64_t frame = frames.first; frame <= frames.last; ++frame) {
    if (stopped() && !isInGrace(frames.last - frame + 1)) return {};
    if (auto done = runStep(); !done) return done;
    const auto start = std::chrono::steady_clock::now();
    std::vector<std::vector<std::byte>> positions;
    for (const BakedHair& hair : scene_->hairs()) {
      auto bytes = scene_->readBytes(hair, *device_);
      if (!bytes) return bytes.error();
      positions.push_back(*std::move(bytes));
    }
    report_.readingSeconds +=
        std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    if (auto done = writer_->add(chunk, frame, std::move(positions)); !done) return done;
  }
  return {};
}

// Whether frames take no longer than an interrupted run may go on.
bool ShotRun::isInGrace(int64_t frames) {
  const auto now = std::chrono::steady_clock::now();
  if (!stoppedAt_) stoppedAt_ = now;
  const double since = std::chrono::duration<double>(now - *stoppedAt_).count();
  return since + static_cast<double>(frames) * stepSeconds_ <= options_.graceSeconds;
}

// Behind every n-th chunk, behind the range where another one goes on, and where the run ends
// early.
bool ShotRun::isCheckpoint(uint64_t chunk, bool stops) const {
  if (stops) return options_.graceSeconds > 0 && steps_ > report_.resumedSteps;
  const FrameRange frames = chunkOf(project_, shot_, chunk);
  return (chunk + 1) % project_.checkpointChunks == 0 || frames.last == range_.last;
}

Result<void> ShotRun::checkpoint() {
  if (steps_ == scene_->stepCount()) return {};
  const auto saved =
      saveCheckpoint(store_.checkpointFile(steps_), tag_, key(steps_), *scene_, *device_);
  if (!saved) return saved.error();
  // Earlier ones of this range are of no more use once the chunks between are on the disk.
  if (auto written = writer_->flush(); !written) return written;
  std::error_code ignored;
  for (const uint64_t steps : store_.checkpoints())
    if (steps < steps_ && (steps > scene_->stepOf(range_.first) || steps < shot_.preRoll))
      std::filesystem::remove(store_.checkpointFile(steps), ignored);
  return {};
}

// Completes the shot if no chunk is missing. Whoever is last does it.
Result<void> ShotRun::finish() {
  const auto lock = FileLock::take(store_.lockPath(), FileLock::Wait::kYes);
  if (!lock) return lock.error();
  const auto complete = isComplete();
  if (!complete) return complete.error();
  if (*complete) return {};
  const uint64_t count = chunkCount(project_, shot_);
  std::vector<std::string> hairs;
  for (uint64_t i = 0; i < count; ++i) {
    const std::vector<StoredFile> files = store_.chunk(i, false);
    if (files.empty()) {
      report_.outcome = RunOutcome::kRangeDone;
      return store_.log({{"event", "range"},
                         {"frames", {range_.first, range_.last}},
                         {"steps", report_.stepsRun}});
    }
    if (i > 0) continue;
    // GROOM.000000.pelagecache
    for (const StoredFile& file : files)
      hairs.push_back(Path(Path(file.name).stem()).stem().string());
  }
  auto files = joinChunks(hairs);
  if (!files) return files.error();
  return commit(*std::move(files));
}

// Gives a file of the shot, which has been written under its temporary name, its own.
Result<void> ShotRun::keep(const Path& path, std::vector<StoredFile>& files) const {
  const Path temporary = temporaryName(path, tag_);
  auto file = storedFile(temporary, path.filename().string());
  if (!file) return file.error();
  if (auto done = commitFile(temporary, path); !done) return done;
  files.push_back(*std::move(file));
  return {};
}

Result<std::vector<StoredFile>> ShotRun::joinChunks(const std::vector<std::string>& hairs) const {
  SceneSettings settings;
  if (!shot_.settings.empty()) {
    const auto loaded = SettingsFile::load(shot_.settings);
    if (!loaded) return loaded.error();
    loaded->apply(settings);
  }
  const float width = 2 * settings.material.fiberRadius;
  const uint32_t threads = threadsOf(options_);
  const uint32_t atOnce = std::clamp(static_cast<uint32_t>(hairs.size()), 1u, threads);
  std::vector<Result<std::vector<StoredFile>>> joined(hairs.size(), std::vector<StoredFile>());
  std::atomic<size_t> next = 0;
  const auto join = [&] {
    for (size_t i = next++; i < hairs.size(); i = next++)
      joined[i] = tools::guarded([&] { return joinHair(hairs[i], width, threads / atOnce); });
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

// The files of a groom.
Result<std::vector<StoredFile>> ShotRun::joinHair(const std::string& hair, float width,
                                                  uint32_t threads) const {
  std::vector<StoredFile> files;
  std::vector<Path> parts;
  for (uint64_t i = 0; i < chunkCount(project_, shot_); ++i)
    parts.push_back(store_.chunkFile(hair, i));
  const Path cache = store_.folder() / (hair + ".pelagecache");
  if (auto done = joinHairCaches(parts, temporaryName(cache, tag_)); !done) return done.error();
  if (auto done = keep(cache, files); !done) return done.error();
  if (!project_.usd) return files;
  const Path usd = store_.folder() / (hair + ".usda");
  if (auto done = writeUsd(cache, width, temporaryName(usd, tag_), threads); !done)
    return done.error();
  if (auto done = keep(usd, files); !done) return done.error();
  return files;
}

Result<void> ShotRun::commit(std::vector<StoredFile> files) {
  std::string device;
  const auto known = store_.fingerprint(&device);
  if (!known) return known.error();
  json done = {{"inputs", fmt::format("{:016x}", fingerprint_)},
               {"device", device},
               {"frames", {shot_.frames.first, shot_.frames.last}},
               {"files", toJson(files)}};
  if (std::error_code ignored; std::filesystem::exists(store_.subStepsFile(), ignored)) {
    const auto loaded = loadJson(store_.subStepsFile().string());
    if (!loaded) return loaded.error();
    const auto choice = subStepsOf(*loaded, store_.subStepsFile().string());
    if (!choice) return choice.error();
    const SubStepError& chosen = choice->tried.back();
    done["subSteps"] = chosen.subSteps;
    done["error"] = chosen.error;
    done["errorBound"] = choice->bound.length;
    done["errorShare"] = choice->bound.share;
  }
  if (auto written = writeAtomic(store_.folder() / "done.json", tag_, done.dump(1) + "\n");
      !written)
    return written;
  std::error_code ignored;
  std::filesystem::remove_all(store_.work(), ignored);
  report_.outcome = RunOutcome::kComplete;
  return store_.log({{"event", "done"},
                     {"steps", report_.stepsRun},
                     {"resumed", report_.resumedSteps},
                     {"seconds", report_.seconds}});
}

}  // namespace

Result<RunReport> runShot(const Project& project, const Shot& shot, const RunOptions& options) {
  return ShotRun(project, shot, options).run();
}

Result<std::unique_ptr<HeadlessDevice>> openDevice(Api api, const std::string& device) {
  HeadlessDef def;
  def.api = api;
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
