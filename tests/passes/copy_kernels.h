// Hand-made tables of a kernel that copies and of two that draw: no codegen, no GPU.
#pragma once

#include <gtest/gtest.h>

#include <array>

#include "pelage/pass_list.h"
#include "support/errors.h"

namespace pelage::test {

inline constexpr LayoutEntry kEntries[] = {
    {"g_block", "Block", ResourceKind::kUniformBuffer, Access::kRead, 7, 16, 0, 0},
    {"g_source", "float4", ResourceKind::kStorageBuffer, Access::kRead, 7, 16, 1, 0},
    {"g_target", "float4", ResourceKind::kStorageBuffer, Access::kReadWrite, 7, 16, 2, 1},
};
inline constexpr LayoutTable kTable = {"Test", "test", 0, kEntries};
inline constexpr const LayoutTable* kTables[] = {&kTable};

inline constexpr VariantBinding kCopyBindings[] = {
    {0, 0, Access::kRead}, {0, 1, Access::kRead}, {0, 2, Access::kWrite}};
inline constexpr VariantBinding kDrawBindings[] = {{0, 1, Access::kRead}};

inline constexpr Kernel kCopyKernel = {"copy", Stage::kCompute, kTables, {}, {}};
inline constexpr Kernel kVertexKernel = {"vertex", Stage::kVertex, kTables, {}, {}};
inline constexpr Kernel kPixelKernel = {"pixel", Stage::kPixel, kTables, {}, {}};
inline constexpr KernelVariant kCopy = {&kCopyKernel, "", kCopyBindings, {64, 1, 1}, 1};
inline constexpr KernelVariant kVertex = {&kVertexKernel, "", kDrawBindings, {0, 0, 0}, 2};
inline constexpr KernelVariant kPixel = {&kPixelKernel, "", kDrawBindings, {0, 0, 0}, 3};

inline constexpr auto kA = BufferId{1};
inline constexpr auto kB = BufferId{2};
inline constexpr std::array<float, 4> kBlock = {1, 2, 3, 4};

inline void addCopy(PassList& list, BufferId source, BufferId target, uint32_t threads = 100) {
  PassBuilder builder(list);
  expectOk(builder.dispatch(kCopy, threads)
               .bind("g_source", source, 64)
               .bind("g_target", target, 64)
               .constants("g_block", kBlock)
               .finish());
}

/// A list with a copy and its barriers.
inline PassList copyList(HazardTracker& tracker, BufferId source = kA, BufferId target = kB) {
  PassList list;
  addCopy(list, source, target);
  tracker.resolve(list);
  return list;
}

inline void addDraw(PassList& list, BufferId source, BufferId indices = BufferId::kInvalid) {
  PassBuilder builder(list);
  expectOk(builder.draw(kVertex, kPixel, {}, 3, 1, indices).bind("g_source", source, 64).finish());
}

}  // namespace pelage::test
