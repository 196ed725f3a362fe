// An engine that takes kernels, layouts and pass lists, and nothing else of pelage: it writes a
// list with one kernel, and has it checked. Exits with 0 when the list is right and a wrong one is
// refused.
#include <pelage/bindings.h>
#include <pelage/kernel_code.h>
#include <pelage/kernels.h>
#include <pelage/list_check.h>
#include <pelage/pass_list.h>
#include <pelage/spirv.h>

#include <cstdio>

int main() {
  constexpr uint32_t kCount = 100;
  pelage::ResourceTable resources;
  const pelage::BufferId positions =
      resources.add({.name = "positions", .size = kCount * sizeof(pelage::Float4), .stride = 16});

  pelage::ShiftPositionsConstants constants = {};
  constants.shift = {1, 2, 3, 0};
  constants.shiftedCount = kCount;
  pelage::PassList list;
  const pelage::Result<void> added =
      pelage::PassBuilder(list)
          .dispatch(pelage::shiftPositionsVariant({}), kCount)
          .finish(pelage::ShiftPositionsBindings{.shiftPositionsConstants = constants,
                                                 .shiftedPositions = resources.whole(positions)});
  if (!added) return std::fprintf(stderr, "%s\n", added.error().message.c_str()), 1;
  pelage::HazardTracker hazards;
  hazards.resolve(list);
  const pelage::Result<void> checked = pelage::checkList(list, resources);
  if (!checked) return std::fprintf(stderr, "%s\n", checked.error().message.c_str()), 1;
  resources.remove(positions);
  if (pelage::checkList(list, resources)) return std::fprintf(stderr, "not refused\n"), 1;

  // Its code, and no other kernel's.
  const pelage::KernelCode* const carried[] = {&pelage::kShiftPositionsSpirv};
  const auto spirv = pelage::KernelCodes(carried).spirv(pelage::shiftPositionsVariant({}));
  if (!spirv) return std::fprintf(stderr, "%s\n", spirv.error().message.c_str()), 1;
  for (const pelage::CarriedKernel& kernel : pelage::carriedKernels(carried))
    std::printf("carries %s of %s: %llu bytes\n", pelage::codeFormatName(kernel.format),
                kernel.kernel, static_cast<unsigned long long>(kernel.packedBytes));
  std::puts("a list of one dispatch, and the check of one whose buffer is gone");
}
