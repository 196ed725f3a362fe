// The .pelagecache file: header, tables, records of frames, index, footer. Little endian;
// docs/bake_outputs.md describes it byte by byte.
#pragma once

#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "pelage/hair_cache.h"

namespace pelage::detail::hair_cache {

// The last bytes detect that a program treated the file as text.
inline constexpr std::array<char, 8> kMagic = {'P', 'E', 'L', 'H', 'A', 'I', '\r', '\n'};
inline constexpr std::array<char, 8> kEndMagic = {'\r', '\n', 'P', 'E', 'L', 'E', 'N', 'D'};
inline constexpr uint32_t kByteOrder = 0x0a0b0c0d;
inline constexpr uint32_t kMaxNameLength = 4095;
inline constexpr uint32_t kMaxKeyInterval = 256;
inline constexpr int64_t kMaxFrameNumber = int64_t{1} << 40;
/// A chunk ends with the strand that gives it this number of vertices, or more.
inline constexpr uint32_t kChunkVertices = 8192;

struct Header {
  std::array<char, 8> magic = kMagic;
  uint32_t version = kHairCacheVersion;
  uint32_t byteOrder = kByteOrder;
  uint32_t strandCount = 0;
  uint32_t verticesPerStrand = 0;  ///< 0: the table of counts has them
  uint32_t keyInterval = 0;
  uint32_t nameLength = 0;  ///< [bytes]
  double framesPerSecond = 0;
  int64_t firstFrame = 0;
  float errorBound = 0;
  uint32_t hasIds = 0;  ///< 0 or 1
  uint64_t reserved = 0;
  uint64_t tablesChecksum = 0;  ///< of ids, counts and name, as they follow the header
  uint64_t checksum = 0;        ///< of the bytes of the header before it
};
static_assert(sizeof(Header) == 80);

struct FrameHeader {
  uint32_t isKey = 0;  ///< 0 or 1
  /// Size of a quantum [m]: a coordinate is its integer times this. 0: the integer is the float's
  /// bits, in the order of the numbers (orderedBits()).
  float step = 0;
  uint32_t chunkCount = 0;
  uint32_t reserved = 0;
};
static_assert(sizeof(FrameHeader) == 16);

/// A chunk of a frame. The table of chunks follows the header of the frame, their contents follow
/// the table.
struct ChunkHeader {
  uint32_t byteCount = 0;
  uint8_t planeCount = 0;  ///< bytes of a residual, 0..4; 0: all are 0, and byteCount is 0
  uint8_t timeOrder = 0;   ///< 0..2 frames before that predict; 0 in a key frame, 1 behind it
  uint8_t spaceOrder = 0;  ///< 0..3, SpaceOrder
  uint8_t reserved = 0;
};
static_assert(sizeof(ChunkHeader) == 8);

struct IndexEntry {
  uint64_t offset = 0;
  uint64_t checksum = 0;  ///< of the record
  uint32_t byteCount = 0;
  uint32_t fromKey = 0;  ///< number of frames since the key frame, 0 for that
};
static_assert(sizeof(IndexEntry) == 24);

struct Footer {
  uint64_t indexOffset = 0;
  uint64_t frameCount = 0;
  uint64_t checksum = 0;  ///< of the index and the two fields before
  std::array<char, 8> magic = kEndMagic;
};
static_assert(sizeof(Footer) == 32);

/// Strands and vertices that are coded together.
struct Chunk {
  uint32_t firstStrand = 0, strandCount = 0;
  uint32_t firstVertex = 0, vertexCount = 0;
};
/// Returns the chunks of a frame. \param def one that validate() accepts
std::vector<Chunk> chunksOf(const HairCacheDef& def);

inline uint32_t verticesOf(const HairCacheDef& def, uint32_t strand) {
  return def.vertexCounts.empty() ? def.verticesPerStrand : def.vertexCounts[strand];
}

/// Header and tables of a file.
std::vector<std::byte> packHeader(const HairCacheDef& def);
/// Index and footer. \param offset of the index in the file
std::vector<std::byte> packIndex(std::span<const IndexEntry> index, uint64_t offset);

/// A float as an integer, in the order of the numbers, and back.
inline uint32_t orderedBits(float value) {
  const auto bits = std::bit_cast<uint32_t>(value);
  return bits ^ (static_cast<uint32_t>(static_cast<int32_t>(bits) >> 31) >> 1);
}
inline float fromOrderedBits(uint32_t ordered) {
  return std::bit_cast<float>(ordered ^
                              (static_cast<uint32_t>(static_cast<int32_t>(ordered) >> 31) >> 1));
}

}  // namespace pelage::detail::hair_cache
