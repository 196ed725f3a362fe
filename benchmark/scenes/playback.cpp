#include "scenes/playback.h"

#include <fmt/format.h>
#include <unistd.h>

#include <chrono>
#include <cstring>
#include <system_error>
#include <utility>

namespace bench {

using pelage::Float3;
using pelage::Float4;
using pelage::HairObject;
using pelage::Result;

namespace {

constexpr double kFramesPerSecond = 60;

std::filesystem::path pathOf(const std::filesystem::path& folder, size_t hair) {
  return folder / fmt::format("{}.pelagecache", hair);
}

}  // namespace

Playback::~Playback() {
  players_.clear();
  writers_.clear();
  std::error_code ignored;
  if (!folder_.empty()) std::filesystem::remove_all(folder_, ignored);
}

Result<void> Playback::create(const sample::DemoScene& demo, pelage::Scene& scene) {
  std::string name = (std::filesystem::temp_directory_path() / "pelage-play-XXXXXX").string();
  if (::mkdtemp(name.data()) == nullptr)
    return pelage::Error{pelage::ErrorCode::kInvalidFile,
                         name + ": cannot be made, set TMPDIR to a folder that can be written"};
  folder_ = name;
  for (const pelage::HairId id : demo.hairs()) {
    const HairObject& hair = scene.hair(id);
    pelage::HairCacheDef def;
    def.strandCount = hair.guideCount();
    def.verticesPerStrand = hair.verticesPerStrand();
    def.framesPerSecond = kFramesPerSecond;
    auto writer = pelage::HairCacheWriter::create(pathOf(folder_, writers_.size()), def, 2);
    if (!writer) return writer.error();
    writers_.push_back(*std::move(writer));
  }
  return {};
}

Result<void> Playback::record(Workbench& workbench, const sample::DemoScene& demo) {
  if (writers_.empty())
    if (Result<void> done = create(demo, workbench.scene); !done) return done;
  for (size_t i = 0; i < writers_.size(); ++i) {
    const HairObject& hair = workbench.scene.hair(demo.hairs()[i]);
    std::vector<Float3> positions(uint64_t{hair.guideCount()} * hair.verticesPerStrand());
    const auto bytes =
        workbench.device.read(hair.buffers().positions, 0, positions.size() * sizeof(Float4));
    if (!bytes) return bytes.error();
    for (size_t vertex = 0; vertex < positions.size(); ++vertex)
      std::memcpy(&positions[vertex], bytes->data() + vertex * sizeof(Float4), sizeof(Float3));
    if (Result<void> done = writers_[i].append(positions); !done) return done;
  }
  return {};
}

Result<void> Playback::begin() {
  for (size_t i = 0; i < writers_.size(); ++i) {
    if (Result<void> done = writers_[i].close(); !done) return done;
    auto player = pelage::CachePlayer::open(pathOf(folder_, i), {.loops = true});
    if (!player) return player.error();
    players_.push_back(*std::move(player));
  }
  return {};
}

Result<double> Playback::show(pelage::Scene& scene, const sample::DemoScene& demo) {
  const auto start = std::chrono::steady_clock::now();
  for (size_t i = 0; i < players_.size(); ++i) {
    const uint64_t frame = shown_ % players_[i].frameCount();
    if (Result<void> done =
            players_[i].show(static_cast<double>(frame), scene.hair(demo.hairs()[i]));
        !done)
      return done.error();
  }
  ++shown_;
  return std::chrono::duration<double, std::micro>(std::chrono::steady_clock::now() - start)
      .count();
}

}  // namespace bench
