#include "shot_store.h"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <chrono>
#include <fstream>
#include <utility>

#include "atomic_file.h"
#include "json_members.h"
#include "pelage/asset_cache.h"

namespace pelage::bake {
namespace {

using nlohmann::json;
using Path = std::filesystem::path;

std::string hex(uint64_t value) { return fmt::format("{:016x}", value); }

std::optional<uint64_t> fromHex(const std::string& text) {
  uint64_t value = 0;
  const auto [end, code] = std::from_chars(text.data(), text.data() + text.size(), value, 16);
  if (code != std::errc() || end != text.data() + text.size()) return std::nullopt;
  return value;
}

bool isThere(const Path& path) {
  std::error_code ignored;
  return std::filesystem::exists(path, ignored);
}

Error damaged(const std::string& name) {
  return {ErrorCode::kInvalidFile, name + ": is damaged; begin anew by --restart"};
}

// The JSON of a file that the store has written.
Result<json> loadOwn(const Path& path) {
  auto loaded = loadJson(path.string());
  if (!loaded)
    return Error{loaded.error().code, loaded.error().message + "; begin anew by --restart"};
  return loaded;
}

}  // namespace

Result<StoredFile> storedFile(const Path& path, std::string name) {
  const auto key = sourceKeyOf(path);
  if (!key) return key.error();
  return StoredFile{std::move(name), key->size, key->hash};
}

json toJson(const std::vector<StoredFile>& files) {
  json all = json::array();
  for (const StoredFile& file : files)
    all.push_back({{"name", file.name}, {"bytes", file.bytes}, {"xxh3", hex(file.hash)}});
  return all;
}

Result<std::vector<StoredFile>> filesOf(const json& from, const std::string& name) {
  std::vector<StoredFile> files;
  if (!from.is_object() || !from.contains("files") || !from["files"].is_array())
    return damaged(name);
  for (const json& file : from["files"]) {
    const bool fits = file.is_object() && file.contains("name") && file["name"].is_string() &&
                      file.contains("bytes") && file["bytes"].is_number_unsigned() &&
                      file.contains("xxh3") && file["xxh3"].is_string();
    const auto hash = fits ? fromHex(file["xxh3"].get<std::string>()) : std::nullopt;
    if (!hash) return damaged(name);
    files.push_back({file["name"].get<std::string>(), file["bytes"].get<uint64_t>(), *hash});
  }
  return files;
}

std::string faultOf(const std::vector<StoredFile>& files, const Path& folder, bool hashes) {
  for (const StoredFile& file : files) {
    std::error_code code;
    const uint64_t size = std::filesystem::file_size(folder / file.name, code);
    if (code) return fmt::format("{}: is missing", file.name);
    if (size != file.bytes)
      return fmt::format("{}: has {} bytes, and had {}", file.name, size, file.bytes);
    if (!hashes) continue;
    const auto now = storedFile(folder / file.name, file.name);
    if (!now) return now.error().message;
    if (!(*now == file)) return fmt::format("{}: has other bytes than it had", file.name);
  }
  return {};
}

ShotStore::ShotStore(const Project& project, const Shot& shot)
    : folder_(project.output / shot.name) {}

Path ShotStore::lockPath(const FrameRange& range) const {
  return folder_ / fmt::format("lock-{}-{}", range.first, range.last);
}

Path ShotStore::chunkFile(std::string_view hair, uint64_t chunk) const {
  return work() / fmt::format("{}.{:06}.pelagecache", hair, chunk);
}

Path ShotStore::checkpointFile(uint64_t steps) const {
  return work() / fmt::format("state-{:08}", steps);
}

Result<std::optional<json>> ShotStore::done() const {
  const Path path = folder_ / "done.json";
  if (!isThere(path)) return std::optional<json>();
  auto loaded = loadOwn(path);
  if (!loaded) return loaded.error();
  const auto files = filesOf(*loaded, path.string());
  if (!files) return files.error();
  return std::optional<json>(*std::move(loaded));
}

Result<std::optional<uint64_t>> ShotStore::fingerprint(std::string* device) const {
  Path path = folder_ / "done.json";
  if (!isThere(path)) path = work() / "key.json";
  if (!isThere(path)) return std::optional<uint64_t>();
  const auto key = loadOwn(path);
  if (!key) return key.error();
  const bool fits = key->is_object() && key->contains("inputs") && (*key)["inputs"].is_string() &&
                    key->contains("device") && (*key)["device"].is_string();
  const auto value = fits ? fromHex((*key)["inputs"].get<std::string>()) : std::nullopt;
  if (!value) return damaged(path.string());
  if (device != nullptr) *device = (*key)["device"].get<std::string>();
  return value;
}

Result<void> ShotStore::begin(uint64_t fingerprint, const std::string& device,
                              std::string_view tag) const {
  if (auto made = makeFolder(work()); !made) return made;
  const auto lock = FileLock::take(lockPath(), FileLock::Wait::kYes);
  if (!lock) return lock.error();
  std::string before;
  const auto known = this->fingerprint(&before);
  if (!known) return known.error();
  if (!*known)
    return writeAtomic(work() / "key.json", tag,
                       json{{"inputs", hex(fingerprint)}, {"device", device}}.dump(1) + "\n");
  if (**known != fingerprint)
    return Error{ErrorCode::kInvalidArgument,
                 fmt::format("{}: has frames of other settings or files than the project has now; "
                             "--restart begins anew, or give the shot another name",
                             folder_.string())};
  if (before != device)
    return Error{ErrorCode::kInvalidArgument,
                 fmt::format("{}: was begun on '{}', and this is '{}', which may round otherwise; "
                             "go on there, or begin anew by --restart",
                             folder_.string(), before, device)};
  return {};
}

Result<void> ShotStore::clear() const {
  std::error_code code;
  std::filesystem::remove(folder_ / "done.json", code);
  for (std::filesystem::directory_iterator it(folder_, code), end; !code && it != end;
       it.increment(code)) {
    const std::string name = it->path().filename().string();
    // Others may wait for a lock.
    if (name.rfind("lock", 0) == 0 || name == "log.jsonl") continue;
    std::error_code failed;
    std::filesystem::remove_all(it->path(), failed);
    if (failed)
      return Error{ErrorCode::kInvalidFile,
                   fmt::format("{}: cannot be removed: {}", it->path().string(), failed.message())};
  }
  return {};
}

std::vector<StoredFile> ShotStore::chunk(uint64_t chunk, bool check) const {
  const Path path = work() / fmt::format("chunk-{:06}.json", chunk);
  if (!isThere(path)) return {};
  const auto loaded = loadJson(path.string());
  if (!loaded) return {};
  const auto files = filesOf(*loaded, path.string());
  if (!files || !faultOf(*files, work(), check).empty()) return {};
  return *files;
}

Result<void> ShotStore::addChunk(uint64_t chunk, const std::vector<StoredFile>& files,
                                 std::string_view tag) const {
  return writeAtomic(work() / fmt::format("chunk-{:06}.json", chunk), tag,
                     json{{"files", toJson(files)}}.dump(1) + "\n");
}

std::vector<uint64_t> ShotStore::checkpoints() const {
  std::vector<uint64_t> steps;
  std::error_code code;
  for (std::filesystem::directory_iterator it(work(), code), end; !code && it != end;
       it.increment(code)) {
    const std::string name = it->path().filename().string();
    uint64_t count = 0;
    constexpr std::string_view kPrefix = "state-";
    if (name.rfind(kPrefix, 0) != 0) continue;
    const char* const last = name.data() + name.size();
    const auto [stop, failed] = std::from_chars(name.data() + kPrefix.size(), last, count);
    if (failed == std::errc() && stop == last) steps.push_back(count);
  }
  std::sort(steps.begin(), steps.end());
  return steps;
}

Result<void> ShotStore::log(json event) const {
  std::array<char, 256> host = {};
  if (::gethostname(host.data(), host.size() - 1) == 0) event["host"] = host.data();
  event["process"] = ::getpid();
  event["time"] =
      std::chrono::duration<double>(std::chrono::system_clock::now().time_since_epoch()).count();
  return appendLine(folder_ / "log.jsonl",
                    event.dump(-1, ' ', false, json::error_handler_t::replace));
}

std::vector<json> ShotStore::events() const {
  std::vector<json> events;
  std::ifstream file(folder_ / "log.jsonl");
  for (std::string line; std::getline(file, line);) {
    json event = json::parse(line, nullptr, false);
    if (event.is_object()) events.push_back(std::move(event));
  }
  return events;
}

}  // namespace pelage::bake
