#include "pipelines.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <chrono>
#include <cstring>
#include <optional>
#include <thread>

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

VkFormat formatOf(VertexFormat format) {
  switch (format) {
    case VertexFormat::kFloat1:
      return VK_FORMAT_R32_SFLOAT;
    case VertexFormat::kFloat2:
      return VK_FORMAT_R32G32_SFLOAT;
    case VertexFormat::kFloat3:
      return VK_FORMAT_R32G32B32_SFLOAT;
    case VertexFormat::kFloat4:
      return VK_FORMAT_R32G32B32A32_SFLOAT;
    case VertexFormat::kUint1:
      return VK_FORMAT_R32_UINT;
    case VertexFormat::kUint2:
      return VK_FORMAT_R32G32_UINT;
    case VertexFormat::kUint3:
      return VK_FORMAT_R32G32B32_UINT;
    case VertexFormat::kUint4:
      return VK_FORMAT_R32G32B32A32_UINT;
  }
  PELAGE_ASSERT(false, "a vertex format that is not in the enumeration");
  return VK_FORMAT_R32_SFLOAT;
}

bool isStencilFormat(VkFormat format) {
  return format == VK_FORMAT_S8_UINT || format == VK_FORMAT_D16_UNORM_S8_UINT ||
         format == VK_FORMAT_D24_UNORM_S8_UINT || format == VK_FORMAT_D32_SFLOAT_S8_UINT;
}

bool isDepthFormat(VkFormat format) {
  return format == VK_FORMAT_D16_UNORM || format == VK_FORMAT_X8_D24_UNORM_PACK32 ||
         format == VK_FORMAT_D32_SFLOAT || (isStencilFormat(format) && format != VK_FORMAT_S8_UINT);
}

