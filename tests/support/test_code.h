// The code of kernels that a test writes or spoils itself, in tables as pelage-codegen makes them.
#pragma once

#include <zstd.h>

#include <cstring>
#include <deque>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "pelage/kernel_code.h"

namespace pelage::test {

/// A table of one permutation, which lives until the program ends.
/// \param hash  KernelVariant::hash of the permutation
inline const KernelCode* makeCode(const Kernel& kernel, CodeFormat format, uint64_t hash,
                                  std::string_view bytes) {
  struct Table {
    std::string packed;
    KernelCode::Range range;
    KernelCode code;
  };
  static std::deque<Table> tables;
  Table& table = tables.emplace_back();
  table.packed.resize(ZSTD_compressBound(bytes.size()));
  table.packed.resize(
      ZSTD_compress(table.packed.data(), table.packed.size(), bytes.data(), bytes.size(), 1));
  const auto size = static_cast<uint32_t>(bytes.size());
  table.range = {hash, 0, size};
  table.code = {
      &kernel,      format, table.packed.data(), static_cast<uint32_t>(table.packed.size()), size,
      &table.range, 1};
  return &table.code;
}

inline const KernelCode* makeSpirv(const Kernel& kernel, uint64_t hash,
                                   std::span<const uint32_t> words) {
  return makeCode(kernel, CodeFormat::kSpirv, hash,
                  {reinterpret_cast<const char*>(words.data()), words.size_bytes()});
}

/// A hash that no other kernel of the process has.
inline uint64_t freshHash() {
  static uint64_t next = 1;
  return next++;
}

}  // namespace pelage::test
