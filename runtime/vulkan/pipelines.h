// Pipelines and pipeline layouts, made when a pass first needs them.
#pragma once

#include <span>
#include <unordered_map>
#include <vector>

#include "descriptors.h"
#include "device.h"
#include "pelage/kernel_code.h"
#include "pelage/list_check.h"
#include "pelage/pass_list.h"
#include "pelage/vulkan.h"
#include "spirv_facts.h"

namespace pelage::vulkan {

struct Pipeline {
  VkPipeline handle = VK_NULL_HANDLE;
  VkPipelineLayout layout = VK_NULL_HANDLE;
};

/// The request for a pass's pipeline.
struct PipelineRequest {
  const KernelVariant* kernel = nullptr;  ///< the compute kernel, or the vertex kernel of a draw
  const KernelVariant* pixel = nullptr;   ///< nullptr: a compute pass
  std::span<const SpecValue> values;
  DrawState state;
  const TargetFormats* target = nullptr;  ///< of a draw
};

class Pipelines {
 public:
  Pipelines(const Device& device, Descriptors& descriptors);
  ~Pipelines();
  Pipelines(const Pipelines&) = delete;
  Pipelines& operator=(const Pipelines&) = delete;

  /// Takes the engine's cache, or makes one with the data of an earlier run.
  Result<void> openCache(VkPipelineCache engine, std::span<const std::byte> data);
  Result<std::vector<std::byte>> cacheData() const;

  void addCode(KernelCodeList code) { codes_.add(code); }

  /// Whether the device has what a pipeline of these kernels needs, as far as it can be told
  /// without making it.
  Result<void> checkSupport(const KernelVariant& kernel, const KernelVariant* pixel) const;

  /// nullptr when there is none yet.
  const Pipeline* find(const PipelineRequest& request);
  /// Makes those that do not exist yet, several at a time. On an error, which is that of the first
  /// request that has one, the others exist.
  Result<void> make(std::span<const PipelineRequest> requests);
  /// \param threads  at most so many at a time; 0: as many as there are processors
  void setThreads(uint32_t threads) { threads_ = threads; }
  const std::vector<PipelineTime>& times() const { return times_; }
  /// Destroys the pipelines of a render pass.
  void forget(VkRenderPass renderPass);

 private:
  struct Cached {
    Pipeline pipeline;
    VkRenderPass renderPass = VK_NULL_HANDLE;
  };

  Result<VkPipelineLayout> layout(const Kernel& kernel);

  const Device& device_;
  Descriptors& descriptors_;
  KernelCodes codes_;
  VkPipelineCache cache_ = VK_NULL_HANDLE;
  bool ownsCache_ = false;
  std::unordered_map<std::vector<uint64_t>, Cached, WordsHash> pipelines_;
  std::unordered_map<std::vector<uint64_t>, VkPipelineLayout, WordsHash> layouts_;
  std::vector<PipelineTime> times_;
  uint32_t threads_ = 0;
  std::vector<uint64_t> key_;  // of the request at hand
};

}  // namespace pelage::vulkan
