// Codes a chunk of a frame: integers -> residuals of a prediction -> planes of bytes -> zstd.
// Integers are modulo 2^32.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "assets/hair_cache_format.h"

namespace pelage::detail::hair_cache {

/// The neighbors of a strand that predict a vertex (docs/bake_outputs.md). A root is predicted by
/// the root before it; the first one by 0.
enum SpaceOrder : uint8_t {
  kNoSpace = 0,     ///< nothing
  kConstant = 1,    ///< the vertex before
  kLinear = 2,      ///< the two vertices before
  kNeighbor = 3,    ///< the vertex before, and the same segment of the strand before
  kSpaceOrderCount  ///< number of values
};

/// Frames before this one, of the same chunk, each [3 * vertex]; those that timeOrder needs.
struct History {
  const uint32_t* last = nullptr;
  const uint32_t* beforeLast = nullptr;
};

class Encoder {
 public:
  Encoder();
  ~Encoder();
  Encoder(const Encoder&) = delete;
  Encoder& operator=(const Encoder&) = delete;

  /// Appends the contents of a chunk to `out`.
  /// \param values [3 * vertex] of the chunk
  /// \param maxTimeOrder 0..2, as `history` has frames
  ChunkHeader encode(const HairCacheDef& def, const Chunk& chunk, const uint32_t* values,
                     History history, uint8_t maxTimeOrder, std::vector<std::byte>& out);

 private:
  struct Prediction {
    uint8_t timeOrder = 0, spaceOrder = 0;
  };
  /// The prediction that costs a part of the chunk least.
  Prediction choose(const HairCacheDef& def, const Chunk& chunk, const uint32_t* values,
                    History history, uint8_t maxTimeOrder);
  /// Fills residuals_.
  void predict(const HairCacheDef& def, const Chunk& chunk, const uint32_t* values, History history,
               Prediction prediction);
  struct Context;
  std::unique_ptr<Context> context_;
  std::vector<uint32_t> temporal_, residuals_;
  std::vector<uint8_t> plane_;
};

class Decoder {
 public:
  Decoder();
  ~Decoder();
  Decoder(const Decoder&) = delete;
  Decoder& operator=(const Decoder&) = delete;

  /// Decodes the contents of a chunk. The header's orders are in range.
  /// \param last [3 * vertex] the frame before; read if timeOrder is 1 or 2
  /// \param values [3 * vertex] holds the frame before that one if timeOrder is 2; the result
  /// \return whether the contents are those of this chunk
  bool decode(const HairCacheDef& def, const Chunk& chunk, const ChunkHeader& header,
              std::span<const std::byte> bytes, const uint32_t* last, uint32_t* values);

 private:
  struct Context;
  std::unique_ptr<Context> context_;
  std::vector<uint8_t> planes_;
  std::vector<uint32_t> residuals_;
};

}  // namespace pelage::detail::hair_cache
