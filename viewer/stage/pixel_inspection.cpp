#include "stage/pixel_inspection.h"

#include <algorithm>
#include <utility>

#include "stage/inspection_passes.h"
#include "viewer_kernels/kernels.h"

namespace viewer {

using namespace viewer_kernels;
using pelage::BufferId;
using pelage::BufferUsage;
using pelage::PassBuilder;
using pelage::PassList;
using pelage::ResourceTable;
using pelage::Result;
using pelage::View;

void PixelCounts::make(const std::string& name, uint64_t count, uint64_t words,
                       ResourceTable& table) {
  if (table.whole(counts_).size != count * sizeof(uint32_t)) {
    if (counts_ != BufferId::kInvalid) table.remove(counts_);
    counts_ =
        table.add({.name = name, .size = count * sizeof(uint32_t), .stride = sizeof(uint32_t)});
  }
  if (isMade()) return;
  words_ = words;
  summary_ = table.add({.name = name + "/summary",
                        .size = words * sizeof(uint32_t),
                        .stride = sizeof(uint32_t),
                        .usage = BufferUsage::kStorage | BufferUsage::kReadback});
}

Result<std::vector<uint32_t>> PixelCounts::readSummary(const pelage::BufferReader& read) const {
  const auto bytes = read(summary_);
  if (!bytes) return bytes.error();
  std::vector<uint32_t> words = wordsOf(*bytes);
  words.resize(words_);
  return words;
}

void PixelCounts::clear(pelage::Scene& scene) {
  for (BufferId* buffer : {&counts_, &summary_}) {
    if (*buffer != BufferId::kInvalid) scene.resources().remove(*buffer);
    *buffer = BufferId::kInvalid;
  }
}

Result<void> OverdrawInspection::draw(const InspectionLook& look, const Inspected& what,
                                      const View& view, StrandInspection& strands,
                                      pelage::Frame& frame) {
  ResourceTable& table = what.scene->resources();
  const uint64_t pixels = uint64_t{view.width} * view.height;
  counts_.make("overdraw", pixels, overdraw::kOverdrawWords, table);
  const DrawValuesBindings drawn = {.drawValuesConstants = valuesOf(look, view, 2)};
  const OverdrawBindings counters = {.overdraw = table.whole(counts_.counts()),
                                     .overdrawSummary = table.whole(counts_.summary())};
  PassList counting, showing;
  PassBuilder clear(counting);
  dispatchOver(clear, clearOverdrawVariant({}),
               std::max<uint64_t>(pixels, overdraw::kOverdrawWords));
  if (Result<void> done = clear.finish(drawn, counters); !done) return done;
  if (Result<void> done = strands.draw(look, what, view, &counters, counting); !done) return done;
  counting.area = showing.area = areaOf(view);
  if (const auto added = frame.addView(std::move(counting)); !added) return added.error();

  PassBuilder sum(showing);
  dispatchOver(sum, sumOverdrawVariant({}), pixels);
  if (Result<void> done = sum.finish(drawn, counters); !done) return done;
  PassBuilder show(showing);
  show.draw(coveringVertexVariant({}), overdrawPixelVariant({}), overEverything(), 3, 1);
  if (Result<void> done = show.finish(drawn, counters); !done) return done;
  if (const auto added = frame.addView(std::move(showing)); !added) return added.error();
  return {};
}

Result<InspectionFigures> OverdrawInspection::measure(const pelage::BufferReader& read) const {
  InspectionFigures figures;
  if (!counts_.isMade()) return figures;
  const auto words = counts_.readSummary(read);
  if (!words) return words.error();
  figures.known = true;
  figures.largest = static_cast<float>((*words)[overdraw::kOverdrawMost]);
  figures.pixels = (*words)[overdraw::kOverdrawPixels];
  figures.fragments = (*words)[overdraw::kOverdrawTotal];
  return figures;
}

namespace {

Result<void> countTiles(const pelage::TransparencyTiles& tiles, uint64_t pixels,
                        const DrawValuesBindings& drawn, const TileCountsBindings& counts,
                        PassList& list) {
  const uint64_t tileCount = uint64_t{tiles.columns} * tiles.rows;
  const auto add = [&](const auto& variant, uint64_t threads) {
    PassBuilder pass(list);
    dispatchOver(pass, variant, threads);
    return pass.finish(drawn, counts);
  };
  Result<void> done =
      add(clearTileCountsVariant({}), std::max<uint64_t>(tileCount, tile_counts::kTileWords));
  if (!done) return done;
  done = tiles.method == pelage::Transparency::kTiles
             ? add(countTileFragmentsVariant({}), tileCount)
             : add(countTileNodesVariant({}), pixels);
  return done ? add(sumTileCountsVariant({}), tileCount) : done;
}

}  // namespace

Result<void> TileInspection::draw(const InspectionLook& look, pelage::Scene& scene,
                                  const pelage::View& view, pelage::Frame& frame) {
  const pelage::TransparencyTiles tiles = scene.transparencyTiles();
  drew_ = tiles.tiles != BufferId::kInvalid;
  if (!drew_) return {};
  pelage::ResourceTable& table = scene.resources();
  counts_.make("tile counts", uint64_t{tiles.columns} * tiles.rows, tile_counts::kTileWords, table);
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
      .tileCounts = table.whole(counts_.counts()),
      .tileSummary = table.whole(counts_.summary())};
  PassList list;
  if (Result<void> done =
          countTiles(tiles, uint64_t{view.width} * view.height, drawn, counts, list);
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
  const auto words = counts_.readSummary(read);
  if (!words) return words.error();
  figures.known = true;
  figures.largest = static_cast<float>((*words)[tile_counts::kTileMost]);
  figures.fragments = (*words)[tile_counts::kTileTotal];
  figures.tiles = (*words)[tile_counts::kTilesWithHair];
  figures.tilesWithoutRoom = (*words)[tile_counts::kTilesWithoutRoom];
  return figures;
}

void TileInspection::clear(pelage::Scene& scene) {
  counts_.clear(scene);
  drew_ = false;
}

}  // namespace viewer
