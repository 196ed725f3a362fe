// The smallest program: hair on a head for one second, and where the tip of one strand went.
// Usage: pelage-hello [FILE.tfx]
#include <pelage/demo/groom.h>
#include <pelage/headless.h>
#include <pelage/scene.h>

#include <cstdio>
#include <cstring>

namespace {

template <class T>
bool good(const pelage::Result<T>& result) {
  if (!result) std::fprintf(stderr, "pelage-hello: error: %s\n", result.error().message.c_str());
  return result.ok();
}

pelage::Result<pelage::HairAsset> makeHair(int argc, char** argv) {
  if (argc > 1) return pelage::loadTfx(argv[1]);
  auto groom = pelage::generateGroom({.seed = 7, .strandCount = 500});
  if (!groom) return groom.error();
  return groom->hair;
}

}  // namespace

int main(int argc, char** argv) {
  if (argc > 1 && argv[1][0] == '-') return std::puts("usage: pelage-hello [FILE.tfx]") < 0;

  // 1. Guide hairs, with the rest data that the simulation needs.
  auto asset = makeHair(argc, argv);
  if (!good(asset) || !good(asset->process())) return 1;

  // 2. A scene: hair, buffers and passes as plain data, without any graphics API.
  pelage::Scene scene;
  const auto hair = scene.addHair(*asset, {.name = "hello"});
  if (!good(hair)) return 1;

  // 3. A device to run it on. An engine has one already: see docs/vulkan.md.
  const auto device = pelage::createHeadlessVulkan({});
  if (!good(device)) return 1;

  // 4. Frames: the scene writes one, the device runs it. frame->draw() would add a view.
  for (int i = 0; i < 60; ++i) {
    auto frame = scene.simulate(1.0f / 60);
    if (!good(frame) || !good((*device)->run(*frame))) return 1;
  }

  // 5. Positions lie in a buffer, [strand][vertex]; a renderer reads it where it is.
  const auto last = asset->verticesPerStrand - 1;
  const pelage::BufferId positions = scene.hair(*hair).buffers().positions;
  const auto bytes =
      (*device)->read(positions, last * sizeof(pelage::Float4), sizeof(pelage::Float4));
  if (!good(bytes)) return 1;
  pelage::Float4 tip;
  std::memcpy(&tip, bytes->data(), sizeof(tip));
  const pelage::Float4& start = asset->positions[last];
  std::printf("tip of strand 0: from (%.4f, %.4f, %.4f) to (%.4f, %.4f, %.4f) m\n", start.x,
              start.y, start.z, tip.x, tip.y, tip.z);
}
