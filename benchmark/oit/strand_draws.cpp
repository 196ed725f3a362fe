#include "oit/strand_draws.h"

#include <string_view>

#include "baseline/kernels.h"
#include "pelage/kernels.h"

namespace bench {

using pelage::BufferId;
using pelage::KernelVariant;
using pelage::Pass;
using pelage::PassBinding;
using pelage::PassBuilder;
using pelage::PassList;
using pelage::Result;

namespace {

// The benchmark's own build of a vertex kernel; nullptr for other kernels than those of its scenes.
const KernelVariant* ownVertex(const Pass& pass) {
  if (!pelage::isDraw(pass.kind)) return nullptr;
  for (const bool attributes : {false, true})
    if (pass.kernel == &pelage::strandVertexVariant({.smooth = true, .attributes = attributes}))
      return &baseline::strandVertexVariant({.attributes = attributes});
  return nullptr;
}

const PassBinding* bindingOfStrands(const PassList& list, std::string_view name) {
  for (const Pass& pass : list.passes) {
    if (ownVertex(pass) == nullptr) continue;
    for (const PassBinding& binding : list.bindingsOf(pass))
      if (pass.layouts()[binding.set]->entries[binding.entry].name == name) return &binding;
  }
  return nullptr;
}

}  // namespace

Result<std::vector<PassList>> strandLists(HairScene& scene, const pelage::View& view) {
  pelage::TransparencySettings settings;
  settings.method = pelage::Transparency::kWindowed;
  settings.nodeCount = 1;
  settings.maxBytes = uint64_t{16} << 30;
  std::vector<PassList> lists;
  if (Result<void> done = scene.draw(view, settings, lists); !done) return done.error();
  return lists;
}

Result<void> addStrandDraws(const PassList& from, const KernelVariant& pixel,
                            const std::function<void(PassBuilder&)>& offer, PassList& to) {
  for (const Pass& pass : from.passes) {
    const KernelVariant* vertex = ownVertex(pass);
    if (vertex == nullptr) continue;
    PassBuilder builder(to);
    builder.draw(*vertex, pixel, pass.state, pass.elementCount, pass.instanceCount, pass.indices);
    for (const PassBinding& binding : from.bindingsOf(pass)) {
      const auto& entry = pass.layouts()[binding.set]->entries[binding.entry];
      if (binding.buffer != BufferId::kInvalid)
        builder.bind(entry.name, binding.buffer, binding.size, binding.offset);
      else
        builder.constants(entry.name,
                          std::span(from.constants).subspan(binding.offset, binding.size));
    }
    offer(builder);
    if (Result<void> done = builder.finish(); !done) return done;
  }
  return {};
}

void copyOtherPasses(const PassList& from, PassList& to) {
  to = from;
  std::erase_if(to.passes, [](const Pass& pass) {
    return ownVertex(pass) != nullptr || std::string_view(pass.name) == "clear_ppll";
  });
}

std::vector<std::byte> blockOfStrands(const PassList& list, std::string_view name) {
  const PassBinding* binding = bindingOfStrands(list, name);
  if (binding == nullptr) return {};
  const auto bytes = std::span(list.constants).subspan(binding->offset, binding->size);
  return {bytes.begin(), bytes.end()};
}

}  // namespace bench
