// Predicts which exact method is faster: a model of their times, fitted to
// benchmark/results/transparency_h100.csv. docs/oit_tiles.md says how well.
#include <algorithm>
#include <cmath>

#include "pelage/transparency.h"

namespace pelage {

namespace {

// Pixels with hair in a tile that has some, of 64: the mean of the rows, 27 to 31.
constexpr double kTilePixels = 28;
// Where less than this comes through, nothing is looked for: TransparencySettings::epsilon.
constexpr double kEpsilon = 0.5 / 255;
// A change of methods has to gain a fifth: buffers are made for it.
constexpr double kGain = 0.8;

// Lists [ms].
constexpr double kListVertex = 4.0e-6;   // placed and rasterised
constexpr double kListVisible = 7.8e-6;  // put into a list, found there, sorted and lit
// Tiles [ms].
constexpr double kTileVertex = 1.9e-7;     // placed and cut into slices
constexpr double kTileFragment = 1.55e-7;  // put into a list, and weighed
constexpr double kTileVisible = 9e-8;      // lit and added up
constexpr double kTilePasses = 0.045;      // clearing and adding up of tiles

// Whether numbers, and such that can be divided by.
bool isKnown(const TransparencyWork& work) {
  return work.fragments > 0 && std::isfinite(work.fragments) && work.tiles >= 1 &&
         std::isfinite(work.tiles);
}

}  // namespace

TransparencyWork refineWork(const TransparencyWork& predicted, Transparency method,
                            const TransparencyCounters& counters) {
  const bool counted = method == Transparency::kWindowed || method == Transparency::kTiles;
  if (!counted || !isKnown(predicted)) return predicted;
  if (counters.fragments == 0 || counters.tiles == 0) return predicted;
  TransparencyWork work = predicted;
  work.fragments = counters.fragments;
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
  cost.tiles = kTilePasses + kTileVertex * work.vertices + kTileFragment * work.fragments +
               kTileVisible * visible;
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
