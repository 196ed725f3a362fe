// Prints the passes of a frame; no GPU is needed for it.
#include <pelage/scene.h>

#include <cstdio>

#include "make_hair.h"

int main(int argc, char** argv) {
  const auto asset = makeHair(argc, argv);
  if (!asset) return std::fprintf(stderr, "%s\n", asset.error().message.c_str()), 1;
  pelage::Scene scene;
  const auto hair = scene.addHair(*asset, {.name = "hair"});
  if (!hair) return std::fprintf(stderr, "%s\n", hair.error().message.c_str()), 1;

  auto frame = scene.simulate(1.0f / 60);
  if (!frame) return std::fprintf(stderr, "%s\n", frame.error().message.c_str()), 1;
  pelage::FrameExecutor executor;
  executor.update = [](const pelage::ResourceTable& table) -> pelage::Result<void> {
    std::printf("%u buffers, %.1f MB\n", table.count(),
                static_cast<double>(table.totalBytes()) / 1e6);
    return {};
  };
  executor.record = [](const pelage::FrameStep& step) -> pelage::Result<void> {
    for (const pelage::Pass& pass : step.list->passes)
      std::printf("%-24s %u barriers\n", pass.name, pass.barrierCount);
    return {};
  };
  executor.draw = [](const pelage::FrameStep&) -> pelage::Result<void> { return {}; };
  return frame->run(executor).ok() ? 0 : 1;
}
