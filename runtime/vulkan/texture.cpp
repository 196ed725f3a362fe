#include "texture.h"

#include <fmt/format.h>

#include <algorithm>

namespace pelage::vulkan {
namespace {

VkFormat formatOf(const TextureDef& def) {
  return def.channels == 1 ? VK_FORMAT_R32_SFLOAT : VK_FORMAT_R16G16B16A16_SFLOAT;
}

Error failed(VkResult result, const TextureDef& def) {
  return vulkanError(result, fmt::format("texture of {} x {} texels in {} layers", def.width,
                                         def.height, def.layers));
}

}  // namespace

Result<void> Texture::make(const Device& device, const TextureDef& def) {
  width_ = def.width;
  height_ = def.height;
  layers_ = def.layers;
  levels_ = def.mipLevels;
  texelBytes_ = def.channels == 1 ? sizeof(float) : 4 * sizeof(uint16_t);
  Result<void> made = makeImage(device, def);
  if (made) made = makeViewAndSampler(device, def);
  if (!made) destroy(device);
  return made;
}

Result<void> Texture::makeImage(const Device& device, const TextureDef& def) {
  const Functions& vk = device.vk;
  VkImageCreateInfo info = imageInfo(formatOf(def), def.width, def.height,
                                     VK_IMAGE_USAGE_SAMPLED_BIT | VK_IMAGE_USAGE_TRANSFER_DST_BIT);
  if (def.shape == TextureShape::kCube) info.flags = VK_IMAGE_CREATE_CUBE_COMPATIBLE_BIT;
  info.mipLevels = def.mipLevels;
  info.arrayLayers = def.layers;
  VkResult result = vk.CreateImage(device.handle, &info, nullptr, &image_);
  if (result != VK_SUCCESS) return failed(result, def);

  VkMemoryRequirements needs = {};
  vk.GetImageMemoryRequirements(device.handle, image_, &needs);
  auto memory = tagged<VkMemoryAllocateInfo>(VK_STRUCTURE_TYPE_MEMORY_ALLOCATE_INFO);
  memory.allocationSize = needs.size;
  // The first type that fits; a driver lists the faster ones of a kind first.
  while ((needs.memoryTypeBits >> memory.memoryTypeIndex & 1u) == 0) ++memory.memoryTypeIndex;
  result = vk.AllocateMemory(device.handle, &memory, nullptr, &memory_);
  if (result == VK_SUCCESS) result = vk.BindImageMemory(device.handle, image_, memory_, 0);
  if (result != VK_SUCCESS) return failed(result, def);
  return {};
}

Result<void> Texture::makeViewAndSampler(const Device& device, const TextureDef& def) {
  const Functions& vk = device.vk;
  auto view = tagged<VkImageViewCreateInfo>(VK_STRUCTURE_TYPE_IMAGE_VIEW_CREATE_INFO);
  view.image = image_;
  const bool plane = def.shape == TextureShape::kPlane;
  view.viewType = def.shape == TextureShape::kCube ? VK_IMAGE_VIEW_TYPE_CUBE
                  : plane                          ? VK_IMAGE_VIEW_TYPE_2D
                                                   : VK_IMAGE_VIEW_TYPE_2D_ARRAY;
  view.format = formatOf(def);
  view.subresourceRange = {VK_IMAGE_ASPECT_COLOR_BIT, 0, levels_, 0, layers_};
  VkResult result = vk.CreateImageView(device.handle, &view, nullptr, &view_);
  if (result != VK_SUCCESS) return failed(result, def);

  auto sampler = tagged<VkSamplerCreateInfo>(VK_STRUCTURE_TYPE_SAMPLER_CREATE_INFO);
  sampler.magFilter = def.channels == 1 ? VK_FILTER_NEAREST : VK_FILTER_LINEAR;
  sampler.minFilter = sampler.magFilter;
  sampler.mipmapMode =
      def.channels == 4 ? VK_SAMPLER_MIPMAP_MODE_LINEAR : VK_SAMPLER_MIPMAP_MODE_NEAREST;
  sampler.maxLod = static_cast<float>(levels_ - 1);
  sampler.addressModeU =
      plane ? VK_SAMPLER_ADDRESS_MODE_REPEAT : VK_SAMPLER_ADDRESS_MODE_CLAMP_TO_EDGE;
  sampler.addressModeV = sampler.addressModeU;
  sampler.addressModeW = sampler.addressModeU;
  result = vk.CreateSampler(device.handle, &sampler, nullptr, &sampler_);
  if (result != VK_SUCCESS) return failed(result, def);
  return {};
}

void Texture::fill(const Device& device, VkCommandBuffer commands, VkBuffer texels) const {
  const Functions& vk = device.vk;
  auto barrier = tagged<VkImageMemoryBarrier>(VK_STRUCTURE_TYPE_IMAGE_MEMORY_BARRIER);
  barrier.dstAccessMask = VK_ACCESS_TRANSFER_WRITE_BIT;
  barrier.oldLayout = VK_IMAGE_LAYOUT_UNDEFINED;
  barrier.newLayout = VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL;
  barrier.srcQueueFamilyIndex = VK_QUEUE_FAMILY_IGNORED;
  barrier.dstQueueFamilyIndex = VK_QUEUE_FAMILY_IGNORED;
  barrier.image = image_;
  barrier.subresourceRange = {VK_IMAGE_ASPECT_COLOR_BIT, 0, levels_, 0, layers_};
  vk.CmdPipelineBarrier(commands, VK_PIPELINE_STAGE_TOP_OF_PIPE_BIT, VK_PIPELINE_STAGE_TRANSFER_BIT,
                        0, 0, nullptr, 0, nullptr, 1, &barrier);
  VkBufferImageCopy copy = {};
  for (uint32_t level = 0; level < levels_; ++level) {
    copy.imageSubresource = {VK_IMAGE_ASPECT_COLOR_BIT, level, 0, layers_};
    copy.imageExtent = {std::max(width_ >> level, 1u), std::max(height_ >> level, 1u), 1};
    vk.CmdCopyBufferToImage(commands, texels, image_, VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL, 1,
                            &copy);
    copy.bufferOffset +=
        texelBytes_ * copy.imageExtent.width * copy.imageExtent.height * VkDeviceSize{layers_};
  }
  barrier.srcAccessMask = VK_ACCESS_TRANSFER_WRITE_BIT;
  barrier.dstAccessMask = VK_ACCESS_SHADER_READ_BIT;
  barrier.oldLayout = VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL;
  barrier.newLayout = VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL;
  vk.CmdPipelineBarrier(commands, VK_PIPELINE_STAGE_TRANSFER_BIT,
                        VK_PIPELINE_STAGE_ALL_COMMANDS_BIT, 0, 0, nullptr, 0, nullptr, 1, &barrier);
}

void Texture::destroy(const Device& device) {
  device.vk.DestroySampler(device.handle, sampler_, nullptr);
  device.vk.DestroyImageView(device.handle, view_, nullptr);
  device.vk.DestroyImage(device.handle, image_, nullptr);
  device.vk.FreeMemory(device.handle, memory_, nullptr);
  *this = {};
}

}  // namespace pelage::vulkan
