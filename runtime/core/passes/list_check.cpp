#include "pelage/list_check.h"

#include <fmt/format.h>

#include <algorithm>
#include <span>
#include <utility>

#include "passes/list_run.h"

namespace pelage {
namespace {

constexpr uint64_t kDispatchArguments = 12, kDrawArguments = 16;  // bytes
// GL counts elements and instances in signed numbers.
constexpr uint32_t kMaxCount = 0x7fffffff;

// Names are made when something is wrong: the checks run for every pass of every frame.
std::string nameOf(const Pass& pass) {
  if (pass.kernel == nullptr) return fmt::format("pass '{}'", pass.name);
  const std::string kernel = variantName(*pass.kernel);
  if (pass.pixel == nullptr) return fmt::format("pass {}", kernel);
  return fmt::format("pass {} + {}", kernel, variantName(*pass.pixel));
}

std::string numberOf(BufferId id) { return fmt::format("#{}", static_cast<uint32_t>(id)); }

template <class... Parts>
Error invalid(fmt::format_string<Parts...> text, Parts&&... parts) {
  return {ErrorCode::kInvalidArgument, fmt::format(text, std::forward<Parts>(parts)...)};
}
template <class... Parts>
Error unsupported(fmt::format_string<Parts...> text, Parts&&... parts) {
  return {ErrorCode::kUnsupported, fmt::format(text, std::forward<Parts>(parts)...)};
}

bool fits(uint64_t offset, uint64_t size, uint64_t total) {
  return offset <= total && size <= total - offset;
}

bool isTexture(ResourceKind kind) {
  return kind == ResourceKind::kSampledTexture || kind == ResourceKind::kSampler;
}

bool isOf(const PassBinding& binding, const VariantBinding& use) {
  return binding.set == use.set && binding.entry == use.entry;
}

Result<void> checkKernels(const Pass& pass) {
  if (pass.kernel == nullptr) return invalid("{} has no kernel", nameOf(pass));
  const Stage stage = pass.kernel->kernel->stage;
  if (!isDraw(pass.kind)) {
    if (stage == Stage::kCompute && pass.pixel == nullptr) return {};
    return invalid("{}: a dispatch takes one kernel, of the compute stage", nameOf(pass));
  }
  if (stage != Stage::kVertex || pass.pixel == nullptr ||
      pass.pixel->kernel->stage != Stage::kPixel) {
    return invalid("{}: a draw takes a kernel of the vertex stage and one of the pixel stage",
                   nameOf(pass));
  }
  if (layoutsFit(*pass.kernel->kernel, *pass.pixel->kernel)) return {};
  return invalid(
      "{}: its vertex and pixel kernel belong to different groups of layouts, and neither has the "
      "first ones of the other",
      nameOf(pass));
}

Result<void> checkBindings(const PassList& list, const Pass& pass) {
  const auto layouts = pass.layouts();
  const auto bindings = list.bindingsOf(pass);
  for (size_t i = 0; i < bindings.size(); ++i) {
    const PassBinding& binding = bindings[i];
    if (binding.set >= layouts.size() || layouts[binding.set] == nullptr ||
        binding.entry >= layouts[binding.set]->entries.size()) {
      return invalid("{} binds set {}, entry {}, which its layouts do not have", nameOf(pass),
                     binding.set, binding.entry);
    }
    const LayoutEntry& entry = layouts[binding.set]->entries[binding.entry];
    const auto before = bindings.first(i);
    if (std::any_of(before.begin(), before.end(), [&](const PassBinding& other) {
          return other.set == binding.set && other.entry == binding.entry;
        })) {
      return invalid("{} binds resource '{}' twice", nameOf(pass), entry.name);
    }
    if (entry.kind == ResourceKind::kStorageTexture) {
      return unsupported("{}, resource '{}': it is an image; pass lists carry buffers and textures",
                         nameOf(pass), entry.name);
    }
    if (isTexture(entry.kind) != (binding.texture != TextureId::kInvalid)) {
      return invalid("{}, resource '{}': {}", nameOf(pass), entry.name,
                     isTexture(entry.kind) ? "it is a texture or sampler, but no texture is bound"
                                           : "a texture is bound, but it is none");
    }
  }
  for (const KernelVariant* variant : {pass.kernel, pass.pixel}) {
    if (variant == nullptr) continue;
    for (const VariantBinding& use : variant->bindings) {
      if (std::any_of(bindings.begin(), bindings.end(),
                      [&](const PassBinding& binding) { return isOf(binding, use); }))
        continue;
      return invalid("{} binds nothing to resource '{}', which kernel {} uses", nameOf(pass),
                     layouts[use.set]->entries[use.entry].name, variantName(*variant));
    }
  }
  return {};
}

// The part that needs buffers and a device.
class Checker {
 public:
  Checker(const PassList& list, const BufferLookup& find, const DeviceLimits& limits)
      : list_(list), find_(find), limits_(limits) {}

