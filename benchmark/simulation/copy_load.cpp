#include "simulation/copy_load.h"

#include "baseline/gpu_structs.h"
#include "baseline/kernels.h"

namespace bench {

using pelage::PassBuilder;
using pelage::PassList;
using pelage::PassTiming;
using pelage::Result;

CopyLoad::CopyLoad(Workbench& workbench, uint32_t elements, uint64_t sets)
    : workbench_(workbench), elements_(elements), sets_(sets) {
  const std::vector<pelage::Float4> values(elements * sets);
  from_ = workbench.add("copyFrom", values);
  to_ = workbench.add("copyTo", values);
}

CopyLoad::~CopyLoad() {
  workbench_.scene.resources().remove(from_);
  workbench_.scene.resources().remove(to_);
}

uint64_t CopyLoad::bytes() const { return 2 * elements_ * sets_ * sizeof(pelage::Float4); }

Result<std::vector<PassTiming>> CopyLoad::run(int count) {
  baseline::CopyConstants constants = {};
  constants.elementCount = elements_;
  constants.sets = static_cast<uint32_t>(sets_);
  PassList list;
  PassBuilder builder(list);
  for (int i = 0; i < count; ++i) {
    builder.dispatch(baseline::copyStateVariant({}), elements_);
    builder.bind("g_copyFrom", from_, bytes() / 2).bind("g_copyTo", to_, bytes() / 2);
    const Result<void> done = builder.constants("CopyConstants", constants).finish();
    if (!done) return done.error();
  }
  workbench_.scene.finish(list);
  return workbench_.run(list);
}

}  // namespace bench
