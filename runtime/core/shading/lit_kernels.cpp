#include "shading/lit_kernels.h"

#include <algorithm>
#include <cstring>
#include <string>

#include "pelage/kernels.h"
#include "pelage/list_check.h"

namespace pelage::detail {

namespace {

const KernelVariant* find(const EngineLights& lights, const KernelVariant& own) {
  for (const Kernel* kernel : lights.kernels) {
    if (kernel->stage != own.kernel->stage || std::strcmp(kernel->name, own.kernel->name) != 0)
      continue;
    const auto variants = kernel->variants;
    const auto found = std::find_if(
        variants.begin(), variants.end(),
        [&](const KernelVariant* variant) { return std::strcmp(variant->key, own.key) == 0; });
    if (found != variants.end()) return *found;
  }
  return nullptr;
}

}  // namespace

Result<void> checkLights(const EngineLights* lights) {
  if (lights == nullptr) return {};
  for (const Kernel* kernel :
       {&kStrandVertexKernel, &kStrandRecordVertexKernel, &kOitTileVertexKernel,
        &kStrandPixelKernel, &kPpllReadKernel, &kHybridColorsKernel, &kShortCutFillColorsKernel,
        &kShadeStrandTilesKernel}) {
    for (const KernelVariant* variant : kernel->variants) {
      if (find(*lights, *variant) != nullptr) continue;
      return Error{ErrorCode::kInvalidArgument,
                   "view: EngineLights::kernels lack " + variantName(*variant) +
                       ": take all that pelage_add_engine_lights() of this version makes"};
    }
  }
  return {};
}

const KernelVariant& litVariant(const EngineLights* lights, const KernelVariant& own) {
  const KernelVariant* variant = lights != nullptr ? find(*lights, own) : nullptr;
  return variant != nullptr ? *variant : own;
}

bool readsRootUv(const EngineLights* lights) {
  return lights != nullptr && find(*lights, ppllBuildVariant({.tail = false})) != nullptr;
}

const EngineLights* lightsOf(const EngineLights* lights, const KernelVariant& variant) {
  if (lights == nullptr) return nullptr;
  const auto& kernels = lights->kernels;
  const bool own = std::find(kernels.begin(), kernels.end(), variant.kernel) != kernels.end();
  return own ? lights : nullptr;
}

}  // namespace pelage::detail
