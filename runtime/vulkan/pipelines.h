// Pipelines and pipeline layouts, made when a pass first needs them.
#pragma once

#include <span>
#include <unordered_map>
#include <vector>

#include "descriptors.h"
#include "device.h"
#include "pelage/pass_list.h"
#include "pelage/vulkan.h"

namespace pelage::vulkan {

struct Pipeline {
  VkPipeline handle = VK_NULL_HANDLE;
  VkPipelineLayout layout = VK_NULL_HANDLE;
};

/// "simulate_strands [wind=1]", for errors and debuggers.
std::string variantName(const KernelVariant& variant);

class Pipelines {
 public:
  Pipelines(const Device& device, Descriptors& descriptors);
  ~Pipelines();
  Pipelines(const Pipelines&) = delete;
  Pipelines& operator=(const Pipelines&) = delete;

  /// Takes the engine's cache, or makes one with the data of an earlier run.
  Result<void> openCache(VkPipelineCache engine, std::span<const std::byte> data);
  Result<std::vector<std::byte>> cacheData() const;

  Result<Pipeline> compute(const KernelVariant& variant, std::span<const SpecValue> values);
  Result<Pipeline> graphics(const KernelVariant& vertex, const KernelVariant& pixel,
                            std::span<const SpecValue> values, const DrawState& state,
                            const TargetFormats& target);
  /// Destroys the pipelines of a render pass.
  void forget(VkRenderPass renderPass);

 private:
  struct Cached {
    Pipeline pipeline;
    VkRenderPass renderPass = VK_NULL_HANDLE;
  };
  /// A shader module for the time of a pipeline's creation.
  struct Module;

  Result<VkPipelineLayout> layout(const Kernel& kernel);
  Result<void> checkLimits(const Kernel& kernel) const;
  Result<Module> module(const KernelVariant& variant) const;

  const Device& device_;
  Descriptors& descriptors_;
  VkPipelineCache cache_ = VK_NULL_HANDLE;
  bool ownsCache_ = false;
  std::unordered_map<std::vector<uint64_t>, Cached, WordsHash> pipelines_;
  std::unordered_map<std::vector<uint64_t>, VkPipelineLayout, WordsHash> layouts_;
  std::vector<uint64_t> key_;
};

}  // namespace pelage::vulkan
