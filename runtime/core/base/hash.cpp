#include "base/hash.h"

// The whole implementation is in this file: users of the library need no other one.
#define XXH_INLINE_ALL
#include <xxhash.h>

namespace pelage::detail {

uint64_t hash64(std::span<const std::byte> bytes) {
  return XXH3_64bits(bytes.data(), bytes.size());
}

}  // namespace pelage::detail
