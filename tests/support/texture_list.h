// A list whose pass reads a texture of an engine, for the runtimes' errors about textures: its
// kernel has no code.
#pragma once

#include "pelage/list_check.h"
#include "pelage/pass_list.h"

namespace pelage::test {

/// A dispatch with a texture and, under another name, its sampler; with its barriers.
inline PassList listWithTexture(TextureId texture) {
  static const LayoutEntry entries[] = {
      {"g_picture", "", ResourceKind::kSampledTexture, Access::kRead, 1, 0, 0, 0},
      {"g_pictureSampler", "", ResourceKind::kSampler, Access::kRead, 1, 0, 1, 0}};
  static const LayoutTable table = {"Picture", "picture", 0, entries};
  static const LayoutTable* const layouts[] = {&table};
  static const Kernel kernel = {"look", Stage::kCompute, layouts, {}, {}};
  static const KernelVariant variant = {&kernel, "", {}, {64, 1, 1}, 1};
  PassList list;
  for (const uint32_t entry : {0u, 1u}) {
    PassBinding& binding = list.bindings.emplace_back();
    binding.entry = static_cast<decltype(binding.entry)>(entry);
    binding.texture = texture;
  }
  Pass pass;
  pass.kernel = &variant;
  pass.bindingCount = 2;
  pass.groups[0] = pass.groups[1] = pass.groups[2] = 1;
  list.passes.push_back(pass);
  HazardTracker().resolve(list);
  return list;
}

}  // namespace pelage::test
