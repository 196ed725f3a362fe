#include "simulation/copy_load.h"

#include "baseline/gpu_structs.h"
#include "baseline/kernels.h"

namespace bench {

using pelage::PassBuilder;
using pelage::PassList;
using pelage::PassTiming;
using pelage::Result;

CopyLoad::CopyLoad(pelage::HeadlessDevice& device, pelage::Scene& scene, uint32_t elements,
                   uint64_t sets)
    : device_(device), scene_(scene), elements_(elements), sets_(sets) {
  const auto add = [&](const char* name) {
    return scene.resources().add(
        {.name = name, .size = bytes() / 2, .stride = sizeof(pelage::Float4)});
  };
  from_ = add("copyFrom");
  to_ = add("copyTo");
}

CopyLoad::~CopyLoad() {
  scene_.resources().remove(from_);
  scene_.resources().remove(to_);
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
  scene_.finish(list);
  if (Result<void> done = device_.update(scene_.resources()); !done) return done.error();
  std::vector<PassTiming> timings;
  if (Result<void> done = device_.execute(list, &timings); !done) return done.error();
  return timings;
}

}  // namespace bench
