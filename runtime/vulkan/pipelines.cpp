#include "pipelines.h"

#include <fmt/format.h>

#include <cstring>

#include "spirv_facts.h"

namespace pelage::vulkan {
namespace {

VkShaderStageFlagBits stageFlag(Stage stage) {
  switch (stage) {
    case Stage::kCompute:
      return VK_SHADER_STAGE_COMPUTE_BIT;
    case Stage::kVertex:
      return VK_SHADER_STAGE_VERTEX_BIT;
    case Stage::kPixel:
      return VK_SHADER_STAGE_FRAGMENT_BIT;
  }
  PELAGE_ASSERT(false, "a stage that is not in the enumeration");
  return VK_SHADER_STAGE_COMPUTE_BIT;
}

VkCompareOp compareOp(DepthCompare compare) {
  switch (compare) {
    case DepthCompare::kAlways:
      return VK_COMPARE_OP_ALWAYS;
    case DepthCompare::kLess:
      return VK_COMPARE_OP_LESS;
    case DepthCompare::kLessEqual:
      return VK_COMPARE_OP_LESS_OR_EQUAL;
    case DepthCompare::kGreater:
      return VK_COMPARE_OP_GREATER;
    case DepthCompare::kGreaterEqual:
      return VK_COMPARE_OP_GREATER_OR_EQUAL;
    case DepthCompare::kEqual:
      return VK_COMPARE_OP_EQUAL;
  }
  PELAGE_ASSERT(false, "a depth comparison that is not in the enumeration");
  return VK_COMPARE_OP_ALWAYS;
}

VkPrimitiveTopology primitiveTopology(PrimitiveTopology topology) {
  switch (topology) {
    case PrimitiveTopology::kTriangleList:
      return VK_PRIMITIVE_TOPOLOGY_TRIANGLE_LIST;
    case PrimitiveTopology::kTriangleStrip:
      return VK_PRIMITIVE_TOPOLOGY_TRIANGLE_STRIP;
    case PrimitiveTopology::kLineList:
      return VK_PRIMITIVE_TOPOLOGY_LINE_LIST;
  }
  PELAGE_ASSERT(false, "a topology that is not in the enumeration");
  return VK_PRIMITIVE_TOPOLOGY_TRIANGLE_LIST;
}

// Whether stored cache data was made by this driver on this device. Drivers must check that
// themselves, but not all of them survived data of another one (Vulkan specification, 10.6.3, has
// the header).
bool cacheDataFits(std::span<const std::byte> data, const VkPhysicalDeviceProperties& properties) {
  VkPipelineCacheHeaderVersionOne header = {};
  if (data.size() < sizeof(header)) return false;
  std::memcpy(&header, data.data(), sizeof(header));
  return header.headerSize >= sizeof(header) && header.headerSize <= data.size() &&
         header.headerVersion == VK_PIPELINE_CACHE_HEADER_VERSION_ONE &&
         header.vendorID == properties.vendorID && header.deviceID == properties.deviceID &&
         std::memcmp(header.pipelineCacheUUID, properties.pipelineCacheUUID, VK_UUID_SIZE) == 0;
}

// Specialization constants are four bytes each, a bool as VkBool32.
struct Specialization {
  std::vector<VkSpecializationMapEntry> entries;
  std::vector<uint32_t> bits;
  VkSpecializationInfo info = {};

