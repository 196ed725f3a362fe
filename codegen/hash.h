// SHA-256 (FIPS 180-4), for cache keys and variant hashes.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>

namespace pelage::codegen {

class Sha256 {
 public:
  using Digest = std::array<uint8_t, 32>;

  Sha256& bytes(const void* data, size_t size);
  /// A field with its length, so that ("ab", "c") and ("a", "bc") differ.
  Sha256& field(std::string_view text);
  Sha256& field(uint64_t value);
  Sha256& words(std::span<const uint32_t> words);
  Digest finish();

 private:
  void block(const uint8_t* data);

  std::array<uint32_t, 8> state_ = {0x6a09e667u, 0xbb67ae85u, 0x3c6ef372u, 0xa54ff53au,
                                    0x510e527fu, 0x9b05688cu, 0x1f83d9abu, 0x5be0cd19u};
  std::array<uint8_t, 64> buffer_{};
  size_t buffered_ = 0;
  uint64_t total_ = 0;
};

std::string hex(const Sha256::Digest& digest);
/// The first eight bytes, most significant first.
uint64_t shortHash(const Sha256::Digest& digest);
std::string sha256Hex(std::string_view text);

}  // namespace pelage::codegen
