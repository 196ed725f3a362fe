// Measures the core on the CPU: deriving rest data, and writing a frame's pass list.
#include <benchmark/benchmark.h>

#include <chrono>
#include <cmath>
#include <memory>

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

// Objects of the exact solver that move in wind and have a capsule each.
void addObjects(pelage::Scene& scene, int64_t count, benchmark::State& state) {
  pelage::HairAsset asset = makeCurls(64, 16);
  if (!asset.process()) state.SkipWithError("process() failed");
  const auto follow = asset.generateFollowHairs({.countPerGuide = 4});
  const auto shared = std::make_shared<const pelage::HairAsset>(asset);
  const pelage::CapsuleCollider capsule = {
      .head = {0, -0.1f, 0}, .headRadius = 0.01f, .tail = {0, -0.2f, 0}, .tailRadius = 0.01f};
  for (int64_t i = 0; i < count; ++i) {
    const auto id = scene.addHair(shared, {.followHairs = *follow});
    if (!id) return state.SkipWithError("addHair() failed");
    scene.hair(*id).settings.wind.velocity = {1, 0, 0};
    scene.hair(*id).setColliders({&capsule, 1});
  }
}

void writePassList(benchmark::State& state) {
  pelage::Scene scene;
  addObjects(scene, state.range(0), state);
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

// A Frame with a picture and a deep shadow, up to its barriers; the mean of each part beside it.
void writeFrame(benchmark::State& state) {
  using Clock = std::chrono::steady_clock;
  pelage::Scene scene;
  addObjects(scene, state.range(0), state);
  pelage::View view;
  view.width = view.height = 64;
  view.eye = {0, -0.1f, 1};
  view.worldToClip = pelage::lookAt(view.eye, {0, -0.1f, 0}, {0, 1, 0}, 1, 1, 0.1f, 5);
  const pelage::Light light = {.shadow = pelage::HairShadow::kDeep, .shadowSize = 64};
  Clock::duration simulated{}, drawn{}, finished{};
  for (auto _ : state) {
    const auto start = Clock::now();
    auto frame = scene.simulate(1.0f / 60);
    const auto afterSimulate = Clock::now();
    if (!frame || !frame->draw(view, {&light, 1}, {.method = pelage::Transparency::kTiles}))
      return state.SkipWithError("no frame");
    const auto afterDraw = Clock::now();
    if (!frame->finish()) return state.SkipWithError("no barriers");
    finished += Clock::now() - afterDraw;
    drawn += afterDraw - afterSimulate;
    simulated += afterSimulate - start;
    for (const pelage::FrameStep& step : frame->steps()) pelage::setDelivered(step.list->run);
  }
  const auto mean = [](Clock::duration sum) {
    return benchmark::Counter(std::chrono::duration<double, std::micro>(sum).count(),
                              benchmark::Counter::kAvgIterations);
  };
  state.counters["simulate_us"] = mean(simulated);
  state.counters["draw_us"] = mean(drawn);
  state.counters["finish_us"] = mean(finished);
}
BENCHMARK(writeFrame)->Arg(1)->Arg(100)->Unit(benchmark::kMicrosecond);

}  // namespace
