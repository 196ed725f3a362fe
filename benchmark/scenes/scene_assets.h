// Assets of the scene benchmark. Each asset is made once and shared by rows.
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <utility>

#include "demo_assets.h"
#include "demo_scene.h"
#include "pelage/demo/character.h"
#include "pelage/result.h"
#include "simulation/bench_scene.h"

namespace bench {

class SceneAssets {
 public:
  /// \param quick  a coarser mesh of the head. \param data  folder that has ratboy/, or nothing
  explicit SceneAssets(bool quick, std::filesystem::path data = {})
      : quick_(quick), data_(std::move(data)) {}

  /// Generated hair of 32 vertices on a head that moves, as in the simulation benchmark.
  pelage::Result<const BenchScene*> freeHair(uint32_t strands);
  /// The sample's head and its groom. \param verticesPerStrand  0 for those of the sample
  pelage::Result<const sample::DemoAssets*> head(uint32_t guides, uint32_t verticesPerStrand = 0);
  /// The sample's character, its hair processed. \param guides  of the long hair; the other hair
  /// has as many times its default
  pelage::Result<const pelage::Character*> character(uint32_t guides);
  /// Whether the files of ratBoy() are there.
  bool hasRatBoy() const;
  /// AMD's Rat Boy, body and left hand, as scripts/ratboy.sh has him.
  pelage::Result<const sample::FileAssets*> ratBoy();

 private:
  std::filesystem::path ratBoyFile(const char* name) const { return data_ / "ratboy" / name; }

  bool quick_;
  std::filesystem::path data_;
  std::map<uint32_t, BenchScene> free_;
  std::map<std::pair<uint32_t, uint32_t>, sample::DemoAssets> heads_;
  std::map<uint32_t, pelage::Character> characters_;
  std::optional<sample::FileAssets> ratBoy_;
};

/// The sample's head as the baselines have it: hair on one rigid bone. Strands of 32 vertices.
pelage::Result<BenchScene> headOfBaseline(const sample::DemoAssets& head);

}  // namespace bench
