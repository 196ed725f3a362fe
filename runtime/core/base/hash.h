// XXH3 with 64 bits and seed 0, by Yann Collet (xxhash.com): the checksum of caches.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

namespace pelage::detail {

uint64_t hash64(std::span<const std::byte> bytes);

}  // namespace pelage::detail
