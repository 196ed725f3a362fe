// Measures the core on the CPU: deriving rest data, and writing a frame's pass list.
#include <benchmark/benchmark.h>

#include <cmath>

#include "pelage/hair_asset.h"
#include "pelage/random.h"
#include "pelage/scene.h"

namespace {

pelage::HairAsset makeCurls(uint32_t strands, uint32_t vertices) {
  pelage::HairAsset asset;
  asset.strandCount = strands;
  asset.verticesPerStrand = vertices;
  for (uint32_t s = 0; s < strands; ++s) {
    for (uint32_t v = 0; v < vertices; ++v) {
      const float t = 0.2f * static_cast<float>(v) / static_cast<float>(vertices);
      const float phase = 80 * t + static_cast<float>(s);
      asset.positions.push_back(
          {0.01f * std::cos(phase), -t, 0.01f * std::sin(phase), v < 2 ? 0.0f : 1.0f});
    }
  }
  return asset;
}

void processAsset(benchmark::State& state) {
  const pelage::HairAsset source = makeCurls(static_cast<uint32_t>(state.range(0)), 32);
  for (auto _ : state) {
    pelage::HairAsset asset = source;
    if (!asset.process()) state.SkipWithError("process() failed");
    benchmark::DoNotOptimize(asset.restVectors.data());
  }
  state.SetItemsProcessed(state.iterations() * state.range(0) * 32);
}
BENCHMARK(processAsset)->Arg(2228)->Arg(32640)->Unit(benchmark::kMillisecond);

void writePassList(benchmark::State& state) {
  pelage::HairAsset asset = makeCurls(64, 16);
  if (!asset.process()) state.SkipWithError("process() failed");
  const auto follow = asset.generateFollowHairs({.countPerGuide = 4});
  pelage::Scene scene;
  for (int64_t i = 0; i < state.range(0); ++i) {
    if (!scene.addHair(asset, {.followHairs = *follow})) state.SkipWithError("addHair() failed");
  }
  pelage::PassList list;
  const pelage::View view{.width = 64, .height = 64};
  for (auto _ : state) {
    if (!scene.simulate(1.0f / 60, list) || !scene.draw(view, {}, list))
      state.SkipWithError("no pass list");
    scene.finish(list);
    pelage::setDelivered(list.run);
    benchmark::DoNotOptimize(list.passes.data());
  }
  state.SetItemsProcessed(state.iterations() * state.range(0));
}
BENCHMARK(writePassList)->Arg(1)->Arg(16)->Arg(256)->Unit(benchmark::kMicrosecond);

}  // namespace
