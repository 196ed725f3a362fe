// Strands as inputs of acceleration structures, linked as pkg-config or CMake say. Exits with 0
// when a frame has the pass that writes them, and its code is there.
#include <pelage/ray_tracing.h>
#include <pelage/scene.h>

#include <cstdio>

namespace {

int fail(const char* what) {
  std::fprintf(stderr, "rays: %s\n", what);
  return 1;
}

}  // namespace

int main() {
  pelage::HairAsset asset;
  asset.strandCount = 1;
  asset.verticesPerStrand = 16;
  for (uint32_t i = 0; i < asset.verticesPerStrand; ++i)
    asset.positions.push_back({0.02f * static_cast<float>(i), 0, 0, i < 2 ? 0.0f : 1.0f});
  if (const auto done = asset.process(); !done) return fail(done.error().message.c_str());
  pelage::Scene scene;
  const auto id = scene.addHair(asset, {.name = "strand"});
  if (!id) return fail(id.error().message.c_str());
  const pelage::HairObject& hair = scene.hair(*id);
  const auto rays = pelage::RayGeometry::create(scene.resources(), hair, {});
  if (!rays) return fail(rays.error().message.c_str());
  auto frame = scene.simulate(1.0f / 60);
  if (!frame) return fail(frame.error().message.c_str());
  pelage::PassList& list = frame->addList();
  if (const auto done = rays->addPass(hair, list); !done) return fail(done.error().message.c_str());
  if (list.passes.empty() || pelage::rayTracingCode().empty()) return fail("no pass, or no code");
  std::printf("rays: %u primitives\n", rays->primitiveCount());
  return rays->primitiveCount() == 15 ? 0 : fail("a segment has one swept sphere");
}
