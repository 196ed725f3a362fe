// Simulated hair in one compressed file, .pelagecache: the positions of every vertex in every frame
// of a shot, each within a stated distance of the simulated one. docs/bake_outputs.md describes the
// file byte by byte and has figures.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "pelage/export.h"
#include "pelage/result.h"
#include "pelage/stream.h"
#include "pelage/types.h"

namespace pelage {

/// Version of the files that this library writes, and the only one that it reads.
inline constexpr uint32_t kHairCacheVersion = 1;
/// Maximum number of vertices of all strands.
inline constexpr uint32_t kMaxHairCacheVertices = 1u << 28;

/// The properties that all frames of a cache share.
struct HairCacheDef {
  std::string name = {};     ///< of the hair; at most 4095 bytes
  uint32_t strandCount = 0;  ///< at least 1
  /// Vertices of every strand, 1..256; not read if vertexCounts is set.
  uint32_t verticesPerStrand = 0;
  std::vector<uint32_t> vertexCounts = {};  ///< [strand] 1..256; empty: verticesPerStrand for all
  std::vector<uint64_t> strandIds = {};     ///< [strand] for other tools; empty: none
  double framesPerSecond = 24;              ///< 1e-3..1e6
  int64_t firstFrame = 0;                   ///< number of the first frame, within +-2^40
  /// Maximum distance of a vertex from its position that was given [m], 1e-9..1; 0: the same bits.
  float errorBound = 1e-4f;
  /// A frame whose number is a multiple of it is a key frame, which is decoded without those before
  /// it, 1..256. Reading frames at random decodes at most this many; reading in order, one each.
  uint32_t keyInterval = 16;
  bool operator==(const HairCacheDef&) const = default;
};

/// Makes the checks of HairCacheWriter::create().
PELAGE_API Result<void> validate(const HairCacheDef& def);
/// Returns the number of vertices of all strands. \param def one that validate() accepts
PELAGE_API uint32_t vertexCountOf(const HairCacheDef& def);

/// Writes a cache frame by frame. The same def and positions give the same bytes (with the same
/// version of zstd). It holds three frames in memory.
///
/// The file appears under its name in close(). Until then it is `<path>.partial`, which is removed
/// with a writer that was not closed, and written anew by the next one.
///
/// Threads: one at a time, which has `threads` - 1 others encode with it in append().
class PELAGE_API HairCacheWriter {
 public:
  /// Errors: a field of `def` out of range, a file that cannot be created. \param threads that
  /// encode a frame together, each some 8192 vertices at a time; they change no byte.
  static Result<HairCacheWriter> create(const std::filesystem::path& path, HairCacheDef def,
                                        uint32_t threads = 1);
  HairCacheWriter(HairCacheWriter&&) noexcept;
  HairCacheWriter& operator=(HairCacheWriter&&) noexcept;
  ~HairCacheWriter();

  /// Adds the next frame. \param positions [m] of all vertices, strand by strand from the root.
  /// Errors: another number of positions than the def says, a value that is not finite, a full
  /// disk. After an error of the disk the writer is of no use any more.
  Result<void> append(std::span<const Float3> positions);
  /// Writes the index and gives the file its name; append() and close() are errors from then on.
  /// A cache without frames is valid. Errors: a full disk, a file that cannot be renamed.
  Result<void> close();

  uint64_t frameCount() const;  ///< that were appended
  uint64_t byteCount() const;   ///< written so far, without the index

 private:
  struct Impl;
  explicit HairCacheWriter(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

/// Reads the frames of a cache in any order; in ascending order is fastest. It checks everything:
/// no file leads to a read or write out of bounds or to a value that is not finite. It holds two
/// frames in memory, once it has read one.
///
/// Threads: one at a time. Open the file once more for another thread.
class PELAGE_API HairCacheReader {
 public:
  /// Reads the header and the index. Errors name the byte: another kind of file or version,
  /// a file that was not closed, truncation, a wrong checksum, a field out of range.
  static Result<HairCacheReader> open(const std::filesystem::path& path);
  /// The same from any source; `name` names it in errors.
  static Result<HairCacheReader> open(std::unique_ptr<ByteSource> source, std::string_view name);
  HairCacheReader(HairCacheReader&&) noexcept;
  HairCacheReader& operator=(HairCacheReader&&) noexcept;
  ~HairCacheReader();

  const HairCacheDef& def() const;
  uint64_t frameCount() const;
  uint32_t vertexCount() const;

  /// Decodes a frame. \param frame 0..frameCount() - 1: def().firstFrame is not added.
  /// \param out [vertexCount()] positions [m]. Errors: a frame or a size out of range; a wrong
  /// checksum or contents that cannot be decoded, with the byte.
  Result<void> read(uint64_t frame, std::span<Float3> out);

 private:
  struct Impl;
  explicit HairCacheReader(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

/// Joins the parts of a shot without decoding them. Where each part begins at a multiple of
/// keyInterval, the file has the bytes that one writer would have written. Memory is that of the
/// largest frame, compressed. Errors: those of opening a part, parts that differ in anything but
/// firstFrame, a part that does not begin where the one before it ends, a frame with a wrong
/// checksum, a full disk; no file is there then, or the one that was.
/// \param parts at least 1, in the order of their frames; empty ones are allowed
PELAGE_API Result<void> joinHairCaches(std::span<const std::filesystem::path> parts,
                                       const std::filesystem::path& path);

}  // namespace pelage
