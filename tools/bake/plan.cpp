#include "plan.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <utility>

#include "atomic_file.h"
#include "pelage/hair_cache.h"
#include "shot_store.h"

namespace pelage::bake {
namespace {

using nlohmann::json;
using Path = std::filesystem::path;

uint64_t unsignedOf(const json& event, const char* key) {
  return event.contains(key) && event[key].is_number_unsigned() ? event[key].get<uint64_t>() : 0;
}

void addEvents(const std::vector<json>& events, ShotStatus& status) {
  for (const json& event : events) {
    const std::string what =
        event.contains("event") && event["event"].is_string() ? event["event"] : "";
    status.stepsRun += what == "done" || what == "range" ? unsignedOf(event, "steps") : 0;
    if (event.contains("seconds") && event["seconds"].is_number())
      status.seconds += event["seconds"].get<double>();
    status.starts += what == "start" ? 1 : 0;
    status.errors += what == "error" ? 1 : 0;
    if (what == "error" && event.contains("message") && event["message"].is_string())
      status.lastError = event["message"];
  }
}

bool isRunning(const ShotStore& store) {
  std::error_code code;
  for (std::filesystem::directory_iterator it(store.folder(), code), end; !code && it != end;
       it.increment(code))
    if (it->path().filename().string().rfind("lock", 0) == 0 && FileLock::isHeld(it->path()))
      return true;
  return false;
}

uint64_t totalBytes(const std::vector<StoredFile>& files) {
  uint64_t sum = 0;
  for (const StoredFile& file : files) sum += file.bytes;
  return sum;
}

// A fault of a complete shot, with the way out.
std::string withRestart(const std::string& fault, const Project& project, const Shot& shot) {
  if (fault.empty()) return fault;
  return fmt::format("{}; begin anew: pelage-bake run {} --shot {} --restart", fault,
                     shellWord(project.file.string()), shellWord(shot.name));
}

// Returns the error of a cache of a shot; empty if there is none.
std::string faultOfCache(const Path& path, const Shot& shot, bool decode) {
  auto reader = HairCacheReader::open(path);
  if (!reader) return reader.error().message;
  if (reader->frameCount() != shot.frames.count() || reader->def().firstFrame != shot.frames.first)
    return fmt::format("{}: has {} frames from {}, and the shot has {} from {}", path.string(),
                       reader->frameCount(), reader->def().firstFrame, shot.frames.count(),
                       shot.frames.first);
  std::vector<Float3> positions(reader->vertexCount());
  for (uint64_t frame = 0; decode && frame < reader->frameCount(); ++frame)
    if (auto done = reader->read(frame, positions); !done) return done.error().message;
  return {};
}

}  // namespace

std::string shellWord(const std::string& text) {
  const bool plain = !text.empty() && std::all_of(text.begin(), text.end(), [](char c) {
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') ||
           std::string_view("/._-+=:,@%").find(c) != std::string_view::npos;
  });
  if (plain) return text;
  std::string quoted = "'";
  for (const char c : text) quoted += c == '\'' ? "'\\''" : std::string(1, c);
  return quoted + "'";
}

std::vector<std::string> planCommands(const Project& project, const std::string& program,
                                      uint64_t rangeFrames, uint64_t shotCount) {
  std::vector<std::string> commands;
  for (size_t first = 0; first < project.shots.size(); first += shotCount) {
    const Shot& shot = project.shots[first];
    std::string names = shot.name;
    for (size_t i = first + 1; i < std::min(first + shotCount, project.shots.size()); ++i)
      names += "," + project.shots[i].name;
    const std::string command = fmt::format("{} run {} --shot {}", shellWord(program),
                                            shellWord(project.file.string()), shellWord(names));
    if (shotCount > 1 || rangeFrames == 0 || shot.frames.count() <= rangeFrames) {
      commands.push_back(command);
      continue;
    }
    FrameRange range = chunkOf(project, shot, 0);
    const uint64_t chunks = chunkCount(project, shot);
    for (uint64_t i = 1; i <= chunks; ++i) {
      const FrameRange next = i < chunks ? chunkOf(project, shot, i) : FrameRange{0, -1};
      if (i < chunks && range.count() + next.count() <= rangeFrames) {
        range.last = next.last;
        continue;
      }
      commands.push_back(fmt::format("{} --frames={}-{}", command, range.first, range.last));
      range = next;
    }
  }
  return commands;
}

std::optional<FrameRange> parseFrames(const std::string& text) {
  const char* const end = text.data() + text.size();
  FrameRange range;
  const auto [middle, failed] = std::from_chars(text.data(), end, range.first);
  if (failed != std::errc() || middle == end || *middle != '-') return std::nullopt;
  const auto [stop, alsoFailed] = std::from_chars(middle + 1, end, range.last);
  if (alsoFailed != std::errc() || stop != end || range.last < range.first) return std::nullopt;
  return range;
}

const char* toString(ShotState state) {
  switch (state) {
    case ShotState::kMissing:
      return "missing";
    case ShotState::kPartial:
      return "partial";
    case ShotState::kRunning:
      return "running";
    case ShotState::kComplete:
      return "complete";
    case ShotState::kDamaged:
      return "damaged";
    case ShotState::kStale:
      return "stale";
  }
  return "unknown";
}

Result<ShotStatus> statusOf(const Project& project, const Shot& shot, FileHashes& hashes,
                            bool check) {
  const ShotStore store(project, shot);
  ShotStatus status;
  status.chunks = chunkCount(project, shot);
  const auto fingerprint = fingerprintOf(project, shot, hashes);
  if (!fingerprint) return fingerprint.error();
  addEvents(store.events(), status);
  const auto known = store.fingerprint();
  const auto done = store.done();
  if (!known || !done) {
    status.state = ShotState::kDamaged;
    status.fault = (known ? done.error() : known.error()).message;
    return status;
  }
  if (*done) {
    const auto files = filesOf(**done, "done.json");
    if (!files) return files.error();
    status.chunksWritten = status.chunks;
    status.bytes = totalBytes(*files);
    status.fault = withRestart(faultOf(*files, store.folder(), check), project, shot);
    status.state = status.fault.empty() ? ShotState::kComplete : ShotState::kDamaged;
  } else {
    for (uint64_t i = 0; i < status.chunks; ++i) {
      const std::vector<StoredFile> files = store.chunk(i, check);
      status.chunksWritten += files.empty() ? 0 : 1;
      status.bytes += totalBytes(files);
    }
    const std::vector<uint64_t> checkpoints = store.checkpoints();
    if (!checkpoints.empty()) status.checkpointSteps = checkpoints.back();
    if (*known) status.state = ShotState::kPartial;
    if (isRunning(store)) status.state = ShotState::kRunning;
  }
  if (*known && **known != *fingerprint) status.state = ShotState::kStale;
  return status;
}

Result<ShotCheck> verifyShot(const Project& project, const Shot& shot, bool decode) {
  const ShotStore store(project, shot);
  ShotCheck check;
  const auto done = store.done();
  if (!done) return done.error();
  if (!*done) {
    for (uint64_t i = 0; i < chunkCount(project, shot); ++i) {
      const std::vector<StoredFile> files = store.chunk(i, true);
      check.files += files.size();
      check.bytes += totalBytes(files);
      if (files.empty() && check.fault.empty())
        check.fault = fmt::format("chunk {} is missing or damaged; run the shot again", i);
    }
    return check;
  }
  check.complete = true;
  const auto files = filesOf(**done, "done.json");
  if (!files) return files.error();
  check.files = files->size();
  check.bytes = totalBytes(*files);
  check.fault = faultOf(*files, store.folder(), true);
  for (const StoredFile& file : *files)
    if (check.fault.empty() && Path(file.name).extension() == ".pelagecache")
      check.fault = faultOfCache(store.folder() / file.name, shot, decode);
  check.fault = withRestart(check.fault, project, shot);
  return check;
}

}  // namespace pelage::bake
