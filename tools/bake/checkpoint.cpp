#include "checkpoint.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cstring>
#include <span>
#include <utility>
#include <vector>

#include "atomic_file.h"
#include "pelage/asset_cache.h"
#include "pelage/stream.h"

namespace pelage::bake {
namespace {

// The file: Head, device name, a Record for each buffer, with bytes where its contents are not
// those that it was made with; last the hash of the hashes of all of these.
struct Head {
  std::array<char, 8> magic = {'P', 'L', 'G', 'S', 'T', 'A', 'T', 'E'};
  uint32_t version = 1;
  uint32_t deviceBytes = 0;
  uint64_t fingerprint = 0, steps = 0;
  uint64_t records = 0;  ///< buffers of the scene
};
struct Record {
  uint32_t buffer = 0;  ///< BufferId
  uint32_t pad = 0;
  uint64_t bytes = 0;  ///< 0: untouched
  uint64_t hash = 0;
};

template <class T>
std::span<const std::byte> bytesOf(const T& value) {
  return std::as_bytes(std::span(&value, 1));
}

uint64_t hashOf(std::span<const std::byte> bytes) { return sourceKeyOf(bytes, "").hash; }

// Writes a file and hashes its bytes.
class HashedWriter {
 public:
  explicit HashedWriter(AtomicFile file) : file_(std::move(file)) {}
  Result<void> write(std::span<const std::byte> bytes) {
    hashes_.push_back(hashOf(bytes));
    count_ += bytes.size();
    return file_.write(bytes);
  }
  Result<uint64_t> finish() {
    const uint64_t all = hashOf(std::as_bytes(std::span(hashes_)));
    if (auto done = file_.write(bytesOf(all)); !done) return done.error();
    if (auto done = file_.commit(); !done) return done.error();
    return count_ + sizeof(all);
  }

 private:
  AtomicFile file_;
  std::vector<uint64_t> hashes_;
  uint64_t count_ = 0;
};

class HashedReader {
 public:
  HashedReader(FileSource file, std::string name)
      : file_(std::move(file)), name_(std::move(name)), size_(file_.size()) {}
  Result<std::vector<std::byte>> read(uint64_t count) {
    if (count > size_ - at_) return fail("ends too early");
    std::vector<std::byte> bytes(count);
    for (size_t got = 0; got < count;) {
      const size_t more = file_.read(at_ + got, std::span(bytes).subspan(got));
      if (more == 0) return fail("cannot be read");
      got += more;
    }
    at_ += count;
    hashes_.push_back(hashOf(bytes));
    return bytes;
  }
  template <class T>
  Result<T> read() {
    const auto bytes = read(sizeof(T));
    if (!bytes) return bytes.error();
    T value;
    std::memcpy(&value, bytes->data(), sizeof(T));
    return value;
  }
  Result<void> finish() {
    const uint64_t all = hashOf(std::as_bytes(std::span(hashes_)));
    const auto written = read<uint64_t>();
    if (!written) return written.error();
    if (*written != all) return fail("has a wrong checksum");
    if (at_ != size_) return fail("has more bytes than it should");
    return {};
  }
  Error fail(std::string_view what) const {
    return {ErrorCode::kInvalidFile, fmt::format("{}: byte {}: {}", name_, at_, what)};
  }

