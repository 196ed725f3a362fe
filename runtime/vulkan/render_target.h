// The target of the Vulkan headless device's render().
#pragma once

#include <map>
#include <utility>

#include "device.h"
#include "pelage/headless.h"
#include "pelage/vulkan.h"

namespace pelage::vulkan {

struct TargetImage {
  VkImage image = VK_NULL_HANDLE;
  VkDeviceMemory memory = VK_NULL_HANDLE;
  VkImageView view = VK_NULL_HANDLE;
};

struct TargetPasses {
  VkRenderPass clears = VK_NULL_HANDLE;
  VkRenderPass loads = VK_NULL_HANDLE;  // compatible with it; goes on drawing
};

/// Images and framebuffer, kept while the size stays; render passes, and so the pipelines that are
/// made for them, are kept for all sizes.
class RenderTarget {
 public:
  static constexpr VkFormat kColorFormat = VK_FORMAT_R16G16B16A16_SFLOAT;
  static constexpr VkFormat kFloat32Format = VK_FORMAT_R32G32B32A32_SFLOAT;
  static constexpr VkFormat kDepthFormat = VK_FORMAT_D32_SFLOAT;

  explicit RenderTarget(const Device& device) : device_(device) {}
  RenderTarget(const RenderTarget&) = delete;
  RenderTarget& operator=(const RenderTarget&) = delete;

  bool fits(const RenderTargetDef& def) const {
    return framebuffer_ != VK_NULL_HANDLE && def_.width == def.width && def_.height == def.height &&
           def_.samples == def.samples && def_.float32Color == def.float32Color;
  }
  static VkFormat formatOf(const RenderTargetDef& def) {
    return def.float32Color ? kFloat32Format : kColorFormat;
  }
  /// Replaces what there was; on an error nothing is left.
  Result<void> make(const RenderTargetDef& def);
  /// Before the device goes.
  void destroy();

  /// The one that clears: the pipelines of draws are made for it. One for each format and number of
  /// samples.
  VkRenderPass renderPass() const { return passes_.clears; }
  TargetFormats formats() const;
  /// Begins a render pass, which clears or loads what is there.
  void begin(VkCommandBuffer commands, const RenderTargetDef& def, bool clear) const;
  /// Copies the depth of an area to the front of a buffer, outside a render pass.
  void copyDepth(VkCommandBuffer commands, const VkRect2D& area, const BufferRange& range) const;
  /// Copies the colours, samples averaged, to the front of a buffer for the host.
  void copyColor(VkCommandBuffer commands, VkBuffer buffer) const;

 private:
  Result<void> makePasses(VkSampleCountFlagBits samples);
  void destroyImages();

  const Device& device_;
  RenderTargetDef def_;
  TargetImage color_;  // with one sample: what is read back
  TargetImage depth_;
  TargetImage resolve_;  // with more than one sample: what is read back
  std::map<std::pair<VkFormat, uint32_t>, TargetPasses> allPasses_;  // by color format and samples
  TargetPasses passes_;                                              // of the target that there is
  VkFramebuffer framebuffer_ = VK_NULL_HANDLE;
};

}  // namespace pelage::vulkan
