// Dispatches of more threads than an axis takes.
#pragma once

#include <algorithm>
#include <cstdint>

#include "pelage/constants.h"
#include "pelage/pass_list.h"

namespace pelage::detail {

/// Threads in x and y, in rows; kernels read their index by dispatch.hlsli.
inline PassBuilder& dispatchRows(PassBuilder& builder, const KernelVariant& variant,
                                 uint64_t threads) {
  constexpr uint64_t kRow = dispatch::kRowThreads;
  return builder.dispatch(variant, static_cast<uint32_t>(std::min(threads, kRow)),
                          static_cast<uint32_t>((threads + kRow - 1) / kRow));
}

/// Groups of a kernel whose group is a row of threads, in x and y in the same way.
inline PassBuilder& dispatchGroups(PassBuilder& builder, const KernelVariant& variant,
                                   uint64_t groups) {
  constexpr uint64_t kRow = dispatch::kRowGroups;
  return builder.dispatch(variant,
                          static_cast<uint32_t>(std::min(groups, kRow)) * variant.groupSize[0],
                          static_cast<uint32_t>((groups + kRow - 1) / kRow));
}

}  // namespace pelage::detail
