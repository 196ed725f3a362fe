#include "barriers.h"

#include "descriptors.h"

namespace pelage::vulkan {

void BarrierBatch::add(const Barrier& barrier, const BarrierTarget& target) {
  VkPipelineStageFlags before = pipelineStages(barrier.beforeStages);
  VkPipelineStageFlags after = pipelineStages(barrier.afterStages);
  VkAccessFlags written = 0;
  VkAccessFlags next = 0;

  if (writes(barrier.before) && barrier.beforeStages != 0) written |= VK_ACCESS_SHADER_WRITE_BIT;
  if (barrier.beforeUpload) {
    before |= VK_PIPELINE_STAGE_TRANSFER_BIT;
    written |= VK_ACCESS_TRANSFER_WRITE_BIT;
  }
  if (barrier.beforeIndirect) before |= VK_PIPELINE_STAGE_DRAW_INDIRECT_BIT;
  if (barrier.beforeIndex || barrier.beforeVertex) before |= VK_PIPELINE_STAGE_VERTEX_INPUT_BIT;

  if (barrier.afterStages != 0) {
    if (reads(barrier.after)) next |= VK_ACCESS_SHADER_READ_BIT;
    if (writes(barrier.after)) next |= VK_ACCESS_SHADER_WRITE_BIT;
  }
  if (barrier.afterUpload) {
    after |= VK_PIPELINE_STAGE_TRANSFER_BIT;
    next |= VK_ACCESS_TRANSFER_WRITE_BIT;
  }
  if (barrier.afterIndirect) {
    after |= VK_PIPELINE_STAGE_DRAW_INDIRECT_BIT;
    next |= VK_ACCESS_INDIRECT_COMMAND_READ_BIT;
  }
  if (barrier.afterIndex) {
    after |= VK_PIPELINE_STAGE_VERTEX_INPUT_BIT;
    next |= VK_ACCESS_INDEX_READ_BIT;
  }
  if (barrier.afterVertex) {
    after |= VK_PIPELINE_STAGE_VERTEX_INPUT_BIT;
    next |= VK_ACCESS_VERTEX_ATTRIBUTE_READ_BIT;
  }

  before_ |= before;
  after_ |= after;
  // Reads leave nothing to make visible: a write after a read waits, and no more.
  if (written == 0) return;
  auto memory = tagged<VkBufferMemoryBarrier>(VK_STRUCTURE_TYPE_BUFFER_MEMORY_BARRIER);
  memory.srcAccessMask = written;
  memory.dstAccessMask = next;
  memory.srcQueueFamilyIndex = VK_QUEUE_FAMILY_IGNORED;
  memory.dstQueueFamilyIndex = VK_QUEUE_FAMILY_IGNORED;
  memory.buffer = target.buffer;
  memory.offset = target.offset;
  memory.size = target.size;
  barriers_.push_back(memory);
}

namespace {

// Stages and accesses of draws, which a queue without graphics does not have.
constexpr VkPipelineStageFlags kDrawStages = VK_PIPELINE_STAGE_VERTEX_INPUT_BIT |
                                             VK_PIPELINE_STAGE_VERTEX_SHADER_BIT |
                                             VK_PIPELINE_STAGE_FRAGMENT_SHADER_BIT;
constexpr VkAccessFlags kDrawAccess =
    VK_ACCESS_INDEX_READ_BIT | VK_ACCESS_VERTEX_ATTRIBUTE_READ_BIT;

}  // namespace

void BarrierBatch::record(const Device& device, VkCommandBuffer commands) {
  if (!device.draws()) {
    before_ &= ~kDrawStages;
    after_ &= ~kDrawStages;
    for (VkBufferMemoryBarrier& barrier : barriers_) barrier.dstAccessMask &= ~kDrawAccess;
  }
  if (before_ != 0 && after_ != 0) {
    device.vk.CmdPipelineBarrier(commands, before_, after_, 0, 0, nullptr,
                                 static_cast<uint32_t>(barriers_.size()), barriers_.data(), 0,
                                 nullptr);
  }
  before_ = 0;
  after_ = 0;
  barriers_.clear();
}

}  // namespace pelage::vulkan
