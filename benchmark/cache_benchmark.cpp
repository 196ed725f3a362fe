// Loading assets: from the files of artists, and from a cache of the same assets. The assets are
// made here: 2,000 strands of 32 vertices with their bones, and a sphere of 20,000 triangles.
//
// Hair caches: the same strands as they swing, 48 frames at 24 frames per second to 0.1 mm; or a
// file of your own that PELAGE_HAIR_CACHE names. Bytes per second are those of the decoded floats.
#include <benchmark/benchmark.h>

#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <numbers>
#include <optional>

#include "pelage/asset_cache.h"
#include "pelage/hair_cache.h"

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

// Frames of a hair cache, and the file of them.
class HairFrames {
 public:
  HairFrames()
      : path(std::filesystem::temp_directory_path() / "pelage_cache_benchmark.pelagecache") {
    const char* own = std::getenv("PELAGE_HAIR_CACHE");
    if (own == nullptr) makeSwing();
    auto reader = HairCacheReader::open(own != nullptr ? own : path);
    if (!reader) return;
    def = reader->def();
    frames.resize(reader->frameCount());
    for (size_t f = 0; f < frames.size(); ++f) {
      frames[f].resize(reader->vertexCount());
      if (!reader->read(f, frames[f])) return;
    }
    good = !frames.empty() && write() > 0;
  }
  ~HairFrames() {
    std::error_code ignored;
    std::filesystem::remove(path, ignored);
  }
  // Returns the size of the file; 0 where it could not be written.
  uint64_t write(uint32_t threads = 1) const {
    auto writer = HairCacheWriter::create(path, def, threads);
    if (!writer) return 0;
    for (const auto& frame : frames)
      if (!writer->append(frame)) return 0;
    const uint64_t bytes = writer->byteCount();
    return writer->close() ? bytes : 0;
  }
  double vertices() const { return static_cast<double>(frames.size() * frames[0].size()); }

  std::filesystem::path path;
  HairCacheDef def;
  std::vector<std::vector<Float3>> frames;
  bool good = false;

 private:
  void makeSwing() {
    const HairAsset curls = makeCurls();
    def = {.name = "curls", .strandCount = kStrands, .verticesPerStrand = kVertices};
    for (int f = 0; f < 48; ++f) {
      const float time = static_cast<float>(f) / 24;
      auto& frame = frames.emplace_back();
      for (size_t i = 0; i < curls.positions.size(); ++i) {
        const Float4& p = curls.positions[i];
        const float strand = static_cast<float>(i / kVertices);
        const float swing = std::sin(4 * time + 0.1f * strand - 8 * p.y);
        frame.push_back({p.x - 0.3f * p.y * swing, p.y, p.z + 0.1f * time - p.y * swing * swing});
      }
    }
    (void)write();
    frames.clear();
  }
};

const HairFrames& hairFrames() {
  static const HairFrames made;
  return made;
}

void countHair(benchmark::State& state, double framesEach) {
  const HairFrames& hair = hairFrames();
  const double vertices = framesEach * static_cast<double>(hair.frames[0].size());
  state.SetBytesProcessed(
      static_cast<int64_t>(static_cast<double>(state.iterations()) * vertices * sizeof(Float3)));
  state.counters["bytes_per_vertex"] =
      static_cast<double>(std::filesystem::file_size(hair.path)) / hair.vertices();
}

void writeHairCache(benchmark::State& state) {
  const HairFrames& hair = hairFrames();
  if (!hair.good) return state.SkipWithError("there is no hair cache");
  for (auto _ : state)
    if (hair.write(static_cast<uint32_t>(state.range(0))) == 0)
      state.SkipWithError("writing failed");
  const double strandFrames =
      static_cast<double>(hair.def.strandCount) * static_cast<double>(hair.frames.size());
  state.counters["strands x frames"] =
      benchmark::Counter(strandFrames, benchmark::Counter::kIsIterationInvariantRate);
  countHair(state, static_cast<double>(hair.frames.size()));
}

// All frames in order, or one in the middle between two key frames.
void readFrames(benchmark::State& state, bool all) {
  const HairFrames& hair = hairFrames();
  if (!hair.good) return state.SkipWithError("there is no hair cache");
  auto reader = HairCacheReader::open(hair.path);
  if (!reader) return state.SkipWithError("the hair cache cannot be opened");
  std::vector<Float3> out(reader->vertexCount());
  const uint64_t count = hair.frames.size();
  const uint64_t middle = std::min<uint64_t>(hair.def.keyInterval / 2, count - 1);
  uint64_t frame = all ? 0 : middle;
  for (auto _ : state) {
    if (!reader->read(frame, out)) state.SkipWithError("reading failed");
    benchmark::DoNotOptimize(out.data());
    if (all) {
      frame = (frame + 1) % count;
    } else {
      // A frame elsewhere, so that the next one is sought.
      frame = frame == middle && count > 2 * hair.def.keyInterval ? middle + hair.def.keyInterval
                                                                  : middle;
    }
  }
  countHair(state, 1);
}
void playHairCache(benchmark::State& state) { readFrames(state, true); }
void seekHairCache(benchmark::State& state) { readFrames(state, false); }

BENCHMARK(parseHair)->Unit(benchmark::kMillisecond);
BENCHMARK(hairFromCache)->Unit(benchmark::kMillisecond);
BENCHMARK(parseMesh)->Unit(benchmark::kMillisecond);
BENCHMARK(parseAll)->Unit(benchmark::kMillisecond);
BENCHMARK(parseAndPrepareAll)->Unit(benchmark::kMillisecond);
BENCHMARK(allFromCache)->Unit(benchmark::kMillisecond);
BENCHMARK(writeHairCache)
    ->ArgName("threads")
    ->Arg(1)
    ->Arg(2)
    ->UseRealTime()
    ->Unit(benchmark::kMillisecond);
BENCHMARK(playHairCache)->Unit(benchmark::kMicrosecond);
BENCHMARK(seekHairCache)->Unit(benchmark::kMicrosecond);

}  // namespace