  explicit Specialization(std::span<const SpecValue> values) {
    for (const SpecValue& value : values) {
      entries.push_back(
          {value.id, static_cast<uint32_t>(bits.size() * sizeof(uint32_t)), sizeof(uint32_t)});
      bits.push_back(value.bits);
    }
    info.mapEntryCount = static_cast<uint32_t>(entries.size());
    info.pMapEntries = entries.data();
    info.dataSize = bits.size() * sizeof(uint32_t);
    info.pData = bits.data();
  }
  Specialization(const Specialization&) = delete;
  Specialization& operator=(const Specialization&) = delete;
};

void appendKey(std::vector<uint64_t>& key, std::span<const SpecValue> values) {
  for (const SpecValue& value : values) key.push_back(uint64_t{value.id} << 32 | value.bits);
}

uint64_t pointerKey(const void* pointer) { return reinterpret_cast<uintptr_t>(pointer); }

}  // namespace

std::string variantName(const KernelVariant& variant) {
  const bool keyed = variant.key != nullptr && variant.key[0] != '\0';
  return keyed ? fmt::format("{} [{}]", variant.kernel->name, variant.key) : variant.kernel->name;
}

struct Pipelines::Module {
  Module(const Device& owner, VkShaderModule module, std::string entry)
      : device(&owner), handle(module), entryPoint(std::move(entry)) {}
  Module(Module&& other) noexcept
      : device(other.device),
        handle(std::exchange(other.handle, VK_NULL_HANDLE)),
        entryPoint(std::move(other.entryPoint)) {}
  Module& operator=(Module&&) = delete;
  ~Module() {
    if (handle != VK_NULL_HANDLE)
      device->vk.DestroyShaderModule(device->handle, handle, device->callbacks);
  }

  VkPipelineShaderStageCreateInfo stage(VkShaderStageFlagBits flag,
                                        const VkSpecializationInfo& specialization) const {
    auto info = tagged<VkPipelineShaderStageCreateInfo>(
        VK_STRUCTURE_TYPE_PIPELINE_SHADER_STAGE_CREATE_INFO);
    info.stage = flag;
    info.module = handle;
    info.pName = entryPoint.c_str();
    info.pSpecializationInfo = &specialization;
    return info;
  }

