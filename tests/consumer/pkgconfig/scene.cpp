// A scene on the Vulkan runtime, linked as pkg-config says. It exits with 0 when a strand fell, or
// when there is no Vulkan device.
#include <pelage/headless.h>
#include <pelage/scene.h>

#include <cstdio>
#include <cstring>

namespace {

int fail(const char* what) {
  std::fprintf(stderr, "scene: %s\n", what);
  return 1;
}

}  // namespace

int main() {
  constexpr uint32_t kVertices = 16;
  pelage::HairAsset asset;
  asset.strandCount = 1;
  asset.verticesPerStrand = kVertices;
  // A horizontal strand, 30 cm long.
  for (uint32_t i = 0; i < kVertices; ++i)
    asset.positions.push_back({0.02f * static_cast<float>(i), 0, 0, i < 2 ? 0.0f : 1.0f});
  if (const auto done = asset.process(); !done) return fail(done.error().message.c_str());
  pelage::Scene scene;
  const auto hair = scene.addHair(asset, {.name = "strand"});
  if (!hair) return fail(hair.error().message.c_str());

  const auto device = pelage::createHeadlessVulkan({});
  if (!device) return std::printf("scene: skipped: %s\n", device.error().message.c_str()), 0;
  for (int i = 0; i < 30; ++i) {
    auto frame = scene.simulate(1.0f / 60);
    if (!frame) return fail(frame.error().message.c_str());
    if (const auto done = (*device)->run(*frame); !done) return fail(done.error().message.c_str());
  }
  const auto bytes =
      (*device)->read(scene.hair(*hair).buffers().positions,
                      (kVertices - 1) * sizeof(pelage::Float4), sizeof(pelage::Float4));
  if (!bytes) return fail(bytes.error().message.c_str());
  pelage::Float4 tip;
  std::memcpy(&tip, bytes->data(), sizeof(tip));
  std::printf("scene: the tip is at (%.4f, %.4f, %.4f) m\n", static_cast<double>(tip.x),
              static_cast<double>(tip.y), static_cast<double>(tip.z));
  return tip.y < -0.01f ? 0 : fail("the strand did not fall");
}