  Result<void> uploads() const;
  Result<void> barriers(std::span<const Barrier> barriers, const char* where) const;
  Result<void> pass(const Pass& pass) const;

 private:
  Result<void> constants(const Pass& pass, const PassBinding& binding,
                         const LayoutEntry& entry) const;
  Result<void> storage(const Pass& pass, const PassBinding& binding,
                       const LayoutEntry& entry) const;
  Result<void> groups(const Pass& pass) const;
  Result<void> indirect(const Pass& pass) const;
  Result<void> indices(const Pass& pass) const;
  Result<void> vertices(const Pass& pass) const;

  const PassList& list_;
  const BufferLookup& find_;
  const DeviceLimits& limits_;
};

Result<void> Checker::uploads() const {
  for (const Upload& upload : list_.uploads) {
    const std::optional<KnownBuffer> buffer = find_(upload.buffer);
    if (!buffer) {
      return invalid("upload into buffer {}, which was removed, or which update() has not seen",
                     numberOf(upload.buffer));
    }
    if (upload.size == 0 || upload.size % 4 != 0 || upload.offset % 4 != 0) {
      return invalid(
          "upload into buffer '{}' of {} bytes at {}: both have to be multiples of 4, and the size "
          "above 0",
          buffer->name, upload.size, upload.offset);
    }
    if (!fits(upload.offset, upload.size, buffer->size)) {
      return invalid("upload into buffer '{}': {} bytes at {} are not inside its {} bytes",
                     buffer->name, upload.size, upload.offset, buffer->size);
    }
    if (!fits(upload.dataOffset, upload.size, list_.uploadData.size())) {
      return invalid("upload into buffer '{}' takes {} bytes at {} of the list's {} bytes of data",
                     buffer->name, upload.size, upload.dataOffset, list_.uploadData.size());
    }
  }
  return {};
}

Result<void> Checker::barriers(std::span<const Barrier> barriers, const char* where) const {
  for (const Barrier& barrier : barriers) {
    if (find_(barrier.buffer)) continue;
    return invalid(
        "a barrier {} names buffer {}: update() has not seen it, or it was removed, with an object "
        "or by trim(); then write the list again",
        where, numberOf(barrier.buffer));
  }
  return {};
}

Result<void> Checker::constants(const Pass& pass, const PassBinding& binding,
                                const LayoutEntry& entry) const {
  if (binding.size == 0 || binding.size < entry.stride ||
      !fits(binding.offset, binding.size, list_.constants.size())) {
    return invalid(
        "{}, resource '{}': {} bytes at {} are no block of {} bytes in the list's {} bytes of "
        "constants",
        nameOf(pass), entry.name, binding.size, binding.offset, entry.stride,
        list_.constants.size());
  }
  if (binding.offset % PassList::kConstantAlignment != 0) {
    return invalid("{}, resource '{}': offset {} in the constants is not a multiple of {}",
                   nameOf(pass), entry.name, binding.offset,
                   uint64_t{PassList::kConstantAlignment});
  }
  if (binding.size <= limits_.uniformBytes) return {};
  return unsupported("{}, resource '{}': a block of {} bytes; the device reads at most {}",
                     nameOf(pass), entry.name, binding.size, limits_.uniformBytes);
}

Result<void> Checker::storage(const Pass& pass, const PassBinding& binding,
                              const LayoutEntry& entry) const {
  const std::optional<KnownBuffer> buffer = find_(binding.buffer);
  if (!buffer) {
    return invalid("{}, resource '{}': buffer {} was removed, or update() has not seen it",
                   nameOf(pass), entry.name, numberOf(binding.buffer));
  }
  if (binding.size == 0 || !fits(binding.offset, binding.size, buffer->size)) {
    return invalid("{}, resource '{}': {} bytes at {} are not inside buffer '{}' of {} bytes",
                   nameOf(pass), entry.name, binding.size, binding.offset, buffer->name,
                   buffer->size);
  }
  const uint64_t offset = buffer->offset + binding.offset;
  if (offset % limits_.storageAlignment != 0) {
    return invalid(
        "{}, resource '{}': offset {} of buffer '{}' is not a multiple of {}, the device's storage "
        "buffer offset alignment",
        nameOf(pass), entry.name, offset, buffer->name, limits_.storageAlignment);
  }
  if (binding.size <= limits_.storageBytes) return {};
  return unsupported(
      "{}, resource '{}': {} bytes of buffer '{}'; the device binds at most {}: split the object",
      nameOf(pass), entry.name, binding.size, buffer->name, limits_.storageBytes);
}

Result<void> Checker::groups(const Pass& pass) const {
  for (int axis = 0; axis < 3; ++axis) {
    if (pass.groups[axis] == 0)
      return invalid("{} has no thread groups on axis {}", nameOf(pass), "xyz"[axis]);
    if (pass.groups[axis] <= limits_.groups[axis]) continue;
    return unsupported("{} needs {} thread groups on axis {}, the device runs {}: split the object",
                       nameOf(pass), pass.groups[axis], "xyz"[axis], limits_.groups[axis]);
  }
  return {};
}

Result<void> Checker::indirect(const Pass& pass) const {
  const std::optional<KnownBuffer> buffer = find_(pass.indirect);
  if (!buffer) {
    return invalid(
        "{}: buffer {} of its indirect arguments was removed, or update() has not seen it",
        nameOf(pass), numberOf(pass.indirect));
  }
  if (!contains(buffer->usage, BufferUsage::kIndirect)) {
    return invalid("{}: buffer '{}' was not made for indirect arguments (BufferUsage::kIndirect)",
                   nameOf(pass), buffer->name);
  }
  const uint64_t size = isDraw(pass.kind) ? kDrawArguments : kDispatchArguments;
  if (pass.indirectOffset % 4 != 0) {
    return invalid("{}: its indirect arguments in buffer '{}' are at {}, which is no multiple of 4",
                   nameOf(pass), buffer->name, pass.indirectOffset);
  }
  if (!fits(pass.indirectOffset, size, buffer->size)) {
    return invalid(
        "{}: its indirect arguments, {} bytes at {}, are not inside buffer '{}' of {} bytes",
        nameOf(pass), size, pass.indirectOffset, buffer->name, buffer->size);
  }
  if (isDraw(pass.kind) && pass.indices != BufferId::kInvalid)
    return invalid("{}: an indirect draw has no indices", nameOf(pass));
  return {};
}

Result<void> Checker::indices(const Pass& pass) const {
  const std::optional<KnownBuffer> buffer = find_(pass.indices);
  if (!buffer) {
    return invalid("{}: buffer {} of its indices was removed, or update() has not seen it",
                   nameOf(pass), numberOf(pass.indices));
  }
  if (!contains(buffer->usage, BufferUsage::kIndex)) {
    return invalid("{}: buffer '{}' was not made for indices (BufferUsage::kIndex)", nameOf(pass),
                   buffer->name);
  }
  if (fits(0, uint64_t{pass.elementCount} * sizeof(uint32_t), buffer->size)) return {};
  return invalid("{}: its {} indices are not inside buffer '{}' of {} bytes", nameOf(pass),
                 pass.elementCount, buffer->name, buffer->size);
}

Result<void> Checker::vertices(const Pass& pass) const {
  const VertexInput& input = *pass.kernel->kernel->vertexInput;
  const BufferRange& range = pass.vertices;
  const std::optional<KnownBuffer> buffer = find_(range.buffer);
  if (!buffer) {
    return invalid("{}: buffer {} of its vertices was removed, or update() has not seen it",
                   nameOf(pass), numberOf(range.buffer));
  }
  if (!contains(buffer->usage, BufferUsage::kVertex)) {
    return invalid("{}: buffer '{}' was not made for vertices (BufferUsage::kVertex)", nameOf(pass),
                   buffer->name);
  }
  if (range.offset % 4 != 0 || !fits(range.offset, range.size, buffer->size)) {
    return invalid(
        "{}: its vertices, {} bytes at {}, are no whole words inside buffer '{}' of {} bytes",
        nameOf(pass), range.size, range.offset, buffer->name, buffer->size);
  }
  // Only the GPU knows the vertices that indices and indirect arguments ask for.
  const bool known =
      pass.kind == PassKind::kDraw && (input.perInstance || pass.indices == BufferId::kInvalid);
  const uint64_t needed = input.bytes(!known              ? 0
                                      : input.perInstance ? pass.instanceCount
                                                          : pass.elementCount);
  if (needed <= range.size) return {};
  return invalid("{} reads {} bytes of vertices; {} of buffer '{}' are given", nameOf(pass), needed,
                 range.size, buffer->name);
}

Result<void> Checker::pass(const Pass& pass) const {
  const auto layouts = pass.layouts();
  for (const PassBinding& binding : list_.bindingsOf(pass)) {
    const LayoutEntry& entry = layouts[binding.set]->entries[binding.entry];
    // The runtimes know the textures, and check them.
    if (isTexture(entry.kind)) continue;
    Result<void> checked = entry.kind == ResourceKind::kUniformBuffer
                               ? constants(pass, binding, entry)
                               : storage(pass, binding, entry);
    if (!checked) return checked;
  }
  if (pass.kernel->kernel->vertexInput != nullptr) {
    if (Result<void> checked = vertices(pass); !checked) return checked;
  }
  if (pass.elementCount > kMaxCount || pass.instanceCount > kMaxCount)
    return invalid("{} has more elements or instances than {}", nameOf(pass), kMaxCount);
  switch (pass.kind) {
    case PassKind::kDispatch:
      return groups(pass);
    case PassKind::kDispatchIndirect:
    case PassKind::kDrawIndirect:
      return indirect(pass);
    case PassKind::kDraw:
      break;
  }
  return pass.indices != BufferId::kInvalid ? indices(pass) : Result<void>();
}

}  // namespace

std::string variantName(const KernelVariant& variant) {
  const bool keyed = variant.key != nullptr && variant.key[0] != '\0';
  return keyed ? fmt::format("{} [{}]", variant.kernel->name, variant.key) : variant.kernel->name;
}

namespace {

uint32_t storageBuffers(const KernelVariant& variant) {
  const auto isStorage = [&](const VariantBinding& use) {
    const LayoutTable& layout = *variant.kernel->layouts[use.set];
    return layout.entries[use.entry].kind == ResourceKind::kStorageBuffer;
  };
  return static_cast<uint32_t>(
      std::count_if(variant.bindings.begin(), variant.bindings.end(), isStorage));
}

const char* nameOf(Stage stage) {
  return stage == Stage::kCompute ? "compute" : stage == Stage::kVertex ? "vertex" : "pixel";
}

}  // namespace

Result<void> checkLimits(const KernelVariant& kernel, const KernelVariant* pixel,
                         const TierLimits& limits, std::string_view device) {
  uint32_t both = 0;
  for (const KernelVariant* variant : {&kernel, pixel}) {
    if (variant == nullptr) continue;
    const Stage stage = variant->kernel->stage;
    const uint32_t needed = storageBuffers(*variant), allowed = limits.storageBuffers.of(stage);
    both += needed;
    if (needed > allowed) {
      return unsupported(
          "kernel {} needs {} storage buffers in the {} stage; {} allows {}: docs/limits.md has "
          "what "
          "each feature needs",
          variantName(*variant), needed, nameOf(stage), device, allowed);
    }
  }
  if (pixel != nullptr && both > limits.drawStorageBuffers) {
    return unsupported(
        "kernels {} and {} need {} storage buffers together; {} allows {}: docs/limits.md has what "
        "each feature needs",
        variantName(kernel), variantName(*pixel), both, device, limits.drawStorageBuffers);
  }
  uint64_t threads = 1;
  for (int axis = 0; axis < 3; ++axis) {
    threads *= kernel.groupSize[axis];
    if (kernel.groupSize[axis] <= limits.groupSize[axis]) continue;
    return unsupported("kernel {} has {} threads a group on axis {}; {} allows {}",
                       variantName(kernel), kernel.groupSize[axis], "xyz"[axis], device,
                       limits.groupSize[axis]);
  }
  if (threads <= limits.groupThreads) return {};
  return unsupported("kernel {} has {} threads a group; {} allows {}", variantName(kernel), threads,
                     device, limits.groupThreads);
}

Result<void> checkPasses(const PassList& list) {
  bool draws = false;
  for (const Pass& pass : list.passes) {
    if (Result<void> checked = checkKernels(pass); !checked) return checked;
    if (!fits(pass.firstBinding, pass.bindingCount, list.bindings.size()) ||
        !fits(pass.firstSpecValue, pass.specValueCount, list.specValues.size()) ||
        !fits(pass.firstBarrier, pass.barrierCount, list.barriers.size())) {
      return invalid("{}: its bindings, spec values or barriers are not in the list", nameOf(pass));
    }
    if (draws && !isDraw(pass.kind)) {
      return invalid("{}: a dispatch stands behind a draw; dispatches come first", nameOf(pass));
    }
    draws = draws || isDraw(pass.kind);
    if (Result<void> checked = checkBindings(list, pass); !checked) return checked;
  }
  return {};
}

Result<void> checkList(const PassList& list, const BufferLookup& find, const DeviceLimits& limits,
                       ListPart part) {
  if (!find) return invalid("checkList(): the lookup of buffers is empty: give a function");
  // Why its buffers are gone says more than that they are.
  if (detail::isAbandoned(list)) return checkRun(list);
  if (Result<void> checked = checkPasses(list); !checked) return checked;
  const Checker checker(list, find, limits);
  if (part != ListPart::kDraws) {
    if (Result<void> checked = checker.uploads(); !checked) return checked;
    for (const auto& [barriers, where] : {std::pair(&list.uploadBarriers, "before the uploads"),
                                          std::pair(&list.barriers, "between the dispatches"),
                                          std::pair(&list.drawBarriers, "before the draws")}) {
      if (Result<void> checked = checker.barriers(*barriers, where); !checked) return checked;
    }
  }
  for (const Pass& pass : list.passes) {
    const ListPart own = isDraw(pass.kind) ? ListPart::kDraws : ListPart::kDispatches;
    if (part != ListPart::kAll && part != own) continue;
    if (Result<void> checked = checker.pass(pass); !checked) return checked;
  }
  return {};
}

Result<void> checkList(const PassList& list, const ResourceTable& resources,
                       const DeviceLimits& limits, ListPart part) {
  if (Result<void> checked = checkTable(list, resources.id()); !checked) return checked;
  const auto find = [&resources](BufferId id) -> std::optional<KnownBuffer> {
    const BufferDesc* desc = resources.find(id);
    if (desc == nullptr) return {};
    return KnownBuffer{.name = desc->name, .size = desc->size, .usage = desc->usage};
  };
  return checkList(list, find, limits, part);
}

Result<void> checkArea(const PassList& list, const PixelArea& area) {
  const PixelArea& view = list.area;
  if (view.width == 0 || view.height == 0 || view == area) return {};
  return invalid(
      "draws into an area of {} x {} pixels at ({}, {}), but the view of the list has {} x {} at "
      "({}, {}): give View::x, y, width and height, and the runtime, the same rectangle",
      area.width, area.height, area.x, area.y, view.width, view.height, view.x, view.y);
}

Result<void> checkSamples(const PassList& list, uint32_t samples) {
  if (list.samples == 0 || list.samples == samples) return {};
  return invalid(
      "draws into a target of {} sample{}, but View::samples is {}: give both the same number",
      samples, samples == 1 ? "" : "s", list.samples);
}

Result<void> checkTable(const PassList& list, uint64_t table) {
  if (list.table == 0 || table == 0 || list.table == table) return {};
  return invalid(
      "the list is of another scene than the buffers of this runtime: make a runtime for each "
      "scene");
}

}  // namespace pelage
