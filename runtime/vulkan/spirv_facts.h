// Facts about a SPIR-V module that the runtime needs before a driver gets it.
#pragma once

#include <cstdint>
#include <span>
#include <string>

#include "device.h"

namespace pelage::vulkan {

struct SpirvFacts {
  std::string entryPoint;
  /// The first feature that the module needs and the device does not have; empty when it has all.
  std::string missingFeature;
};

/// Reads the module's capabilities and entry point; `stage` picks among subgroup capabilities.
/// Errors: not SPIR-V, or cut off; the message has the word's index.
Result<SpirvFacts> spirvFacts(std::span<const uint32_t> words, VkShaderStageFlagBits stage,
                              const Device& device);

}  // namespace pelage::vulkan
