#include "pelage/hair_asset.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "assets/groom.h"
#include "base/guard.h"

namespace pelage {
namespace {

constexpr double kUsualLength = 0.2;  // m, of hair; fur has a tenth of it

struct Unit {
  const char* name;
  float scale;
  double rarity;  // as the logarithm of a factor on the length
};
constexpr Unit kUnits[] = {{"centimeters", 0.01f, 0},     {"millimeters", 0.001f, 0},
                           {"inches", 0.0254f, 1.4},      {"feet", 0.3048f, 1.4},
                           {"meters times 0.01", 100, 0}, {"meters times 0.001", 1000, 0}};

double distance(const Float4& a, const Float4& b) {
  return std::hypot(double{b.x} - a.x, double{b.y} - a.y, double{b.z} - a.z);
}

bool isPlausible(double meanLength) {  // false for NaN
  return meanLength >= kMinMeanLength && meanLength <= kMaxMeanLength;
}

Result<HairSize> measure(const HairAsset& asset) {
  if (auto r = validate(asset); !r) return r.error();
  HairSize size;
  const Float4& first = asset.positions.front();
  size.low = size.high = {first.x, first.y, first.z};
  double sum = 0;
  for (uint32_t strand = 0; strand < asset.strandCount; ++strand) {
    const Float4* const vertices =
        asset.positions.data() + size_t{strand} * asset.verticesPerStrand;
    double length = 0;
    for (uint32_t i = 0; i < detail::vertexCountOf(asset, strand); ++i) {
      const Float4& p = vertices[i];
      size.low = {std::min(size.low.x, p.x), std::min(size.low.y, p.y), std::min(size.low.z, p.z)};
      size.high = {std::max(size.high.x, p.x), std::max(size.high.y, p.y),
                   std::max(size.high.z, p.z)};
      if (i > 0) length += distance(vertices[i - 1], p);
    }
    sum += length;
    size.maxLength = std::max(size.maxLength, length);
  }
  size.meanLength = sum / asset.strandCount;
  return size;
}

}  // namespace

Result<HairSize> measureHair(const HairAsset& asset) {
  return detail::guarded([&] { return measure(asset); });
}

std::vector<UnitGuess> guessUnits(double meanLength) {
  std::vector<std::pair<double, UnitGuess>> guesses;
  if (isPlausible(meanLength)) return {};
  for (const Unit& unit : kUnits) {
    const double length = meanLength * double{unit.scale};
    if (isPlausible(length))
      guesses.push_back({std::abs(std::log(length / kUsualLength)) + unit.rarity,
                         {unit.name, unit.scale, length}});
  }
  std::stable_sort(guesses.begin(), guesses.end(),
                   [](const auto& a, const auto& b) { return a.first < b.first; });
  std::vector<UnitGuess> sorted;
  for (const auto& [unlikeliness, guess] : guesses) sorted.push_back(guess);
  return sorted;
}

std::string unitWarning(const HairSize& size) {
  if (isPlausible(size.meanLength)) return {};
  std::string text =
      fmt::format("the strands have a mean length of {:.3g} m; hair is {} than that",
                  size.meanLength, size.meanLength > kMaxMeanLength ? "shorter" : "longer");
  const std::vector<UnitGuess> guesses = guessUnits(size.meanLength);
  for (size_t i = 0; i < guesses.size(); ++i)
    text += fmt::format("{}{} (a scale of {:g} makes it {:.3g} m)",
                        i == 0                    ? ". Is it in "
                        : i + 1 == guesses.size() ? " or "
                                                  : ", ",
                        guesses[i].unit, guesses[i].scale, guesses[i].meanLength);
  return text + (guesses.empty() ? '.' : '?');
}

Result<void> scaleHair(HairAsset& asset, float scale) {
  if (!(scale >= 1e-9f && scale <= 1e9f))
    return Error{ErrorCode::kInvalidArgument,
                 fmt::format("the scale is {}; it must be 1e-9 to 1e9", scale)};
  for (size_t i = 0; i < asset.positions.size(); ++i) {
    const Float4& p = asset.positions[i];
    for (const float value : {p.x, p.y, p.z})
      if (!(std::abs(value * scale) <= kMaxCoordinate))
        return Error{ErrorCode::kInvalidArgument,
                     fmt::format("vertex {} has the coordinate {} once scaled by {}; it must be "
                                 "within +-1e6",
                                 i, value * scale, scale)};
  }
  for (Float4& p : asset.positions) p = {p.x * scale, p.y * scale, p.z * scale, p.w};
  detail::clearRestData(asset);
  return {};
}

}  // namespace pelage
