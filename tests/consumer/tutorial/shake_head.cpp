// A head turns to and fro for a second; the hair comes after.
#include <pelage/headless.h>
#include <pelage/scene.h>
#include <pelage/skeleton.h>

#include <cmath>
#include <cstdio>
#include <cstring>

#include "make_hair.h"

template <class T>
bool failed(const pelage::Result<T>& result) {
  if (!result) std::fprintf(stderr, "%s\n", result.error().message.c_str());
  return !result;
}

int main(int argc, char** argv) {
  const auto asset = makeHair(argc, argv);
  pelage::Scene scene;
  if (failed(asset)) return 1;
  const auto hair = scene.addHair(*asset, {.name = "hair"});
  const auto device = pelage::createHeadlessVulkan({});
  if (failed(hair) || failed(device)) return 1;

  for (int i = 1; i <= 60; ++i) {
    const float angle = 0.5f * std::sin(0.2f * static_cast<float>(i));  // [rad] about y
    const pelage::AffineTransform bone =
        pelage::rigidTransform({0, std::sin(angle / 2), 0, std::cos(angle / 2)}, {});
    scene.hair(*hair).setBones({&bone, 1});  // from bind space to the world
    auto frame = scene.simulate(1.0f / 60);
    if (failed(frame) || failed((*device)->run(*frame))) return 1;
  }

  const auto bytes = (*device)->read(scene.hair(*hair).buffers().positions);
  if (failed(bytes)) return 1;
  pelage::Float4 tip;
  const size_t last = asset->verticesPerStrand - 1;
  std::memcpy(&tip, bytes->data() + last * sizeof(tip), sizeof(tip));
  std::printf("tip of strand 0: (%.3f, %.3f, %.3f) m\n", tip.x, tip.y, tip.z);
}
