#include "chunk_writer.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <utility>

#include "atomic_file.h"
#include "common/errors.h"

namespace pelage::bake {
namespace {

using Clock = std::chrono::steady_clock;
using Path = std::filesystem::path;

constexpr uint32_t kMaxKeyInterval = 16;

double secondsSince(Clock::time_point start) {
  return std::chrono::duration<double>(Clock::now() - start).count();
}

// Chunks begin at key frames, so that joining them gives what one writer would have written.
uint32_t keyIntervalOf(const Project& project) {
  uint32_t interval = std::min(project.chunkFrames, kMaxKeyInterval);
  while (project.chunkFrames % interval != 0) --interval;
  return interval;
}

HairCacheDef cacheDefOf(const Project& project, const BakedHair& hair, int64_t firstFrame) {
  HairCacheDef def;
  def.name = hair.name;
  def.strandCount = static_cast<uint32_t>(hair.vertexCounts.size());
  def.verticesPerStrand = hair.stride;
  if (std::any_of(hair.vertexCounts.begin(), hair.vertexCounts.end(),
                  [&](uint32_t count) { return count != hair.stride; }))
    def.vertexCounts = hair.vertexCounts;
  def.framesPerSecond = project.framesPerSecond;
  def.firstFrame = firstFrame;
  def.errorBound = project.cacheError;
  def.keyInterval = keyIntervalOf(project);
  return def;
}

}  // namespace

ChunkFiles::ChunkFiles(const Project& project, const Shot& shot,
                       const std::vector<BakedHair>& hairs, std::string tag, uint32_t threads)
    : project_(project),
      shot_(shot),
      hairs_(hairs),
      store_(project, shot),
      tag_(std::move(tag)),
      threads_(threads) {}

Result<void> ChunkFiles::write(const ChunkFrame& frame) {
  if (files_.empty())
    if (auto done = begin(frame); !done) return done;
  for (size_t i = 0; i < files_.size(); ++i) {
    const auto done = files_[i].writer.append(positionsOf(hairs_[i], frame.positions[i]));
    if (!done)
      return Error{done.error().code, fmt::format("shot '{}', frame {}: {}", shot_.name,
                                                  frame.frame, done.error().message)};
  }
  return framesOf(frame.chunk).last == frame.frame ? complete(frame.chunk) : Result<void>();
}

Result<void> ChunkFiles::begin(const ChunkFrame& frame) {
  for (const BakedHair& hair : hairs_) {
    Path temporary = temporaryName(store_.chunkFile(hair.name, frame.chunk), tag_);
    auto writer =
        HairCacheWriter::create(temporary, cacheDefOf(project_, hair, frame.frame), threads_);
    if (!writer) return writer.error();
    files_.push_back({std::move(temporary), *std::move(writer)});
  }
  return {};
}

// All files of the chunk get their names, and last the chunk is there.
Result<void> ChunkFiles::complete(uint64_t chunk) {
  std::vector<StoredFile> stored;
  for (size_t i = 0; i < files_.size(); ++i) {
    if (auto done = files_[i].writer.close(); !done) return done;
    const Path path = store_.chunkFile(hairs_[i].name, chunk);
    auto file = storedFile(files_[i].temporary, path.filename().string());
    if (!file) return file.error();
    if (auto done = commitFile(files_[i].temporary, path); !done) return done;
    stored.push_back(*std::move(file));
  }
  files_.clear();
  return store_.addChunk(chunk, stored, tag_);
}

ChunkWriter::ChunkWriter(const Project& project, const Shot& shot,
                         const std::vector<BakedHair>& hairs, std::string tag, uint32_t threads)
    : files_(project, shot, hairs, std::move(tag), threads) {
  uint64_t frameBytes = 1;
  for (const BakedHair& hair : hairs) frameBytes += hair.bytes();
  maxFrames_ = static_cast<size_t>(
      std::clamp<uint64_t>(kMaxBytes / frameBytes, 2, std::max(2 * project.chunkFrames, 2u)));
  thread_ = std::thread([this] { work(); });
}

ChunkWriter::~ChunkWriter() { (void)close(); }

Result<void> ChunkWriter::add(uint64_t chunk, int64_t frame,
                              std::vector<std::vector<std::byte>> positions) {
  const auto start = Clock::now();
  std::unique_lock lock(mutex_);
  taken_.wait(lock, [&] { return error_ || queue_.size() < maxFrames_; });
  report_.waitedFor += secondsSince(start);
  if (error_) return *error_;
  queue_.push_back({chunk, frame, std::move(positions)});
  added_.notify_one();
  return {};
}

Result<void> ChunkWriter::flush() {
  const auto start = Clock::now();
  std::unique_lock lock(mutex_);
  taken_.wait(lock, [&] { return error_ || (queue_.empty() && !busy_); });
  report_.waitedFor += secondsSince(start);
  if (error_) return *error_;
  return {};
}

Result<void> ChunkWriter::close() {
  {
    const std::lock_guard lock(mutex_);
    while (!queue_.empty() && files_.framesOf(queue_.back().chunk).last != queue_.back().frame)
      queue_.pop_back();
  }
  Result<void> done = flush();
  {
    const std::lock_guard lock(mutex_);
    stops_ = true;
  }
  added_.notify_one();
  if (thread_.joinable()) thread_.join();
  files_.clear();
  return done;
}

ChunkWriterReport ChunkWriter::report() const {
  const std::lock_guard lock(mutex_);
  return report_;
}

void ChunkWriter::work() {
  std::unique_lock lock(mutex_);
  for (;;) {
    added_.wait(lock, [&] { return stops_ || !queue_.empty(); });
    if (queue_.empty()) return;
    const ChunkFrame frame = std::move(queue_.front());
    queue_.pop_front();
    busy_ = true;
    lock.unlock();
    taken_.notify_all();
    const auto start = Clock::now();
    const Result<void> done = tools::guarded([&] { return files_.write(frame); });
    lock.lock();
    report_.seconds += secondsSince(start);
    busy_ = false;
    if (done) {
      const FrameRange frames = files_.framesOf(frame.chunk);
      if (frames.last == frame.frame) report_.frames += frames.count();
    } else {
      error_ = done.error();
      queue_.clear();
    }
    taken_.notify_all();
    if (error_) return;
  }
}

}  // namespace pelage::bake
