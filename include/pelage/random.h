// A small seeded random generator that gives the same numbers on every machine and compiler; the
// standard library's distributions do not.
#pragma once

#include <cstdint>

namespace pelage {

/// PCG32: O'Neill, "PCG: A Family of Simple Fast Space-Efficient Statistically Good Algorithms for
/// Random Number Generation" (2014), variant XSH-RR 64/32. A value type; copies continue with the
/// same numbers.
///
/// Threads: one thread at a time.
class Random {
 public:
  /// Any seed is valid. Generators with the same seed and different streams are independent: use
  /// one stream per strand, and adding a strand does not change the others.
  explicit constexpr Random(uint64_t seed, uint64_t stream = 0) : increment_(stream << 1 | 1) {
    bits();
    state_ += seed;
    bits();
  }

  /// 32 random bits.
  constexpr uint32_t bits() {
    const uint64_t old = state_;
    state_ = old * 6364136223846793005u + increment_;
    const uint32_t mixed = static_cast<uint32_t>((old >> 18 ^ old) >> 27);
    const uint32_t turn = static_cast<uint32_t>(old >> 59);
    return mixed >> turn | mixed << (32 - turn) % 32;
  }

  /// Uniform in [0, 1), a multiple of 2^-24: exact in float.
  constexpr float uniform() { return static_cast<float>(bits() >> 8) * 0x1p-24f; }

  /// Uniform in [0, 1), a multiple of 2^-53.
  constexpr double uniformDouble() {
    const uint64_t high = bits() >> 5, low = bits() >> 6;
    return static_cast<double>(high << 26 | low) * 0x1p-53;
  }

  /// Uniform integer in [0, count), without bias; 0 when count is 0.
  constexpr uint32_t below(uint32_t count) {
    if (count == 0) return 0;
    // Reject the incomplete last block of residues.
    const uint32_t first = (0u - count) % count;
    uint32_t value = bits();
    while (value < first) value = bits();
    return value % count;
  }

 private:
  uint64_t state_ = 0;
  uint64_t increment_;
};

}  // namespace pelage
