#include "hair_renderer.h"

pelage::Result<void> HairRenderer::create(const pelage::vulkan::RuntimeDef& device) {
  auto runtime = pelage::vulkan::Runtime::create(device);
  if (!runtime) return runtime.error();
  runtime_.emplace(std::move(*runtime));
  return {};
}

pelage::Result<void> HairRenderer::record(uint64_t number, uint64_t completed, float seconds,
                                          const pelage::View& view,
                                          const pelage::vulkan::ViewTarget& target,
                                          VkCommandBuffer commands) {
  runtime_->beginFrame(number, completed);
  auto frame = scene.simulate(seconds);
  if (!frame) return frame.error();
  const pelage::Light sun = {.shadow = pelage::HairShadow::kDeep};
  if (auto drawn = frame->draw(view, {&sun, 1}); !drawn) return drawn.error();
  return runtime_->record(*frame, commands, {&target, 1});
}