  const Device* device;
  VkShaderModule handle;
  std::string entryPoint;
};

Pipelines::Pipelines(const Device& device, Descriptors& descriptors)
    : device_(device), descriptors_(descriptors) {}

Pipelines::~Pipelines() {
  for (const auto& [key, cached] : pipelines_)
    device_.vk.DestroyPipeline(device_.handle, cached.pipeline.handle, device_.callbacks);
  for (const auto& [key, layout] : layouts_)
    device_.vk.DestroyPipelineLayout(device_.handle, layout, device_.callbacks);
  if (ownsCache_) device_.vk.DestroyPipelineCache(device_.handle, cache_, device_.callbacks);
}

Result<void> Pipelines::openCache(VkPipelineCache engine, std::span<const std::byte> data) {
  if (engine != VK_NULL_HANDLE) {
    cache_ = engine;
    return {};
  }
  auto info = tagged<VkPipelineCacheCreateInfo>(VK_STRUCTURE_TYPE_PIPELINE_CACHE_CREATE_INFO);
  if (cacheDataFits(data, device_.properties)) {
    info.initialDataSize = data.size();
    info.pInitialData = data.data();
  }
  const VkResult result =
      device_.vk.CreatePipelineCache(device_.handle, &info, device_.callbacks, &cache_);
  if (result != VK_SUCCESS) return vulkanError(result, "pipeline cache");
  ownsCache_ = true;
  return {};
}

Result<std::vector<std::byte>> Pipelines::cacheData() const {
  // Another thread may add pipelines to an engine's cache between the two calls: ask again then.
  for (;;) {
    size_t size = 0;
    VkResult result = device_.vk.GetPipelineCacheData(device_.handle, cache_, &size, nullptr);
    if (result != VK_SUCCESS) return vulkanError(result, "size of the pipeline cache");
    std::vector<std::byte> data(size);
    result = device_.vk.GetPipelineCacheData(device_.handle, cache_, &size, data.data());
    if (result == VK_INCOMPLETE) continue;
    if (result != VK_SUCCESS) return vulkanError(result, "contents of the pipeline cache");
    data.resize(size);
    return data;
  }
}

Result<void> Pipelines::checkLimits(const Kernel& kernel) const {
  const VkPhysicalDeviceLimits& limits = device_.limits();
  if (kernel.layouts.size() > limits.maxBoundDescriptorSets) {
    return Error{ErrorCode::kUnsupported,
                 fmt::format("kernel {} has {} descriptor sets, the device binds {} "
                             "(maxBoundDescriptorSets)",
                             kernel.name, kernel.layouts.size(), limits.maxBoundDescriptorSets)};
  }
  const auto check = [&](uint32_t count, uint32_t limit, const char* what,
                         const char* limitName) -> Result<void> {
    if (count <= limit) return {};
    return Error{ErrorCode::kUnsupported,
                 fmt::format("the layouts of kernel {} have {} {}, the device allows {} ({})",
                             kernel.name, count, what, limit, limitName)};
  };
  uint32_t dynamicUniforms = 0;
  uint32_t allStorage = 0;
  for (const Stage stage : {Stage::kCompute, Stage::kVertex, Stage::kPixel}) {
    uint32_t storage = 0;
    uint32_t uniforms = 0;
    uint32_t all = 0;
    for (const LayoutTable* table : kernel.layouts) {
      if (table == nullptr) continue;
      for (const LayoutEntry& entry : table->entries) {
        if ((entry.stages & stageBit(stage)) == 0) continue;
        ++all;
        if (entry.kind == ResourceKind::kStorageBuffer) ++storage;
        if (entry.kind == ResourceKind::kUniformBuffer) ++uniforms;
      }
    }
    for (const Result<void>& result :
         {check(storage, limits.maxPerStageDescriptorStorageBuffers, "storage buffers in a stage",
                "maxPerStageDescriptorStorageBuffers"),
          check(uniforms, limits.maxPerStageDescriptorUniformBuffers, "uniform blocks in a stage",
                "maxPerStageDescriptorUniformBuffers"),
          check(all, limits.maxPerStageResources, "resources in a stage",
                "maxPerStageResources")}) {
      if (!result) return result;
    }
  }
  for (const LayoutTable* table : kernel.layouts) {
    if (table == nullptr) continue;
    for (const LayoutEntry& entry : table->entries) {
      if (entry.kind == ResourceKind::kUniformBuffer) ++dynamicUniforms;
      if (entry.kind == ResourceKind::kStorageBuffer) ++allStorage;
    }
  }
  if (Result<void> result = check(dynamicUniforms, limits.maxDescriptorSetUniformBuffersDynamic,
                                  "uniform blocks", "maxDescriptorSetUniformBuffersDynamic");
      !result)
    return result;
  return check(allStorage, limits.maxDescriptorSetStorageBuffers, "storage buffers",
               "maxDescriptorSetStorageBuffers");
}

Result<VkPipelineLayout> Pipelines::layout(const Kernel& kernel) {
  std::vector<uint64_t> key;
  for (const LayoutTable* table : kernel.layouts) key.push_back(pointerKey(table));
  if (const auto known = layouts_.find(key); known != layouts_.end()) return known->second;

  if (Result<void> checked = checkLimits(kernel); !checked) return checked.error();
  std::vector<VkDescriptorSetLayout> sets;
  for (const LayoutTable* table : kernel.layouts) {
    Result<VkDescriptorSetLayout> set =
        table != nullptr ? descriptors_.layout(*table) : descriptors_.emptyLayout();
    if (!set) return set.error();
    sets.push_back(*set);
  }
  auto info = tagged<VkPipelineLayoutCreateInfo>(VK_STRUCTURE_TYPE_PIPELINE_LAYOUT_CREATE_INFO);
  info.setLayoutCount = static_cast<uint32_t>(sets.size());
  info.pSetLayouts = sets.data();
  const auto place = layouts_.emplace(std::move(key), VK_NULL_HANDLE).first;
  const VkResult result =
      device_.vk.CreatePipelineLayout(device_.handle, &info, device_.callbacks, &place->second);
  if (result != VK_SUCCESS) {
    layouts_.erase(place);
    return vulkanError(result, fmt::format("pipeline layout of kernel {}", kernel.name));
  }
  device_.vk.name(device_.handle, VK_OBJECT_TYPE_PIPELINE_LAYOUT, place->second, kernel.name);
  return place->second;
}

Result<Pipelines::Module> Pipelines::module(const KernelVariant& variant) const {
  const VkShaderStageFlagBits stage = stageFlag(variant.kernel->stage);
  if (variant.spirv.empty()) {
    return Error{ErrorCode::kInvalidArgument,
                 fmt::format("kernel {} has no SPIR-V: build it with codegen's SPIR-V output on",
                             variantName(variant))};
  }
  Result<SpirvFacts> facts = spirvFacts(variant.spirv, stage, device_);
  if (!facts) {
    return Error{facts.error().code,
                 fmt::format("kernel {}: {}", variantName(variant), facts.error().message)};
  }
  std::string missing = facts->missingFeature;
  for (const VariantBinding& use : variant.bindings) {
    if (!writes(use.access)) continue;
    if (stage == VK_SHADER_STAGE_VERTEX_BIT && !device_.features.vertexPipelineStoresAndAtomics)
      missing = "the device feature vertexPipelineStoresAndAtomics";
    if (stage == VK_SHADER_STAGE_FRAGMENT_BIT && !device_.features.fragmentStoresAndAtomics)
      missing = "the device feature fragmentStoresAndAtomics";
  }
  if (!missing.empty()) {
    return Error{ErrorCode::kUnsupported,
                 fmt::format("kernel {} needs {}, which the device lacks or which was not enabled "
                             "(RuntimeDef::enabledFeatures)",
                             variantName(variant), missing)};
  }
  auto info = tagged<VkShaderModuleCreateInfo>(VK_STRUCTURE_TYPE_SHADER_MODULE_CREATE_INFO);
  info.codeSize = variant.spirv.size_bytes();
  info.pCode = variant.spirv.data();
  VkShaderModule handle = VK_NULL_HANDLE;
  const VkResult result =
      device_.vk.CreateShaderModule(device_.handle, &info, device_.callbacks, &handle);
  if (result != VK_SUCCESS)
    return vulkanError(result, fmt::format("shader module of {}", variantName(variant)));
  return Module(device_, handle, std::move(facts->entryPoint));
}

Result<Pipeline> Pipelines::compute(const KernelVariant& variant,
                                    std::span<const SpecValue> values) {
  key_.assign({pointerKey(&variant)});
  appendKey(key_, values);
  if (const auto known = pipelines_.find(key_); known != pipelines_.end())
    return known->second.pipeline;

  const VkPhysicalDeviceLimits& limits = device_.limits();
  uint64_t threads = 1;
  for (int axis = 0; axis < 3; ++axis) {
    threads *= variant.groupSize[axis];
    if (variant.groupSize[axis] > limits.maxComputeWorkGroupSize[axis] ||
        threads > limits.maxComputeWorkGroupInvocations) {
      return Error{ErrorCode::kUnsupported,
                   fmt::format("kernel {} has groups of {} x {} x {} threads, the device allows "
                               "{} x {} x {} and {} together",
                               variantName(variant), variant.groupSize[0], variant.groupSize[1],
                               variant.groupSize[2], limits.maxComputeWorkGroupSize[0],
                               limits.maxComputeWorkGroupSize[1], limits.maxComputeWorkGroupSize[2],
                               limits.maxComputeWorkGroupInvocations)};
    }
  }
  Result<VkPipelineLayout> pipelineLayout = layout(*variant.kernel);
  if (!pipelineLayout) return pipelineLayout.error();
  Result<Module> shader = module(variant);
  if (!shader) return shader.error();

  const Specialization specialization(values);
  auto info = tagged<VkComputePipelineCreateInfo>(VK_STRUCTURE_TYPE_COMPUTE_PIPELINE_CREATE_INFO);
  info.stage = shader->stage(VK_SHADER_STAGE_COMPUTE_BIT, specialization.info);
  info.layout = *pipelineLayout;
  info.basePipelineIndex = -1;
  const std::string name = variantName(variant);
  const auto place = pipelines_.emplace(key_, Cached{{VK_NULL_HANDLE, *pipelineLayout}, {}}).first;
  Pipeline& pipeline = place->second.pipeline;
  const VkResult result = device_.vk.CreateComputePipelines(device_.handle, cache_, 1, &info,
                                                            device_.callbacks, &pipeline.handle);
  if (result != VK_SUCCESS) {
    pipelines_.erase(place);
    return vulkanError(result, "pipeline of kernel " + name);
  }
  device_.vk.name(device_.handle, VK_OBJECT_TYPE_PIPELINE, pipeline.handle, name.c_str());
  return pipeline;
}

Result<Pipeline> Pipelines::graphics(const KernelVariant& vertex, const KernelVariant& pixel,
                                     std::span<const SpecValue> values, const DrawState& state,
                                     const TargetFormats& target) {
  key_.assign({pointerKey(&vertex), pointerKey(&pixel),
               static_cast<uint64_t>(state.topology) |
                   static_cast<uint64_t>(state.depthCompare) << 8 |
                   static_cast<uint64_t>(state.depthWrite) << 16 |
                   static_cast<uint64_t>(state.blend) << 24 |
                   static_cast<uint64_t>(state.colorWrite) << 31 |
                   static_cast<uint64_t>(target.samples) << 32,
               static_cast<uint64_t>(target.color) << 32 | static_cast<uint32_t>(target.depth),
               // NOLINTNEXTLINE: an integer on 32-bit platforms, a pointer on others
               (uint64_t)target.renderPass, target.subpass});
  appendKey(key_, values);
  if (const auto known = pipelines_.find(key_); known != pipelines_.end())
    return known->second.pipeline;

  const std::string name = variantName(vertex) + " + " + variantName(pixel);
  if (target.renderPass == VK_NULL_HANDLE && !device_.vk.dynamicRendering) {
    return Error{ErrorCode::kUnsupported,
                 "draw " + name +
                     ": TargetFormats::renderPass is null and the device has no dynamic rendering "
                     "(Vulkan 1.3 or VK_KHR_dynamic_rendering): give a render pass"};
  }
  Result<VkPipelineLayout> pipelineLayout =
      layout(pixel.kernel->layouts.size() > vertex.kernel->layouts.size() ? *pixel.kernel
                                                                          : *vertex.kernel);
  if (!pipelineLayout) return pipelineLayout.error();
  Result<Module> vertexShader = module(vertex);
  if (!vertexShader) return vertexShader.error();
  Result<Module> pixelShader = module(pixel);
  if (!pixelShader) return pixelShader.error();

  const Specialization specialization(values);
  const VkPipelineShaderStageCreateInfo stages[] = {
      vertexShader->stage(VK_SHADER_STAGE_VERTEX_BIT, specialization.info),
      pixelShader->stage(VK_SHADER_STAGE_FRAGMENT_BIT, specialization.info)};
  const auto vertexInput = tagged<VkPipelineVertexInputStateCreateInfo>(
      VK_STRUCTURE_TYPE_PIPELINE_VERTEX_INPUT_STATE_CREATE_INFO);
  auto assembly = tagged<VkPipelineInputAssemblyStateCreateInfo>(
      VK_STRUCTURE_TYPE_PIPELINE_INPUT_ASSEMBLY_STATE_CREATE_INFO);
  assembly.topology = primitiveTopology(state.topology);
  auto viewport = tagged<VkPipelineViewportStateCreateInfo>(
      VK_STRUCTURE_TYPE_PIPELINE_VIEWPORT_STATE_CREATE_INFO);
  viewport.viewportCount = 1;
  viewport.scissorCount = 1;
  auto raster = tagged<VkPipelineRasterizationStateCreateInfo>(
      VK_STRUCTURE_TYPE_PIPELINE_RASTERIZATION_STATE_CREATE_INFO);
  raster.polygonMode = VK_POLYGON_MODE_FILL;
  raster.cullMode = VK_CULL_MODE_NONE;
  raster.frontFace = VK_FRONT_FACE_COUNTER_CLOCKWISE;
  raster.lineWidth = 1;
  auto multisample = tagged<VkPipelineMultisampleStateCreateInfo>(
      VK_STRUCTURE_TYPE_PIPELINE_MULTISAMPLE_STATE_CREATE_INFO);
  multisample.rasterizationSamples = target.samples;
  auto depth = tagged<VkPipelineDepthStencilStateCreateInfo>(
      VK_STRUCTURE_TYPE_PIPELINE_DEPTH_STENCIL_STATE_CREATE_INFO);
  const bool hasDepth = target.depth != VK_FORMAT_UNDEFINED;
  depth.depthTestEnable =
      hasDepth && (state.depthCompare != DepthCompare::kAlways || state.depthWrite);
  depth.depthWriteEnable = hasDepth && state.depthWrite;
  depth.depthCompareOp = compareOp(state.depthCompare);
  VkPipelineColorBlendAttachmentState attachment = {};
  if (state.colorWrite) {
    attachment.colorWriteMask = VK_COLOR_COMPONENT_R_BIT | VK_COLOR_COMPONENT_G_BIT |
                                VK_COLOR_COMPONENT_B_BIT | VK_COLOR_COMPONENT_A_BIT;
  }
  attachment.blendEnable = state.blend == BlendMode::kPremultipliedAlpha;
  attachment.srcColorBlendFactor = VK_BLEND_FACTOR_ONE;
  attachment.dstColorBlendFactor = VK_BLEND_FACTOR_ONE_MINUS_SRC_ALPHA;
  attachment.colorBlendOp = VK_BLEND_OP_ADD;
  attachment.srcAlphaBlendFactor = VK_BLEND_FACTOR_ONE;
  attachment.dstAlphaBlendFactor = VK_BLEND_FACTOR_ONE_MINUS_SRC_ALPHA;
  attachment.alphaBlendOp = VK_BLEND_OP_ADD;
  auto blend = tagged<VkPipelineColorBlendStateCreateInfo>(
      VK_STRUCTURE_TYPE_PIPELINE_COLOR_BLEND_STATE_CREATE_INFO);
  blend.attachmentCount = 1;
  blend.pAttachments = &attachment;
  const VkDynamicState dynamics[] = {VK_DYNAMIC_STATE_VIEWPORT, VK_DYNAMIC_STATE_SCISSOR};
  auto dynamic = tagged<VkPipelineDynamicStateCreateInfo>(
      VK_STRUCTURE_TYPE_PIPELINE_DYNAMIC_STATE_CREATE_INFO);
  dynamic.dynamicStateCount = static_cast<uint32_t>(std::size(dynamics));
  dynamic.pDynamicStates = dynamics;

  auto rendering =
      tagged<VkPipelineRenderingCreateInfo>(VK_STRUCTURE_TYPE_PIPELINE_RENDERING_CREATE_INFO);
  rendering.colorAttachmentCount = 1;
  rendering.pColorAttachmentFormats = &target.color;
  rendering.depthAttachmentFormat = target.depth;

  auto info = tagged<VkGraphicsPipelineCreateInfo>(VK_STRUCTURE_TYPE_GRAPHICS_PIPELINE_CREATE_INFO);
  if (target.renderPass == VK_NULL_HANDLE) info.pNext = &rendering;
  info.stageCount = static_cast<uint32_t>(std::size(stages));
  info.pStages = stages;
  info.pVertexInputState = &vertexInput;
  info.pInputAssemblyState = &assembly;
  info.pViewportState = &viewport;
  info.pRasterizationState = &raster;
  info.pMultisampleState = &multisample;
  info.pDepthStencilState = &depth;
  info.pColorBlendState = &blend;
  info.pDynamicState = &dynamic;
  info.layout = *pipelineLayout;
  info.renderPass = target.renderPass;
  info.subpass = target.subpass;
  info.basePipelineIndex = -1;
  const auto place =
      pipelines_.emplace(key_, Cached{{VK_NULL_HANDLE, *pipelineLayout}, target.renderPass}).first;
  Pipeline& pipeline = place->second.pipeline;
  const VkResult result = device_.vk.CreateGraphicsPipelines(device_.handle, cache_, 1, &info,
                                                             device_.callbacks, &pipeline.handle);
  if (result != VK_SUCCESS) {
    pipelines_.erase(place);
    return vulkanError(result, "pipeline of draw " + name);
  }
  device_.vk.name(device_.handle, VK_OBJECT_TYPE_PIPELINE, pipeline.handle, name.c_str());
  return pipeline;
}

void Pipelines::forget(VkRenderPass renderPass) {
  if (renderPass == VK_NULL_HANDLE) return;
  std::erase_if(pipelines_, [&](const auto& entry) {
    if (entry.second.renderPass != renderPass) return false;
    device_.vk.DestroyPipeline(device_.handle, entry.second.pipeline.handle, device_.callbacks);
    return true;
  });
}

}  // namespace pelage::vulkan
