// Lists that are wrong in one way each, on the kernels of tests/passes: for the check without a
// GPU and for the runtimes, which have to refuse them with the same words.
#pragma once

#include <gtest/gtest.h>

#include <functional>
#include <span>
#include <string>
#include <vector>

#include "pelage/list_check.h"
#include "runtime_test/gpu_structs.h"
#include "runtime_test/kernels.h"
#include "runtime_test/layouts.h"

namespace pelage::test {

/// Buffers of the lists below; `removed` is no longer there, `unseen` comes later than the device.
struct WrongListBuffers {
  static constexpr uint32_t kCount = 256;
  static constexpr uint64_t kBytes = kCount * sizeof(uint32_t);

  explicit WrongListBuffers(ResourceTable& resources) {
    const auto add = [&](const char* name, BufferUsage usage) {
      return resources.add({.name = name, .size = kBytes, .stride = 4, .usage = usage});
    };
    source = add("groom/source", BufferUsage::kStorage | BufferUsage::kUpload);
    target = add("groom/target", BufferUsage::kStorage);
    arguments = add("groom/arguments", BufferUsage::kStorage | BufferUsage::kIndirect);
    indices = add("groom/indices", BufferUsage::kStorage | BufferUsage::kIndex);
    vertices = add("groom/vertices", BufferUsage::kVertex);
    removed = add("groom/removed", BufferUsage::kStorage);
    resources.remove(removed);
  }