// Returns the kernel of a draw with more layouts; those of the other one are its first.
const Kernel& layoutsOf(const KernelVariant& kernel, const KernelVariant* pixel) {
  const bool more =
      pixel != nullptr && pixel->kernel->layouts.size() > kernel.kernel->layouts.size();
  return more ? *pixel->kernel : *kernel.kernel;
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

// The parts of a pipeline that do not come from its shaders. Its structs point at each other.
struct FixedFunction {
  FixedFunction(const DrawState& state, const TargetFormats& target, const VertexInput* input);
  FixedFunction(const FixedFunction&) = delete;
  FixedFunction& operator=(const FixedFunction&) = delete;
  void fill(VkGraphicsPipelineCreateInfo& info) const;

  static constexpr VkDynamicState kDynamics[] = {VK_DYNAMIC_STATE_VIEWPORT,
                                                 VK_DYNAMIC_STATE_SCISSOR};
  VkVertexInputBindingDescription vertexBinding = {};
  std::vector<VkVertexInputAttributeDescription> attributes;
  VkPipelineVertexInputStateCreateInfo vertexInput = {};
  VkPipelineInputAssemblyStateCreateInfo assembly = {};
  VkPipelineViewportStateCreateInfo viewport = {};
  VkPipelineRasterizationStateCreateInfo raster = {};
  VkPipelineMultisampleStateCreateInfo multisample = {};
  VkPipelineDepthStencilStateCreateInfo depth = {};
  // The first one's, and that of others, which are not written.
  std::array<VkPipelineColorBlendAttachmentState, 1 + kMaxOtherColors> attachments = {};
  VkPipelineColorBlendStateCreateInfo blend = {};
  VkPipelineDynamicStateCreateInfo dynamic = {};
};

FixedFunction::FixedFunction(const DrawState& state, const TargetFormats& target,
                             const VertexInput* input) {
  vertexInput = tagged<VkPipelineVertexInputStateCreateInfo>(
      VK_STRUCTURE_TYPE_PIPELINE_VERTEX_INPUT_STATE_CREATE_INFO);
  if (input != nullptr) {
    vertexBinding.stride = input->stride;
    vertexBinding.inputRate =
        input->perInstance ? VK_VERTEX_INPUT_RATE_INSTANCE : VK_VERTEX_INPUT_RATE_VERTEX;
    for (const VertexAttribute& attribute : input->attributes)
      attributes.push_back({attribute.location, 0, formatOf(attribute.format), attribute.offset});
    vertexInput.vertexBindingDescriptionCount = 1;
    vertexInput.pVertexBindingDescriptions = &vertexBinding;
    vertexInput.vertexAttributeDescriptionCount = static_cast<uint32_t>(attributes.size());
    vertexInput.pVertexAttributeDescriptions = attributes.data();
  }
  assembly = tagged<VkPipelineInputAssemblyStateCreateInfo>(
      VK_STRUCTURE_TYPE_PIPELINE_INPUT_ASSEMBLY_STATE_CREATE_INFO);
  assembly.topology = primitiveTopology(state.topology);
  viewport = tagged<VkPipelineViewportStateCreateInfo>(
      VK_STRUCTURE_TYPE_PIPELINE_VIEWPORT_STATE_CREATE_INFO);
  viewport.viewportCount = 1;
  viewport.scissorCount = 1;
  raster = tagged<VkPipelineRasterizationStateCreateInfo>(
      VK_STRUCTURE_TYPE_PIPELINE_RASTERIZATION_STATE_CREATE_INFO);
  raster.polygonMode = VK_POLYGON_MODE_FILL;
  raster.cullMode = VK_CULL_MODE_NONE;
  raster.frontFace = VK_FRONT_FACE_COUNTER_CLOCKWISE;
  raster.lineWidth = 1;
  multisample = tagged<VkPipelineMultisampleStateCreateInfo>(
      VK_STRUCTURE_TYPE_PIPELINE_MULTISAMPLE_STATE_CREATE_INFO);
  multisample.rasterizationSamples = target.samples;
  depth = tagged<VkPipelineDepthStencilStateCreateInfo>(
      VK_STRUCTURE_TYPE_PIPELINE_DEPTH_STENCIL_STATE_CREATE_INFO);
  const bool hasDepth = target.depth != VK_FORMAT_UNDEFINED;
  depth.depthTestEnable =
      hasDepth && (state.depthCompare != DepthCompare::kAlways || state.depthWrite);
  depth.depthWriteEnable = hasDepth && state.depthWrite;
  depth.depthCompareOp = compareOp(state.depthCompare);
  // Without writes, as the others: devices without independentBlend want all to be equal.
  if (state.colorWrite) {
    VkPipelineColorBlendAttachmentState& first = attachments[0];
    first.colorWriteMask = VK_COLOR_COMPONENT_R_BIT | VK_COLOR_COMPONENT_G_BIT |
                           VK_COLOR_COMPONENT_B_BIT | VK_COLOR_COMPONENT_A_BIT;
    first.blendEnable = state.blend == BlendMode::kPremultipliedAlpha;
    first.srcColorBlendFactor = VK_BLEND_FACTOR_ONE;
    first.dstColorBlendFactor = VK_BLEND_FACTOR_ONE_MINUS_SRC_ALPHA;
    first.colorBlendOp = VK_BLEND_OP_ADD;
    first.srcAlphaBlendFactor = VK_BLEND_FACTOR_ONE;
    first.dstAlphaBlendFactor = VK_BLEND_FACTOR_ONE_MINUS_SRC_ALPHA;
    first.alphaBlendOp = VK_BLEND_OP_ADD;
  }
  blend = tagged<VkPipelineColorBlendStateCreateInfo>(
      VK_STRUCTURE_TYPE_PIPELINE_COLOR_BLEND_STATE_CREATE_INFO);
  blend.attachmentCount = 1 + target.otherColorCount;
  blend.pAttachments = attachments.data();
  dynamic = tagged<VkPipelineDynamicStateCreateInfo>(
      VK_STRUCTURE_TYPE_PIPELINE_DYNAMIC_STATE_CREATE_INFO);
  dynamic.dynamicStateCount = static_cast<uint32_t>(std::size(kDynamics));
  dynamic.pDynamicStates = kDynamics;
}

void FixedFunction::fill(VkGraphicsPipelineCreateInfo& info) const {
  info.pVertexInputState = &vertexInput;
  info.pInputAssemblyState = &assembly;
  info.pViewportState = &viewport;
  info.pRasterizationState = &raster;
  info.pMultisampleState = &multisample;
  info.pDepthStencilState = &depth;
  info.pColorBlendState = &blend;
  info.pDynamicState = &dynamic;
}

// A shader module for the time of a pipeline's creation.
class ShaderModule {
 public:
  ShaderModule(const Device& owner, VkShaderModule module, std::string entry)
      : device_(&owner), handle_(module), entryPoint_(std::move(entry)) {}
  ShaderModule(ShaderModule&& other) noexcept
      : device_(other.device_),
        handle_(std::exchange(other.handle_, VK_NULL_HANDLE)),
        entryPoint_(std::move(other.entryPoint_)) {}
  ShaderModule& operator=(ShaderModule&&) = delete;
  ~ShaderModule() {
    if (handle_ != VK_NULL_HANDLE)
      device_->vk.DestroyShaderModule(device_->handle, handle_, device_->callbacks);
  }

  VkPipelineShaderStageCreateInfo stage(VkShaderStageFlagBits flag,
                                        const VkSpecializationInfo& specialization) const {
    auto info = tagged<VkPipelineShaderStageCreateInfo>(
        VK_STRUCTURE_TYPE_PIPELINE_SHADER_STAGE_CREATE_INFO);
    info.stage = flag;
    info.module = handle_;
    info.pName = entryPoint_.c_str();
    info.pSpecializationInfo = &specialization;
    return info;
  }

 private:
  const Device* device_;
  VkShaderModule handle_;
  std::string entryPoint_;
};

Result<void> checkLimits(const Device& device, const Kernel& kernel) {
  const VkPhysicalDeviceLimits& limits = device.limits();
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

Result<void> checkTarget(const Device& device, const TargetFormats& target, const DrawState& state,
                         const std::string& draw) {
  const auto refuse = [&](ErrorCode code, const std::string& what) {
    return Error{code, "draw " + draw + ": " + what};
  };
  const uint32_t most = std::min(kMaxOtherColors + 1, device.limits().maxColorAttachments);
  if (target.otherColorCount >= most) {
    return refuse(ErrorCode::kInvalidArgument,
                  fmt::format("TargetFormats::otherColorCount is {}, but must be 0 to {}",
                              target.otherColorCount, most - 1));
  }
  if (target.otherColorCount > 0 && state.colorWrite && !device.features.independentBlend) {
    return refuse(
        ErrorCode::kUnsupported,
        "TargetFormats::otherColorCount above 0 needs the device feature independentBlend, "
        "which the device lacks or which was not enabled (RuntimeDef::enabledFeatures)");
  }
  if (target.renderPass != VK_NULL_HANDLE) return {};
  if (target.depth != VK_FORMAT_UNDEFINED && !isDepthFormat(target.depth)) {
    return refuse(ErrorCode::kInvalidArgument,
                  fmt::format("TargetFormats::depth is VkFormat {}, which has no depth",
                              static_cast<int>(target.depth)));
  }
  if (target.stencil == VK_FORMAT_UNDEFINED) return {};
  if (!isStencilFormat(target.stencil)) {
    return refuse(ErrorCode::kInvalidArgument,
                  fmt::format("TargetFormats::stencil is VkFormat {}, which has no stencil",
                              static_cast<int>(target.stencil)));
  }
  if (target.depth == VK_FORMAT_UNDEFINED || target.depth == target.stencil) return {};
  return refuse(ErrorCode::kInvalidArgument,
                fmt::format("TargetFormats::stencil is VkFormat {} and depth {}: with both, they "
                            "are one image, and its format is in both",
                            static_cast<int>(target.stencil), static_cast<int>(target.depth)));
}

// Facts about the kernel's code. Error: the device lacks a feature that it needs.
Result<SpirvFacts> factsOf(const Device& device, const KernelVariant& variant,
                           std::span<const uint32_t> words) {
  const VkShaderStageFlagBits stage = stageFlag(variant.kernel->stage);
  Result<SpirvFacts> facts = spirvFacts(words, stage, device);
  if (!facts) {
    return Error{facts.error().code,
                 fmt::format("kernel {}: {}", variantName(variant), facts.error().message)};
  }
  std::string missing = facts->missingFeature;
  for (const VariantBinding& use : variant.bindings) {
    if (!writes(use.access)) continue;
    if (stage == VK_SHADER_STAGE_VERTEX_BIT && !device.features.vertexPipelineStoresAndAtomics)
      missing = "the device feature vertexPipelineStoresAndAtomics";
    if (stage == VK_SHADER_STAGE_FRAGMENT_BIT && !device.features.fragmentStoresAndAtomics)
      missing = "the device feature fragmentStoresAndAtomics";
  }
  if (!missing.empty()) {
    return Error{ErrorCode::kUnsupported,
                 fmt::format("kernel {} needs {}, which the device lacks or which was not enabled "
                             "(RuntimeDef::enabledFeatures)",
                             variantName(variant), missing)};
  }
  return facts;
}

Result<ShaderModule> makeModule(const Device& device, const KernelCodes& codes,
                                const KernelVariant& variant) {
  const Result<std::vector<uint32_t>> words = codes.spirv(variant);
  if (!words) return words.error();
  Result<SpirvFacts> facts = factsOf(device, variant, *words);
  if (!facts) return facts.error();
  auto info = tagged<VkShaderModuleCreateInfo>(VK_STRUCTURE_TYPE_SHADER_MODULE_CREATE_INFO);
  info.codeSize = words->size() * sizeof(uint32_t);
  info.pCode = words->data();
  VkShaderModule handle = VK_NULL_HANDLE;
  const VkResult result =
      device.vk.CreateShaderModule(device.handle, &info, device.callbacks, &handle);
  if (result != VK_SUCCESS)
    return vulkanError(result, fmt::format("shader module of {}", variantName(variant)));
  return ShaderModule(device, handle, std::move(facts->entryPoint));
}

// A pipeline that is being made.
struct Job {
  std::vector<uint64_t> key;
  PipelineRequest request;
  VkPipelineLayout layout = VK_NULL_HANDLE;
  std::string name;
  std::optional<Result<VkPipeline>> result = std::nullopt;
  double milliseconds = 0;
};

void setKey(const PipelineRequest& request, std::vector<uint64_t>& key) {
  key.assign({pointerKey(request.kernel), pointerKey(request.pixel)});
  if (request.pixel != nullptr) {
    const DrawState& state = request.state;
    const TargetFormats& target = *request.target;
    key.insert(
        key.end(),
        {static_cast<uint64_t>(state.topology) | static_cast<uint64_t>(state.depthCompare) << 8 |
             static_cast<uint64_t>(state.depthWrite) << 16 |
             static_cast<uint64_t>(state.blend) << 24 |
             static_cast<uint64_t>(state.colorWrite) << 31 |
             static_cast<uint64_t>(target.samples) << 32,
         static_cast<uint64_t>(target.color) << 32 | static_cast<uint32_t>(target.depth),
         // NOLINTNEXTLINE: an integer on 32-bit platforms, a pointer on others
         (uint64_t)target.renderPass,
         static_cast<uint64_t>(target.stencil) << 32 | static_cast<uint32_t>(target.subpass),
         target.otherColorCount});
    for (uint32_t i = 0; i < std::min(target.otherColorCount, kMaxOtherColors); ++i)
      key.push_back(static_cast<uint64_t>(target.otherColors[i]));
  }
  appendKey(key, request.values);
}

// The name of a pipeline that the device can make.
Result<std::string> checkedName(const Device& device, const PipelineRequest& request) {
  std::string name = variantName(*request.kernel);
  if (Result<void> fits = pelage::checkLimits(*request.kernel, request.pixel, device.tierLimits,
                                              device.properties.deviceName);
      !fits)
    return fits.error();
  if (request.pixel != nullptr) {
    name += " + " + variantName(*request.pixel);
    if (Result<void> fits = checkTarget(device, *request.target, request.state, name); !fits)
      return fits.error();
    if (request.target->renderPass == VK_NULL_HANDLE && !device.vk.dynamicRendering) {
      return Error{ErrorCode::kUnsupported,
                   "draw " + name +
                       ": TargetFormats::renderPass is null and the device has no dynamic "
                       "rendering (Vulkan 1.3 or VK_KHR_dynamic_rendering): give a render pass"};
    }
  }
  return name;
}

Result<VkPipeline> createCompute(const Device& device, const KernelCodes& codes,
                                 VkPipelineCache cache, const Job& job) {
  Result<ShaderModule> shader = makeModule(device, codes, *job.request.kernel);
  if (!shader) return shader.error();
  const Specialization specialization(job.request.values);
  auto info = tagged<VkComputePipelineCreateInfo>(VK_STRUCTURE_TYPE_COMPUTE_PIPELINE_CREATE_INFO);
  info.stage = shader->stage(VK_SHADER_STAGE_COMPUTE_BIT, specialization.info);
  info.layout = job.layout;
  info.basePipelineIndex = -1;
  VkPipeline handle = VK_NULL_HANDLE;
  const VkResult result =
      device.vk.CreateComputePipelines(device.handle, cache, 1, &info, device.callbacks, &handle);
  if (result != VK_SUCCESS) return vulkanError(result, "pipeline of kernel " + job.name);
  return handle;
}

Result<VkPipeline> createGraphics(const Device& device, const KernelCodes& codes,
                                  VkPipelineCache cache, const Job& job) {
  const PipelineRequest& request = job.request;
  const TargetFormats& target = *request.target;
  Result<ShaderModule> vertexShader = makeModule(device, codes, *request.kernel);
  if (!vertexShader) return vertexShader.error();
  Result<ShaderModule> pixelShader = makeModule(device, codes, *request.pixel);
  if (!pixelShader) return pixelShader.error();

  const Specialization specialization(request.values);
  const VkPipelineShaderStageCreateInfo stages[] = {
      vertexShader->stage(VK_SHADER_STAGE_VERTEX_BIT, specialization.info),
      pixelShader->stage(VK_SHADER_STAGE_FRAGMENT_BIT, specialization.info)};
  const FixedFunction fixed(request.state, target, request.kernel->kernel->vertexInput);
  auto rendering =
      tagged<VkPipelineRenderingCreateInfo>(VK_STRUCTURE_TYPE_PIPELINE_RENDERING_CREATE_INFO);
  std::array<VkFormat, 1 + kMaxOtherColors> colors = {target.color};
  std::copy(target.otherColors.begin(), target.otherColors.end(), colors.begin() + 1);
  rendering.colorAttachmentCount = 1 + target.otherColorCount;
  rendering.pColorAttachmentFormats = colors.data();
  rendering.depthAttachmentFormat = target.depth;
  rendering.stencilAttachmentFormat = target.stencil;

  auto info = tagged<VkGraphicsPipelineCreateInfo>(VK_STRUCTURE_TYPE_GRAPHICS_PIPELINE_CREATE_INFO);
  if (target.renderPass == VK_NULL_HANDLE) info.pNext = &rendering;
  info.stageCount = static_cast<uint32_t>(std::size(stages));
  info.pStages = stages;
  fixed.fill(info);
  info.layout = job.layout;
  info.renderPass = target.renderPass;
  info.subpass = target.subpass;
  info.basePipelineIndex = -1;
  VkPipeline handle = VK_NULL_HANDLE;
  const VkResult result =
      device.vk.CreateGraphicsPipelines(device.handle, cache, 1, &info, device.callbacks, &handle);
  if (result != VK_SUCCESS) return vulkanError(result, "pipeline of draw " + job.name);
  return handle;
}

// Any number of threads at a time: the driver synchronises the cache.
Result<VkPipeline> create(const Device& device, const KernelCodes& codes, VkPipelineCache cache,
                          const Job& job) {
  return job.request.pixel != nullptr ? createGraphics(device, codes, cache, job)
                                      : createCompute(device, codes, cache, job);
}

}  // namespace

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

Result<VkPipelineLayout> Pipelines::layout(const Kernel& kernel) {
  std::vector<uint64_t> key;
  for (const LayoutTable* table : kernel.layouts) key.push_back(pointerKey(table));
  if (const auto known = layouts_.find(key); known != layouts_.end()) return known->second;

  if (Result<void> checked = checkLimits(device_, kernel); !checked) return checked.error();
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
  const auto index = layouts_.emplace(std::move(key), VK_NULL_HANDLE).first;
  const VkResult result =
      device_.vk.CreatePipelineLayout(device_.handle, &info, device_.callbacks, &index->second);
  if (result != VK_SUCCESS) {
    layouts_.erase(index);
    return vulkanError(result, fmt::format("pipeline layout of kernel {}", kernel.name));
  }
  device_.vk.name(device_.handle, VK_OBJECT_TYPE_PIPELINE_LAYOUT, index->second, kernel.name);
  return index->second;
}

Result<void> Pipelines::checkSupport(const KernelVariant& kernel,
                                     const KernelVariant* pixel) const {
  if (Result<void> fits =
          pelage::checkLimits(kernel, pixel, device_.tierLimits, device_.properties.deviceName);
      !fits)
    return fits;
  if (Result<void> fits = checkLimits(device_, layoutsOf(kernel, pixel)); !fits) return fits;
  for (const KernelVariant* variant : {&kernel, pixel}) {
    if (variant == nullptr) continue;
    const Result<std::vector<uint32_t>> words = codes_.spirv(*variant);
    if (!words) return words.error();
    if (const Result<SpirvFacts> facts = factsOf(device_, *variant, *words); !facts)
      return facts.error();
  }
  return {};
}

const Pipeline* Pipelines::find(const PipelineRequest& request) {
  setKey(request, key_);
  const auto known = pipelines_.find(key_);
  return known == pipelines_.end() ? nullptr : &known->second.pipeline;
}

Result<void> Pipelines::make(std::span<const PipelineRequest> requests) {
  std::vector<Job> jobs;
  std::optional<Error> error;
  for (const PipelineRequest& request : requests) {
    if (find(request) != nullptr) continue;
    if (std::any_of(jobs.begin(), jobs.end(), [this](const Job& job) { return job.key == key_; }))
      continue;
    Result<std::string> name = checkedName(device_, request);
    const Result<VkPipelineLayout> made =
        name ? layout(layoutsOf(*request.kernel, request.pixel)) : name.error();
    if (made) {
      jobs.push_back({key_, request, *made, *std::move(name)});
    } else if (!error) {
      error = made.error();
    }
  }

  std::atomic<size_t> next = 0;
  const auto work = [&] {
    using Clock = std::chrono::steady_clock;
    for (size_t i = next++; i < jobs.size(); i = next++) {
      const Clock::time_point start = Clock::now();
      jobs[i].result.emplace(guarded([&] { return create(device_, codes_, cache_, jobs[i]); }));
      jobs[i].milliseconds =
          std::chrono::duration<double, std::milli>(Clock::now() - start).count();
    }
  };
  const size_t most = threads_ != 0 ? threads_ : std::max(std::thread::hardware_concurrency(), 1u);
  {
    // The caller's thread works, too.
    std::vector<std::jthread> threads;
    for (size_t i = 1; i < std::min(most, jobs.size()); ++i) threads.emplace_back(work);
    work();
  }

  for (Job& job : jobs) {
    if (!*job.result) {
      if (!error) error = job.result->error();
      continue;
    }
    const VkPipeline handle = **job.result;
    const PipelineRequest& request = job.request;
    const VkRenderPass renderPass =
        request.target != nullptr ? request.target->renderPass : VkRenderPass{VK_NULL_HANDLE};
    pipelines_.emplace(std::move(job.key), Cached{{handle, job.layout}, renderPass});
    device_.vk.name(device_.handle, VK_OBJECT_TYPE_PIPELINE, handle, job.name.c_str());
    times_.push_back({std::move(job.name), job.milliseconds});
  }
  if (error) return *error;
  return {};
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
