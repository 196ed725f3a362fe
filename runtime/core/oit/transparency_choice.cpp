// Predicts which exact method is faster: a model of their times, fitted to
// benchmark/results/transparency_h200.csv. docs/oit_tiles.md says how well.
#include <algorithm>
#include <cmath>

#include "pelage/transparency.h"

namespace pelage {

namespace {

// Pixels with hair in a tile that has some, of 64: the mean of the rows, 27 to 31.
constexpr double kTilePixels = 28;
// Where less than this comes through, nothing is looked for: TransparencySettings::epsilon.
constexpr double kEpsilon = 0.5 / 255;
// Fragments that a pixel finds in one walk through its list, or its tile.
constexpr double kWindow = 8;
// A change of methods has to gain a fifth: buffers are made for it.
constexpr double kGain = 0.8;

// Lists [ms].
constexpr double kListVertex = 3.5e-6;   // placed and rasterised
constexpr double kListVisible = 7.8e-6;  // put into a list, found there, sorted and lit
// Tiles [ms].
constexpr double kTileVisible = 6.8e-7;    // lit
constexpr double kTileReference = 3.1e-7;  // that a tile walks past
constexpr double kTileWalk = 3.9e-4;       // the same in one tile: others run beside it
// Layers of the deepest pixels that count, over the mean.
constexpr double kDeepest = 3;

// Whether numbers, and such that can be divided by.
bool isKnown(const TransparencyWork& work) {
  return work.fragments > 0 && std::isfinite(work.fragments) && work.references > 0 &&
         std::isfinite(work.references) && work.tiles >= 1 && std::isfinite(work.tiles);
}

}  // namespace

TransparencyWork refineWork(const TransparencyWork& predicted, Transparency method,
                            const TransparencyCounters& counters) {
  const bool lists = method == Transparency::kWindowed;
  if ((!lists && method != Transparency::kTiles) || !isKnown(predicted)) return predicted;
  if (counters.fragments == 0 || counters.tiles == 0) return predicted;
  TransparencyWork work = predicted;
  const double factor = static_cast<double>(counters.fragments) /
                        (lists ? predicted.fragments : predicted.references);
  work.fragments *= factor;
  work.references *= factor;
  work.tiles = counters.tiles;
  return work;
}

TransparencyCost predictCost(const TransparencyWork& work) {
  if (!isKnown(work)) return {};
  // Layers differ from pixel to pixel: taken as an exponential distribution around the mean, of
  // which a pixel shows the first ones, until too little comes through.
  const double layers = work.fragments / (work.tiles * kTilePixels);
  const double alpha = std::clamp(work.alpha, 1e-3, 0.999);
  const double shown = std::log(kEpsilon) / std::log1p(-alpha);
  const double visible = work.fragments * -std::expm1(-shown / layers);
  TransparencyCost cost;
  cost.windowed = kListVertex * work.vertices + kListVisible * visible;
  // All tiles share the device, and the last one has to be waited for.
  const double walks = 1 + std::min(shown, kDeepest * layers) / kWindow;
  cost.tiles =
      kTileVisible * visible + walks * work.references * (kTileReference + kTileWalk / work.tiles);
  return cost;
}

Transparency chooseTransparency(const TransparencyWork& work, bool software, Transparency current) {
  if (software) return Transparency::kWindowed;
  const TransparencyCost cost = predictCost(work);
  if (current == Transparency::kTiles)
    return cost.windowed < kGain * cost.tiles ? Transparency::kWindowed : Transparency::kTiles;
  if (current == Transparency::kWindowed)
    return cost.tiles < kGain * cost.windowed ? Transparency::kTiles : Transparency::kWindowed;
  return cost.tiles < cost.windowed ? Transparency::kTiles : Transparency::kWindowed;
}

}  // namespace pelage