  BufferId source, target, arguments, indices, vertices, removed;
};

/// A dispatch that reads `source` and writes `target`, then a draw with indices. Nothing is wrong.
inline PassList rightList(const WrongListBuffers& buffers) {
  PassList list;
  PassBuilder pass(list);
  Result<void> added =
      pass.dispatch(runtime_test::accumulateVariant(), WrongListBuffers::kCount)
          .bind("g_source", buffers.source, WrongListBuffers::kBytes)
          .bind("g_target", buffers.target, WrongListBuffers::kBytes)
          .constants("AccumulateConstants",
                     runtime_test::AccumulateConstants{WrongListBuffers::kCount, 1, 1, 0})
          .finish();
  EXPECT_TRUE(added) << added.error().message;
  added = pass.draw(runtime_test::fillVertexVariant(), runtime_test::fillPixelVariant(), {}, 6, 1,
                    buffers.indices)
              .bind("g_corners", buffers.source, WrongListBuffers::kBytes)
              .constants("FillConstants", runtime_test::FillConstants{})
              .finish();
  EXPECT_TRUE(added) << added.error().message;
  return list;
}

struct WrongList {
  const char* what;
  std::function<void(PassList&)> spoil;
  std::vector<const char*> words;  ///< of the message
  ErrorCode code = ErrorCode::kInvalidArgument;
  ListPart part = ListPart::kDispatches;  ///< that finds it
};

inline PassBinding& bindingTo(PassList& list, size_t pass, BufferId buffer) {
  for (PassBinding& binding :
       std::span(list.bindings)
           .subspan(list.passes[pass].firstBinding, list.passes[pass].bindingCount))
    if (binding.buffer == buffer) return binding;
  ADD_FAILURE() << "the pass does not bind it";
  return list.bindings[0];
}

inline std::vector<WrongList> wrongBindings(const WrongListBuffers& b) {
  const auto source = [b](PassList& list) -> PassBinding& { return bindingTo(list, 0, b.source); };
  const auto block = [](PassList& list) -> PassBinding& {
    return bindingTo(list, 0, BufferId::kInvalid);
  };
  return {
      {"a buffer that is not there",
       [=](PassList& list) { source(list).buffer = static_cast<BufferId>(77); },
       {"accumulate", "'g_source'", "#77", "update()"}},
      {"a removed buffer",
       [=](PassList& list) { source(list).buffer = b.removed; },
       {"accumulate", "'g_source'", "removed"}},
      {"a range behind the end",
       [=](PassList& list) { source(list).size += 4; },
       {"accumulate", "'g_source'", "'groom/source'", "1028 bytes at 0", "1024"}},
      {"a range that overflows",
       [=](PassList& list) { source(list).offset = ~uint64_t{255}; },
       {"accumulate", "'g_source'", "'groom/source'"}},
      {"an empty range",
       [=](PassList& list) { source(list).size = 0; },
       {"accumulate", "'g_source'", "0 bytes"}},
      {"a block that is too small",
       [=](PassList& list) { block(list).size = 12; },
       {"accumulate", "'AccumulateConstants'", "16 bytes"}},
      {"a block outside of the constants",
       [=](PassList& list) { block(list).offset = 1 << 20; },
       {"accumulate", "'AccumulateConstants'", "1048576"}},
      {"a block at an offset that no device takes",
       [=](PassList& list) { block(list).offset = 16; },
       {"accumulate", "'AccumulateConstants'", "offset 16", "256"}},
      {"a resource left out",
       [=](PassList& list) {
         list.bindings[0] = list.bindings[1];
         list.bindings[1] = list.bindings[2];
         list.passes[0].bindingCount = 2;
       },
       {"accumulate", "binds nothing", "'AccumulateConstants'"}},
      {"a resource bound twice",
       [=](PassList& list) { block(list) = source(list); },
       {"accumulate", "'g_source' twice"}},
      {"a set that its layouts do not have",
       [=](PassList& list) { source(list).set = 3; },
       {"accumulate", "set 3"}},
      {"an entry that its layouts do not have",
       [=](PassList& list) { source(list).entry = 40; },
       {"accumulate", "entry 40"}},
  };
}

inline std::vector<WrongList> wrongDispatches(const WrongListBuffers& b) {
  const auto indirect = [](PassList& list, BufferId buffer, uint64_t offset) {
    list.passes[0].kind = PassKind::kDispatchIndirect;
    list.passes[0].indirect = buffer;
    list.passes[0].indirectOffset = offset;
  };
  return {
      {"no kernel", [](PassList& list) { list.passes[0].kernel = nullptr; }, {"'accumulate'"}},
      {"a dispatch of a vertex kernel",
       [](PassList& list) { list.passes[0].kernel = &runtime_test::fillVertexVariant(); },
       {"fill_vertex", "stage"}},
      {"ranges outside of the list",
       [](PassList& list) { list.passes[0].bindingCount = 99; },
       {"accumulate", "not in the list"}},
      {"spec values outside of the list",
       [](PassList& list) { list.passes[0].specValueCount = 1; },
       {"accumulate", "not in the list"}},
      {"barriers outside of the list",
       [](PassList& list) { list.passes[0].firstBarrier = ~0u; },
       {"accumulate", "not in the list"}},
      {"a dispatch behind a draw",
       [](PassList& list) { std::swap(list.passes[0], list.passes[1]); },
       {"accumulate", "behind a draw"}},
      {"no groups", [](PassList& list) { list.passes[0].groups[1] = 0; }, {"accumulate", "axis y"}},
      {"indirect arguments that are not there",
       [=](PassList& list) { indirect(list, b.removed, 0); },
       {"accumulate", "indirect", "removed"}},
      {"indirect arguments in a buffer that was not made for them",
       [=](PassList& list) { indirect(list, b.source, 0); },
       {"accumulate", "'groom/source'", "kIndirect"}},
      {"indirect arguments at an odd offset",
       [=](PassList& list) { indirect(list, b.arguments, 2); },
       {"accumulate", "'groom/arguments'", "multiple of 4"}},
      {"indirect arguments behind the end",
       [=](PassList& list) { indirect(list, b.arguments, 1016); },
       {"accumulate", "'groom/arguments'", "12 bytes at 1016"}},
      {"a barrier of a buffer that is not there",
       [=](PassList& list) {
         list.passes[0].barrierCount = 1;
         list.barriers.push_back({.buffer = b.removed});
       },
       {"barrier between the dispatches", "removed, with an object or by trim()"}},
      {"a barrier before the draws of a buffer that is not there",
       [=](PassList& list) { list.drawBarriers.push_back({.buffer = b.removed}); },
       {"barrier before the draws", "removed"}},
      {"an upload into a buffer that is not there",
       [=](PassList& list) {
         list.uploads.push_back({b.removed, 0, 0, 4});
       },
       {"upload", "update()"}},
      {"an upload of nothing",
       [=](PassList& list) {
         list.uploads.push_back({b.source, 0, 0, 0});
       },
       {"upload", "'groom/source'"}},
      {"an upload at an odd offset",
       [=](PassList& list) {
         list.uploads.push_back({b.source, 2, 0, 4});
       },
       {"upload", "'groom/source'", "multiples of 4"}},
      {"an upload behind the end",
       [=](PassList& list) {
         list.uploadData.resize(8);
         list.uploads.push_back({b.source, 1020, 0, 8});
       },
       {"upload", "'groom/source'", "8 bytes at 1020", "1024"}},
      {"an upload of data that the list does not have",
       [=](PassList& list) {
         list.uploads.push_back({b.source, 0, 0, 4});
       },
       {"upload", "'groom/source'", "0 bytes of data"}},
  };
}

inline std::vector<WrongList> wrongDraws(const WrongListBuffers& b) {
  const auto indirect = [](PassList& list, BufferId buffer, uint64_t offset) {
    list.passes[1].kind = PassKind::kDrawIndirect;
    list.passes[1].indices = BufferId::kInvalid;
    list.passes[1].indirect = buffer;
    list.passes[1].indirectOffset = offset;
  };
  std::vector<WrongList> all = {
      {"a draw without pixel kernel",
       [](PassList& list) { list.passes[1].pixel = nullptr; },
       {"fill_vertex", "pixel stage"}},
      {"a draw of a compute kernel",
       [](PassList& list) { list.passes[1].kernel = list.passes[0].kernel; },
       {"fill_pixel", "vertex stage"}},
      {"kernels of other layouts",
       [](PassList& list) {
         static const LayoutTable* const layouts[] = {&runtime_test::kRuntimeComputeLayout};
         static const Kernel kernel = {"other_pixel", Stage::kPixel, layouts, {}, {}};
         static const KernelVariant variant = {&kernel, "", {}, {0, 0, 0}, 9};
         list.passes[1].pixel = &variant;
       },
       {"fill_vertex", "other_pixel", "group"}},
      {"a buffer that is not there",
       [=](PassList& list) { bindingTo(list, 1, b.source).buffer = b.removed; },
       {"fill_vertex", "fill_pixel", "'g_corners'", "removed"}},
      {"a range behind the end",
       [=](PassList& list) { bindingTo(list, 1, b.source).size += 16; },
       {"fill_vertex", "'g_corners'", "'groom/source'", "1040"}},
      {"indices in a buffer that is not there",
       [=](PassList& list) { list.passes[1].indices = b.removed; },
       {"fill_vertex", "indices", "removed"}},
      {"indices in a buffer that was not made for them",
       [=](PassList& list) { list.passes[1].indices = b.source; },
       {"fill_vertex", "'groom/source'", "kIndex"}},
      {"indices behind the end",
       [](PassList& list) { list.passes[1].elementCount = 257; },
       {"fill_vertex", "257 indices", "'groom/indices'"}},
      {"more instances than GL counts",
       [](PassList& list) { list.passes[1].instanceCount = 0x80000000u; },
       {"fill_vertex", "instances"}},
      {"indirect arguments in a buffer that was not made for them",
       [=](PassList& list) { indirect(list, b.source, 0); },
       {"fill_vertex", "'groom/source'", "kIndirect"}},
      {"indirect arguments behind the end",
       [=](PassList& list) { indirect(list, b.arguments, 1012); },
       {"fill_vertex", "'groom/arguments'", "16 bytes at 1012"}},
      {"an indirect draw with indices",
       [=](PassList& list) {
         indirect(list, b.arguments, 0);
         list.passes[1].indices = b.indices;
       },
       {"fill_vertex", "indices"}},
  };
  for (WrongList& wrong : all) wrong.part = ListPart::kDraws;
  return all;
}

/// Wrong draws whose vertex kernel has inputs: 6 vertices of 16 bytes.
inline std::vector<WrongList> wrongVertices(const WrongListBuffers& b) {
  // As fill_vertex, with an input.
  static const VertexAttribute attributes[] = {{0, VertexFormat::kUint2, 8}};
  static const VertexInput input = {attributes, 16, false};
  static const Kernel kernel = {
      "input_vertex", Stage::kVertex, runtime_test::fillVertexVariant().kernel->layouts, {}, {},
      &input};
  static KernelVariant variant = runtime_test::fillVertexVariant();
  variant.kernel = &kernel;
  const auto with = [=](PassList& list, const BufferRange& vertices) {
    list.passes[1].kernel = &variant;
    list.passes[1].indices = BufferId::kInvalid;
    list.passes[1].vertices = vertices;
  };
  std::vector<WrongList> all = {
      {"no vertices", [=](PassList& list) { with(list, {}); }, {"input_vertex", "vertices", "#0"}},
      {"vertices in a buffer that is not there",
       [=](PassList& list) {
         with(list, {b.removed, 96, 0});
       },
       {"input_vertex", "vertices", "removed"}},
      {"vertices in a buffer that was not made for them",
       [=](PassList& list) {
         with(list, {b.source, 96, 0});
       },
       {"input_vertex", "'groom/source'", "kVertex"}},
      {"vertices at an odd offset",
       [=](PassList& list) {
         with(list, {b.vertices, 96, 2});
       },
       {"input_vertex", "96 bytes at 2", "'groom/vertices'"}},
      {"vertices behind the end",
       [=](PassList& list) {
         with(list, {b.vertices, 96, 1024 - 92});
       },
       {"input_vertex", "96 bytes at 932", "1024"}},
      {"fewer vertices than are drawn",
       [=](PassList& list) {
         with(list, {b.vertices, 92, 0});
       },
       {"input_vertex", "96 bytes of vertices", "92"}},
  };
  for (WrongList& wrong : all) wrong.part = ListPart::kDraws;
  return all;
}

/// All of them. What depends on the limits of a device is not here.
inline std::vector<WrongList> wrongLists(const WrongListBuffers& buffers) {
  std::vector<WrongList> all = wrongBindings(buffers);
  for (auto* make : {&wrongDispatches, &wrongDraws, &wrongVertices}) {
    std::vector<WrongList> more = make(buffers);
    all.insert(all.end(), more.begin(), more.end());
  }
  return all;
}

inline PassList spoiled(const WrongList& wrong, const WrongListBuffers& buffers) {
  PassList list = rightList(buffers);
  wrong.spoil(list);
  return list;
}

}  // namespace pelage::test
