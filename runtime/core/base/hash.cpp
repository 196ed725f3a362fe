#include "base/hash.h"

// All of it in this file: who links the library needs no other one.
#define XXH_INLINE_ALL
#include <xxhash.h>

namespace pelage::detail {

uint64_t hash64(std::span<const std::byte> bytes) {
  return XXH3_64bits(bytes.data(), bytes.size());
}

}  // namespace pelage::detail
