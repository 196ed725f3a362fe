// Loading assets: from the files of artists, and from a cache of the same assets. The assets are
// made here: 2,000 strands of 32 vertices with their bones, and a sphere of 20,000 triangles.
#include <benchmark/benchmark.h>

#include <cmath>
#include <filesystem>
#include <numbers>
#include <optional>

#include "pelage/asset_cache.h"

namespace {

using namespace pelage;

constexpr uint32_t kStrands = 2000, kVertices = 32, kRings = 100;

HairAsset makeCurls() {
  HairAsset asset;
  asset.strandCount = kStrands;
  asset.verticesPerStrand = kVertices;
  for (uint32_t s = 0; s < kStrands; ++s) {
    for (uint32_t v = 0; v < kVertices; ++v) {
      const float t = 0.2f * static_cast<float>(v) / static_cast<float>(kVertices);
      const float phase = 80 * t + static_cast<float>(s);
      asset.positions.push_back(
          {0.01f * std::cos(phase), -t, 0.01f * std::sin(phase), v < 2 ? 0.0f : 1.0f});
    }
  }
  return asset;
}

BoneWeights makeWeights() {
  BoneWeights weights;
  weights.bones = {{0, "neck"}, {1, "head"}};
  for (uint32_t s = 0; s < kStrands; ++s) {
    const float share = static_cast<float>(s) / static_cast<float>(kStrands);
    weights.strands.push_back({{0, 1, 0, 0}, {share, 1 - share, 0, 0}});
  }
  return weights;
}

CollisionMesh makeSphere() {
  CollisionMesh mesh;
  mesh.bones = {{0, "neck"}, {1, "head"}};
  for (uint32_t i = 0; i <= kRings; ++i) {
    for (uint32_t j = 0; j < kRings; ++j) {
      const double theta = std::numbers::pi * i / kRings;
      const double phi = 2 * std::numbers::pi * j / kRings;
      const Float3 p = {static_cast<float>(std::sin(theta) * std::cos(phi)),
                        static_cast<float>(std::cos(theta)),
                        static_cast<float>(std::sin(theta) * std::sin(phi))};
      mesh.positions.push_back(p);
      mesh.normals.push_back(p);
      mesh.influences.push_back({{0, 1, 0, 0}, {0.25f, 0.75f, 0, 0}});
    }
  }
  for (uint32_t i = 0; i < kRings; ++i) {
    for (uint32_t j = 0; j < kRings; ++j) {
      const uint32_t a = i * kRings + j, b = i * kRings + (j + 1) % kRings;
      for (const uint32_t corner : {a, b, a + kRings, b, b + kRings, a + kRings})
        mesh.indices.push_back(corner);
    }
  }
  return mesh;
}

// The files, which go with the program.
class Files {
 public:
  Files() {
    const std::string prefix =
        (std::filesystem::temp_directory_path() / "pelage_cache_benchmark").string();
    hair = prefix + ".tfx";
    bones = prefix + ".tfxbone";
    mesh = prefix + ".tfxmesh";
    hairCache = prefix + "_hair.pelage";
    cache = prefix + ".pelage";
    AssetCache assets;
    assets.hairs.push_back({"curls", makeCurls(), makeWeights(), {}});
    good = saveTfx(assets.hairs[0].asset, hair).ok() &&
           saveTfxBone(*assets.hairs[0].bones, bones).ok() &&
           saveTfxMesh(makeSphere(), mesh).ok() && assets.hairs[0].asset.process().ok() &&
           saveAssetCache(assets, hairCache).ok();
    assets.meshes.push_back({"sphere", makeSphere()});
    good = good && saveAssetCache(assets, cache).ok();
  }
  ~Files() {
    for (const auto& path : {hair, bones, mesh, hairCache, cache}) {
      std::error_code ignored;
      std::filesystem::remove(path, ignored);
    }
  }
  std::filesystem::path hair, bones, mesh, hairCache, cache;
  bool good = false;
};

const Files& files() {
  static const Files made;
  return made;
}

template <class Function>
void measure(benchmark::State& state, Function&& loads) {
  if (!files().good) state.SkipWithError("the files could not be made");
  for (auto _ : state)
    if (!loads()) state.SkipWithError("loading failed");
}

bool loadHair() {
  auto asset = loadTfx(files().hair);
  const auto bones = loadTfxBone(files().bones);
  return asset && bones && asset->process();
}

bool loadMesh() { return loadTfxMesh(files().mesh).ok(); }

bool prepareMesh() {
  auto mesh = loadTfxMesh(files().mesh);
  return mesh && prepareCollider(*mesh);
}

void parseHair(benchmark::State& state) { measure(state, loadHair); }
void hairFromCache(benchmark::State& state) {
  measure(state, [] { return loadAssetCache(files().hairCache).ok(); });
}
void parseMesh(benchmark::State& state) { measure(state, loadMesh); }
void parseAll(benchmark::State& state) {
  measure(state, [] { return loadHair() && loadMesh(); });
}
void parseAndPrepareAll(benchmark::State& state) {
  measure(state, [] { return loadHair() && prepareMesh(); });
}
// Has what parseAndPrepareAll makes.
void allFromCache(benchmark::State& state) {
  measure(state, [] { return loadAssetCache(files().cache).ok(); });
}
BENCHMARK(parseHair)->Unit(benchmark::kMillisecond);
BENCHMARK(hairFromCache)->Unit(benchmark::kMillisecond);
BENCHMARK(parseMesh)->Unit(benchmark::kMillisecond);
BENCHMARK(parseAll)->Unit(benchmark::kMillisecond);
BENCHMARK(parseAndPrepareAll)->Unit(benchmark::kMillisecond);
BENCHMARK(allFromCache)->Unit(benchmark::kMillisecond);

}  // namespace
