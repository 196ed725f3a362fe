// Encodes the frames of a shot and writes its chunks on a thread of its own, while the next frames
// are simulated.
#pragma once

#include <condition_variable>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "pelage/hair_cache.h"
#include "pelage/result.h"
#include "project.h"
#include "shot_scene.h"
#include "shot_store.h"

namespace pelage::bake {

struct ChunkFrame {
  uint64_t chunk = 0;
  int64_t frame = 0;
  std::vector<std::vector<std::byte>> positions;  ///< [hair] ShotScene::readBytes()
};

/// Encodes frames into the files of their chunk.
class ChunkFiles {
 public:
  ChunkFiles(const Project& project, const Shot& shot, const std::vector<BakedHair>& hairs,
             std::string tag, uint32_t threads);

  FrameRange framesOf(uint64_t chunk) const { return chunkOf(project_, shot_, chunk); }
  /// Writes the first frame of a chunk, or the next one. The last one completes the files on the
  /// disk. Errors: those of the disk; a position that is not finite.
  Result<void> write(const ChunkFrame& frame);
  /// Forgets a chunk that is not complete.
  void clear() { files_.clear(); }

 private:
  struct OpenFile {
    std::filesystem::path temporary;
    HairCacheWriter writer;
  };

  Result<void> begin(const ChunkFrame& frame);
  Result<void> complete(uint64_t chunk);

  const Project& project_;
  const Shot& shot_;
  const std::vector<BakedHair>& hairs_;
  ShotStore store_;
  std::string tag_;
  uint32_t threads_ = 1;
  std::vector<OpenFile> files_;  ///< [hair] of the current chunk
};

/// Progress of a writer.
struct ChunkWriterReport {
  uint64_t frames = 0;   ///< of chunks that are complete on the disk
  double seconds = 0;    ///< of encoding and writing
  double waitedFor = 0;  ///< that add() and flush() have waited [s]
};

/// Threads: one at a time, beside its own.
class ChunkWriter {
 public:
  /// Frames that wait are those of two chunks at most, and 1 GiB, or two frames where these are
  /// larger.
  static constexpr uint64_t kMaxBytes = uint64_t{1} << 30;

  /// \param hairs  what is written; it must outlive the writer, as `project` and `shot` must.
  /// \param tag  of its temporary files. \param threads  that encode a frame together, >= 1
  ChunkWriter(const Project& project, const Shot& shot, const std::vector<BakedHair>& hairs,
              std::string tag, uint32_t threads);
  ~ChunkWriter();  ///< close()
  ChunkWriter(const ChunkWriter&) = delete;
  ChunkWriter& operator=(const ChunkWriter&) = delete;

  /// Adds the next frame of a chunk, or the first one of another; waits while the queue is full.
  /// \param positions  [hair] ShotScene::readBytes(). Errors: of this frame or of any before: those
  /// of the disk; a position that is not finite. Nothing is written behind an error.
  Result<void> add(uint64_t chunk, int64_t frame, std::vector<std::vector<std::byte>> positions);
  /// Waits until all frames that were added are written. Chunks whose last frame was added are then
  /// complete, on the disk. Errors: as add().
  Result<void> flush();
  /// Forgets a chunk that lacks frames, does what flush() does, and ends the thread.
  Result<void> close();
  ChunkWriterReport report() const;

 private:
  void work();

  size_t maxFrames_ = 2;  ///< in the queue
  ChunkFiles files_;      ///< of the thread alone, but framesOf()

  mutable std::mutex mutex_;
  std::condition_variable added_, taken_;
  std::deque<ChunkFrame> queue_;
  bool busy_ = false, stops_ = false;
  std::optional<Error> error_;
  ChunkWriterReport report_;
  std::thread thread_;  ///< last: it begins with all of the above
};

}  // namespace pelage::bake
