#include "stage/tile_inspection.h"

#include <algorithm>
#include <cstring>
#include <utility>

#include "stage/inspection_passes.h"
#include "viewer_kernels/kernels.h"

namespace viewer {

using namespace viewer_kernels;
using pelage::BufferId;
using pelage::BufferUsage;
using pelage::PassBuilder;
using pelage::PassList;
using pelage::Result;

void TileInspection::makeBuffers(pelage::ResourceTable& table, uint64_t tiles) {
  if (table.whole(counts_).size != tiles * sizeof(uint32_t)) {
    if (counts_ != BufferId::kInvalid) table.remove(counts_);
    counts_ = table.add(
        {.name = "tile counts", .size = tiles * sizeof(uint32_t), .stride = sizeof(uint32_t)});
  }
  if (summary_ != BufferId::kInvalid) return;
  summary_ = table.add({.name = "tile counts/summary",
                        .size = tile_counts::kTileWords * sizeof(uint32_t),
                        .stride = sizeof(uint32_t),
                        .usage = BufferUsage::kStorage | BufferUsage::kReadback});
}

Result<void> TileInspection::count(const pelage::TransparencyTiles& tiles, uint64_t pixels,
                                   const DrawValuesBindings& drawn,
                                   const TileCountsBindings& counts, PassList& list) {
  const uint64_t tileCount = uint64_t{tiles.columns} * tiles.rows;
  const auto add = [&](const auto& variant, uint64_t threads) {
    PassBuilder pass(list);
    dispatchOver(pass, variant, threads);
    return pass.finish(drawn, counts);
  };
  Result<void> done =
      add(clearTileCountsVariant({}), std::max<uint64_t>(tileCount, tile_counts::kTileWords));
  if (!done) return done;
  done = tiles.method == pelage::Transparency::kTiles ? add(countTileSegmentsVariant({}), tileCount)
                                                      : add(countTileNodesVariant({}), pixels);
  return done ? add(sumTileCountsVariant({}), tileCount) : done;
}

Result<void> TileInspection::draw(const InspectionLook& look, pelage::Scene& scene,
                                  const pelage::View& view, pelage::Frame& frame) {
  const pelage::TransparencyTiles tiles = scene.transparencyTiles();
  drew_ = tiles.tiles != BufferId::kInvalid;
  if (!drew_) return {};
  pelage::ResourceTable& table = scene.resources();
  makeBuffers(table, uint64_t{tiles.columns} * tiles.rows);
  const DrawValuesBindings drawn = {.drawValuesConstants = valuesOf(look, view, 2)};
  const bool lists = tiles.method == pelage::Transparency::kWindowed;
  TileCountsConstants constants = {};
  constants.tileColumns = tiles.columns;
  constants.tileCount = tiles.columns * tiles.rows;
  constants.tileWidth = view.width;
  constants.tileNodes = tiles.nodeCount;
  const TileCountsBindings counts = {
      .tileCountsConstants = constants,
      .tileWords = table.whole(tiles.tiles),
      .tileCounters = table.whole(tiles.counters),
      .tileHeads = table.whole(lists ? tiles.heads : tiles.tiles),
      .tileListNodes = table.whole(lists ? tiles.nodes : tiles.tiles),
      .tileCounts = table.whole(counts_),
      .tileSummary = table.whole(summary_)};
  PassList list;
  if (Result<void> done = count(tiles, uint64_t{view.width} * view.height, drawn, counts, list);
      !done)
    return done;
  PassBuilder show(list);
  show.draw(coveringVertexVariant({}), tilePixelVariant({}), overEverything(), 3, 1);
  if (Result<void> done = show.finish(drawn, counts); !done) return done;
  list.area = areaOf(view);
  if (const auto added = frame.addView(std::move(list)); !added) return added.error();
  return {};
}

Result<InspectionFigures> TileInspection::measure(const pelage::BufferReader& read) const {
  InspectionFigures figures;
  if (!drew_) return figures;
  const auto bytes = read(summary_);
  if (!bytes) return bytes.error();
  uint32_t words[tile_counts::kTileWords] = {};
  std::memcpy(words, bytes->data(), std::min(bytes->size(), sizeof(words)));
  figures.known = true;
  figures.largest = static_cast<float>(words[tile_counts::kTileMost]);
  figures.fragments = words[tile_counts::kTileTotal];
  figures.tiles = words[tile_counts::kTilesWithHair];
  figures.tilesWithoutRoom = words[tile_counts::kTilesWithoutRoom];
  return figures;
}

void TileInspection::clear(pelage::Scene& scene) {
  for (BufferId* buffer : {&counts_, &summary_}) {
    if (*buffer != BufferId::kInvalid) scene.resources().remove(*buffer);
    *buffer = BufferId::kInvalid;
  }
  drew_ = false;
}

}  // namespace viewer
