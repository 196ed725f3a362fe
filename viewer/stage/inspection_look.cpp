#include "stage/inspection_look.h"

#include <fmt/format.h>

#include <algorithm>

namespace viewer {

using pelage::Float3;

const ColorRamp kSignedRamp = {{{{0.01f, 0.06f, 0.60f},
                                 {0.06f, 0.25f, 0.50f},
                                 {0.35f, 0.35f, 0.35f},
                                 {0.60f, 0.22f, 0.03f},
                                 {0.60f, 0.02f, 0.01f}}}};
const ColorRamp kDepthRamp = {{{{0.12f, 0.13f, 0.14f},
                                {0.45f, 0.35f, 0.04f},
                                {0.60f, 0.26f, 0.01f},
                                {0.60f, 0.08f, 0.01f},
                                {0.60f, 0.005f, 0.02f}}}};
const ColorRamp kCountRamp = {{{{0.01f, 0.01f, 0.10f},
                                {0.01f, 0.10f, 0.45f},
                                {0.02f, 0.45f, 0.15f},
                                {0.60f, 0.50f, 0.02f},
                                {0.60f, 0.02f, 0.01f}}}};
const ColorRamp kKindRamp = {{{{0.05f, 0.09f, 0.16f},
                               {0.05f, 0.09f, 0.16f},
                               {0.05f, 0.09f, 0.16f},
                               {0.60f, 0.25f, 0.02f},
                               {0.60f, 0.25f, 0.02f}}}};
const ColorRamp kDetailRamp = {{{{0.03f, 0.06f, 0.22f},
                                 {0.05f, 0.24f, 0.30f},
                                 {0.10f, 0.50f, 0.14f},
                                 {0.50f, 0.36f, 0.03f},
                                 {0.60f, 0.10f, 0.01f}}}};

Float3 colorAt(const ColorRamp& ramp, float low, float high, float value) {
  const float share = (value - low) / (high - low);
  const size_t last = ramp.colors.size() - 1;
  const float at = share > 0 ? std::min(share, 1.0f) * static_cast<float>(last) : 0;
  const size_t first = std::min(static_cast<size_t>(at), last - 1);
  const Float3 &a = ramp.colors[first], &b = ramp.colors[first + 1];
  const float t = at - static_cast<float>(first);
  return {a.x + (b.x - a.x) * t, a.y + (b.y - a.y) * t, a.z + (b.z - a.z) * t};
}

void InspectionLook::show(bool back) {
  const int step = back ? kInspectedValues - 1 : 1;
  value = static_cast<InspectedValue>((static_cast<int>(value) + step) % kInspectedValues);
}

bool drawsHair(InspectedValue value) {
  return !hasPasses(value) || value == InspectedValue::kTiles;
}

bool hasPasses(InspectedValue value) {
  return value != InspectedValue::kNone && value != InspectedValue::kSdfSurface;
}

bool drawsMeshes(InspectedValue value) {
  return value != InspectedValue::kSdfSurface && value != InspectedValue::kSdfSlice;
}

const char* nameOf(InspectedValue value) {
  constexpr const char* kNames[kInspectedValues] = {"hair",      "stretch", "penetration",
                                                    "overdraw",  "tiles",   "SDF surface",
                                                    "SDF slice", "guides",  "level of detail"};
  return kNames[static_cast<size_t>(value)];
}

float highOf(const InspectionLook& look) {
  switch (look.value) {
    case InspectedValue::kStretch:
      return look.stretchRange;
    case InspectedValue::kPenetration:
      return look.penetrationRange;
    case InspectedValue::kOverdraw:
      return look.overdrawRange;
    case InspectedValue::kTiles:
      return look.tileRange;
    case InspectedValue::kSdfSlice:
      return look.sliceRange;
    case InspectedValue::kDetail:
      return 2;  // strand_detail::kDetailInterpolated
    default:
      return 1;
  }
}

float lowOf(const InspectionLook& look) {
  const bool isSigned =
      look.value == InspectedValue::kStretch || look.value == InspectedValue::kSdfSlice;
  return isSigned ? -highOf(look) : 0;
}

namespace {

void addVertices(const InspectionFigures& figures, const std::string& range, InspectionKey& key) {
  key.lines.push_back(
      fmt::format("{} of {} vertices beyond {}", figures.beyond, figures.measured, range));
  if (figures.notFinite > 0)
    key.lines.push_back(fmt::format("{} vertices are not finite", figures.notFinite));
}

InspectionKey stretchKey(const InspectionLook& look, const InspectionFigures& figures) {
  const float percent = 100 * look.stretchRange;
  InspectionKey key = {"Stretch of guides",
                       &kSignedRamp,
                       fmt::format("-{:.3g} %", percent),
                       "0",
                       fmt::format("+{:.3g} %", percent),
                       {}};
  if (!figures.known) return key;
  key.lines.push_back(fmt::format("largest {:.3g} %", 100 * figures.largest));
  addVertices(figures, fmt::format("{:.3g} %", percent), key);
  return key;
}

InspectionKey penetrationKey(const InspectionLook& look, const InspectionFigures& figures) {
  const float millimeters = 1000 * look.penetrationRange;
  InspectionKey key = {"Depth in colliders",
                       &kDepthRamp,
                       "0",
                       fmt::format("{:.3g}", millimeters / 2),
                       fmt::format("{:.3g} mm", millimeters),
                       {}};
  if (!figures.known) return key;
  key.lines.push_back(fmt::format("deepest {:.3g} mm", 1000 * figures.largest));
  addVertices(figures, key.high, key);
  return key;
}

InspectionKey overdrawKey(const InspectionLook& look, const InspectionFigures& figures) {
  InspectionKey key = {"Fragments a pixel",
                       &kCountRamp,
                       "0",
                       fmt::format("{:.3g}", look.overdrawRange / 2),
                       fmt::format("{:.3g}", look.overdrawRange),
                       {}};
  if (!figures.known) return key;
  const double mean = figures.pixels > 0 ? static_cast<double>(figures.fragments) /
                                               static_cast<double>(figures.pixels)
                                         : 0;
  key.lines.push_back(fmt::format("most {:.0f}, mean {:.3g}", figures.largest, mean));
  key.lines.push_back(fmt::format("{} fragments, {} pixels", figures.fragments, figures.pixels));
  return key;
}

InspectionKey tilesKey(const InspectionLook& look, const InspectionFigures& figures,
                       pelage::Transparency method) {
  if (method != pelage::Transparency::kTiles && method != pelage::Transparency::kWindowed)
    return {"Tiles",
            nullptr,
            {},
            {},
            {},
            {"This method sorts nothing into tiles: choose windowed or tiles to see how full they "
             "are."}};
  InspectionKey key = {"Fragments a tile of 8 x 8 pixels",
                       &kCountRamp,
                       "0",
                       fmt::format("{:.3g}", look.tileRange / 2),
                       fmt::format("{:.5g}", look.tileRange),
                       {}};
  if (!figures.known) return key;
  const uint64_t filled = figures.tiles - figures.tilesWithoutRoom;
  const double mean =
      filled > 0 ? static_cast<double>(figures.fragments) / static_cast<double>(filled) : 0;
  key.lines.push_back(fmt::format("fullest tile {:.0f}, mean {:.3g}", figures.largest, mean));
  key.lines.push_back(fmt::format("{} tiles with hair", figures.tiles));
  if (figures.tilesWithoutRoom > 0)
    key.lines.push_back(
        fmt::format("{} of them empty for lack of room (striped)", figures.tilesWithoutRoom));
  return key;
}

InspectionKey detailKey(const InspectionFigures& figures) {
  InspectionKey key = {"Level of detail", &kDetailRamp, "left out", "drawn", "not simulated", {}};
  if (!figures.known) return key;
  key.lines.push_back(fmt::format("{} of {} strands drawn, {} fade", figures.drawn, figures.strands,
                                  figures.fading));
  key.lines.push_back(fmt::format("{:.3g} times as wide as without", figures.widening));
  key.lines.push_back(fmt::format("{} of {} guides simulated", figures.simulated, figures.guides));
  return key;
}

}  // namespace

InspectionKey inspectionKey(const InspectionLook& look, const InspectionFigures& figures,
                            pelage::Transparency method) {
  const float millimeters = 1000 * look.sliceRange;
  switch (look.value) {
    case InspectedValue::kStretch:
      return stretchKey(look, figures);
    case InspectedValue::kPenetration:
      return penetrationKey(look, figures);
    case InspectedValue::kOverdraw:
      return overdrawKey(look, figures);
    case InspectedValue::kTiles:
      return tilesKey(look, figures, method);
    case InspectedValue::kSdfSlice:
      return {"Distance from colliders",
              &kSignedRamp,
              fmt::format("-{:.3g} mm", millimeters),
              "0",
              fmt::format("+{:.3g} mm", millimeters),
              {fmt::format("a line every {:.3g} mm; < 0 inside", millimeters / 4)}};
    case InspectedValue::kGuides:
      return {"Kind of strand", &kKindRamp, "follow hair", "", "guide", {}};
    case InspectedValue::kDetail:
      return detailKey(figures);
    default:
      return {};
  }
}

}  // namespace viewer
