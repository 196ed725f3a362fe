#include "spirv_facts.h"

#include <fmt/format.h>

namespace pelage::vulkan {
namespace {

// Numbers of the SPIR-V specification 1.3, sections 2.3, 3.31 and 3.32.
constexpr uint32_t kMagic = 0x07230203;
constexpr uint32_t kHeaderWords = 5;
constexpr uint32_t kOpEntryPoint = 15;
constexpr uint32_t kOpCapability = 17;

struct FeatureOfCapability {
  uint32_t capability;
  VkBool32 VkPhysicalDeviceFeatures::*feature;
  const char* name;
};

// Capabilities that a feature of Vulkan 1.0 stands for (Vulkan specification, appendix A.1).
constexpr FeatureOfCapability kFeatures[] = {
    {2, &VkPhysicalDeviceFeatures::geometryShader, "geometryShader"},
    {3, &VkPhysicalDeviceFeatures::tessellationShader, "tessellationShader"},
    {10, &VkPhysicalDeviceFeatures::shaderFloat64, "shaderFloat64"},
    {11, &VkPhysicalDeviceFeatures::shaderInt64, "shaderInt64"},
    {22, &VkPhysicalDeviceFeatures::shaderInt16, "shaderInt16"},
    {25, &VkPhysicalDeviceFeatures::shaderImageGatherExtended, "shaderImageGatherExtended"},
    {27, &VkPhysicalDeviceFeatures::shaderStorageImageMultisample, "shaderStorageImageMultisample"},
    {28, &VkPhysicalDeviceFeatures::shaderUniformBufferArrayDynamicIndexing,
     "shaderUniformBufferArrayDynamicIndexing"},
    {29, &VkPhysicalDeviceFeatures::shaderSampledImageArrayDynamicIndexing,
     "shaderSampledImageArrayDynamicIndexing"},
    {30, &VkPhysicalDeviceFeatures::shaderStorageBufferArrayDynamicIndexing,
     "shaderStorageBufferArrayDynamicIndexing"},
    {31, &VkPhysicalDeviceFeatures::shaderStorageImageArrayDynamicIndexing,
     "shaderStorageImageArrayDynamicIndexing"},
    {32, &VkPhysicalDeviceFeatures::shaderClipDistance, "shaderClipDistance"},
    {33, &VkPhysicalDeviceFeatures::shaderCullDistance, "shaderCullDistance"},
    {35, &VkPhysicalDeviceFeatures::sampleRateShading, "sampleRateShading"},
    {42, &VkPhysicalDeviceFeatures::shaderResourceMinLod, "shaderResourceMinLod"},
    {49, &VkPhysicalDeviceFeatures::shaderStorageImageExtendedFormats,
     "shaderStorageImageExtendedFormats"},
    {52, &VkPhysicalDeviceFeatures::sampleRateShading, "sampleRateShading"},
    {55, &VkPhysicalDeviceFeatures::shaderStorageImageReadWithoutFormat,
     "shaderStorageImageReadWithoutFormat"},
    {56, &VkPhysicalDeviceFeatures::shaderStorageImageWriteWithoutFormat,
     "shaderStorageImageWriteWithoutFormat"},
};

struct SubgroupCapability {
  uint32_t capability;
  VkSubgroupFeatureFlagBits operation;
  const char* name;
};

constexpr SubgroupCapability kSubgroups[] = {
    {61, VK_SUBGROUP_FEATURE_BASIC_BIT, "basic subgroup operations"},
    {62, VK_SUBGROUP_FEATURE_VOTE_BIT, "subgroup votes"},
    {63, VK_SUBGROUP_FEATURE_ARITHMETIC_BIT, "subgroup arithmetic"},
    {64, VK_SUBGROUP_FEATURE_BALLOT_BIT, "subgroup ballots"},
    {65, VK_SUBGROUP_FEATURE_SHUFFLE_BIT, "subgroup shuffles"},
    {66, VK_SUBGROUP_FEATURE_SHUFFLE_RELATIVE_BIT, "relative subgroup shuffles"},
    {67, VK_SUBGROUP_FEATURE_CLUSTERED_BIT, "clustered subgroup operations"},
    {68, VK_SUBGROUP_FEATURE_QUAD_BIT, "subgroup quad operations"},
};

}  // namespace

Result<SpirvFacts> spirvFacts(std::span<const uint32_t> words, VkShaderStageFlagBits stage,
                              const Device& device) {
  if (words.size() < kHeaderWords || words[0] != kMagic) {
    return Error{ErrorCode::kInvalidArgument, "the module does not begin as SPIR-V does"};
  }
  SpirvFacts facts;
  for (size_t at = kHeaderWords; at < words.size();) {
    const uint32_t length = words[at] >> 16;
    const uint32_t op = words[at] & 0xffffu;
    if (length == 0 || length > words.size() - at) {
      return Error{ErrorCode::kInvalidArgument,
                   fmt::format("the SPIR-V module is cut off in the instruction at word {}", at)};
    }
    if (op == kOpCapability && length >= 2) {
      const uint32_t capability = words[at + 1];
      for (const FeatureOfCapability& entry : kFeatures) {
        if (entry.capability == capability && device.features.*entry.feature == VK_FALSE)
          facts.missingFeature = fmt::format("the device feature {}", entry.name);
      }
      for (const SubgroupCapability& entry : kSubgroups) {
        if (entry.capability == capability &&
            ((device.subgroup.supportedOperations & entry.operation) == 0 ||
             (device.subgroup.supportedStages & stage) == 0))
          facts.missingFeature = entry.name;
      }
    } else if (op == kOpEntryPoint && length > 3) {
      // A string of SPIR-V: little-endian bytes, closed by a zero.
      for (size_t word = at + 3; word < at + length; ++word) {
        for (uint32_t shift = 0; shift < 32; shift += 8) {
          const char c = static_cast<char>(words[word] >> shift & 0xffu);
          if (c == '\0') return facts;
          facts.entryPoint.push_back(c);
        }
      }
    }
    at += length;
  }
  return Error{ErrorCode::kInvalidArgument, "the SPIR-V module has no entry point"};
}

}  // namespace pelage::vulkan