 private:
  FileSource file_;
  std::string name_;
  uint64_t size_ = 0, at_ = 0;
  std::vector<uint64_t> hashes_;
};

// Whether a buffer is as a scene makes it that runs no step. Of a scene that was restored,
// `initial` has the bytes of the checkpoint: buffers that have some are always stored.
bool isUntouched(const BufferDesc& desc, std::span<const std::byte> bytes) {
  return desc.initial.empty() &&
         std::all_of(bytes.begin(), bytes.end(), [](std::byte b) { return b == std::byte{0}; });
}

std::vector<BufferId> buffersOf(const ResourceTable& table) {
  std::vector<BufferId> buffers;
  for (uint32_t slot = 0; slot < table.end(); ++slot)
    if (table.at(slot) != BufferId::kInvalid) buffers.push_back(table.at(slot));
  return buffers;
}

Result<void> checkHead(const Head& head, const CheckpointKey& key, const HashedReader& reader) {
  if (head.magic != Head().magic || head.version != Head().version)
    return reader.fail("is no checkpoint of this version");
  if (head.fingerprint != key.fingerprint || head.steps != key.steps)
    return reader.fail("is of another shot or frame");
  return {};
}

}  // namespace

std::string deviceName(const DeviceInfo& info) {
  return fmt::format("{} ({}), {} {}", info.name, info.driver, apiName(info.api), info.version);
}

Result<uint64_t> saveCheckpoint(const std::filesystem::path& path, std::string_view tag,
                                const CheckpointKey& key, ShotScene& scene,
                                HeadlessDevice& device) {
  auto file = AtomicFile::create(path, tag);
  if (!file) return file.error();
  const ResourceTable& table = scene.scene().resources();
  const std::vector<BufferId> buffers = buffersOf(table);
  HashedWriter writer(std::move(*file));
  Head head;
  head.deviceBytes = static_cast<uint32_t>(key.device.size());
  head.fingerprint = key.fingerprint;
  head.steps = key.steps;
  head.records = buffers.size();
  if (auto done = writer.write(bytesOf(head)); !done) return done.error();
  if (auto done = writer.write(std::as_bytes(std::span(key.device))); !done) return done.error();
  for (const BufferId buffer : buffers) {
    auto bytes = device.read(buffer);
    if (!bytes) return bytes.error();
    const bool stored = !isUntouched(*table.find(buffer), *bytes);
    if (!stored) bytes->clear();
    const Record record = {static_cast<uint32_t>(buffer), 0, bytes->size(), hashOf(*bytes)};
    if (auto done = writer.write(bytesOf(record)); !done) return done.error();
    if (!stored) continue;
    if (auto done = writer.write(*bytes); !done) return done.error();
  }
  return writer.finish();
}

Result<void> loadCheckpoint(const std::filesystem::path& path, const CheckpointKey& key,
                            ShotScene& scene) {
  auto file = FileSource::open(path);
  if (!file) return file.error();
  HashedReader reader(std::move(*file), path.string());
  const auto head = reader.read<Head>();
  if (!head) return head.error();
  if (auto fine = checkHead(*head, key, reader); !fine) return fine;
  const auto device = reader.read(head->deviceBytes);
  if (!device) return device.error();
  const auto same = std::as_bytes(std::span(key.device));
  if (!std::equal(device->begin(), device->end(), same.begin(), same.end()))
    return reader.fail("is of another device or driver");
  for (uint64_t step = 0; step < key.steps; ++step)
    if (auto done = scene.note(step); !done) return done;
  ResourceTable& table = scene.scene().resources();
  if (head->records != table.count()) return reader.fail("has other buffers than the scene");
  for (uint64_t i = 0; i < head->records; ++i) {
    const auto record = reader.read<Record>();
    if (!record) return record.error();
    // The upper half of an id is that of another run.
    const uint32_t slot = ResourceTable::indexOf(static_cast<BufferId>(record->buffer));
    const BufferId buffer = slot < table.end() ? table.at(slot) : BufferId::kInvalid;
    const BufferDesc* desc = table.find(buffer);
    if (desc == nullptr || static_cast<uint32_t>(buffer) != record->buffer ||
        (record->bytes != 0 && record->bytes != desc->size))
      return reader.fail("has other buffers than the scene");
    if (record->bytes == 0) continue;
    const auto bytes = reader.read(record->bytes);
    if (!bytes) return bytes.error();
    if (hashOf(*bytes) != record->hash) return reader.fail("has a wrong checksum");
    table.setInitial(buffer, *bytes);
  }
  return reader.finish();
}

}  // namespace pelage::bake
