#include "scenes/characters.h"

#include <utility>

namespace bench {

using pelage::Result;
using sample::DemoScene;

namespace {

constexpr uint32_t kRow = 4;
constexpr float kSpacing = 0.7f;  // [m]
constexpr double kPhase = 0.37;   // of a character behind the one before it [s]

}  // namespace

Result<std::vector<DemoScene>> makeCharacters(const pelage::Character& character,
                                              sample::DemoDef def, uint32_t count) {
  std::vector<DemoScene> demos;
  for (uint32_t i = 0; i < count; ++i) {
    // In the gaps of the row in front; the first one stands in the middle.
    const uint32_t row = i / kRow, at = (i + 1) % kRow;
    const float shift = row % 2 == 0 ? 1.0f : 1.5f;
    def.place = {kSpacing * (static_cast<float>(at) - shift), 0,
                 -kSpacing * static_cast<float>(row)};
    auto demo = DemoScene::create(character, def);
    if (!demo) return demo.error();
    demos.push_back(*std::move(demo));
  }
  if (count == 1) return demos;
  for (const DemoScene& demo : demos)
    for (const pelage::HairId id : demo.hairs())
      def.scene->hair(id).setMeshColliders(demo.colliders());
  return demos;
}

Result<void> advanceAll(std::span<DemoScene> demos, pelage::PassList& list) {
  const double seconds = (demos[0].frame() + 1) * DemoScene::kFrameSeconds;
  for (size_t i = 1; i < demos.size(); ++i)
    demos[i].pose(seconds + kPhase * static_cast<double>(i));
  return demos[0].advance(list);
}

}  // namespace bench
