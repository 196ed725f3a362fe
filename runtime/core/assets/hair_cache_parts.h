// The parts of a .pelagecache file, for reading and joining.
#pragma once

#include <vector>

#include "assets/hair_cache_format.h"
#include "base/stream_reader.h"

namespace pelage::detail::hair_cache {

struct Contents {
  HairCacheDef def;
  std::vector<Chunk> chunks;  ///< of each frame
  std::vector<IndexEntry> index;
};

/// Reads and checks header, tables and index.
Result<Contents> readContents(StreamReader& stream);
/// Reads a frame as it is in the file, and checks its checksum.
Result<void> readRecord(StreamReader& stream, const IndexEntry& entry,
                        std::vector<std::byte>& record);

}  // namespace pelage::detail::hair_cache
