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

}  // namespace pelage::detail
