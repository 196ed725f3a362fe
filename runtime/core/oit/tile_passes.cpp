// The exact composite by kernels alone: the fragments of strands are counted and sorted by pixel;
// those that are visible are lit and added up.
#include <algorithm>
#include <bit>

#include "oit/oit_views.h"
#include "pelage/kernels.h"
#include "shading/lit_kernels.h"

namespace pelage::detail {

namespace {

constexpr uint64_t kDispatchOffset = strand_tile_counters::kTileDispatchWord * sizeof(uint32_t);
// Threads that light fragments, as many as large devices run at one time.
constexpr uint32_t kShadeThreads = 1 << 18;

// The passes of one batch share this.
struct TileDraw {
  OitDraw& draw;
  const MaterialBatch& batch;
  const StrandTileSizes& sizes;
  PassList& list;

  const OitBuffers::Tiles& buffers() const { return draw.buffers.strands; }
  BufferRange records() const { return {buffers().records, sizes.recordBytes}; }
  BufferRange pixels() const { return {buffers().pixels, sizes.pixelBytes}; }
  BufferRange tiles() const { return {buffers().tiles, sizes.tileBytes}; }
  BufferRange sums() const { return {buffers().sums, sizes.sumBytes}; }
  BufferRange counters() const { return {draw.buffers.lists.counters, kCounterBytes}; }
  BufferRange fragments() const { return ofFragments(buffers().fragments, sizeof(Uint2)); }
  BufferRange visible() const { return ofFragments(buffers().visible, sizeof(Uint4)); }
  BufferRange picture() const { return {buffers().picture, sizes.pictureBytes}; }
  bool occluded() const { return draw.settings.opaqueDepth != BufferId::kInvalid; }
  /// Bits that indices of segments have, see packTileFragment().
  uint32_t segmentBits() const {
    const uint64_t last = 2 * std::max<uint64_t>(batch.vertices, 1) - 1;
    return std::max<uint32_t>(24, static_cast<uint32_t>(std::bit_width(last)));
  }
  RoundSizes rounds() const { return roundSizes(draw.plan.sizes); }

 private:
  BufferRange ofFragments(BufferId buffer, uint64_t bytes) const {
    return {buffer, rounds().capacity * bytes};
  }
};

StrandTilesBindings binsOf(const TileDraw& tiles, uint32_t round) {
  const View& view = tiles.draw.view.view;
  const RoundSizes rounds = tiles.rounds();
  StrandTilesConstants bin = {};
  bin.binWidth = view.width;
  bin.binHeight = view.height;
  bin.binTileColumns = tiles.sizes.columns;
  bin.binTileCount = tiles.sizes.tiles;
  bin.binRecordCount = static_cast<uint32_t>(tiles.batch.vertices);
  bin.binCapacity = rounds.capacity;
  bin.binRoundSpan = rounds.span;
  bin.binRoundCount = rounds.count;
  bin.binRoundBegin = round * rounds.span;
  bin.binReversedDepth = view.reversedDepth ? 1 : 0;
  bin.binSegmentBits = tiles.segmentBits();
  const uint64_t depthBytes = uint64_t{view.width} * view.height * sizeof(float);
  return {
      .strandTilesConstants = bin,
      .binRecords = tiles.records(),
      .binDepth = {tiles.draw.settings.opaqueDepth, depthBytes},
      .binPixels = tiles.pixels(),
      .binTiles = tiles.tiles(),
      .binSums = tiles.sums(),
      .binCounters = tiles.counters(),
      .binFragments = tiles.fragments(),
  };
}

// Counts the fragments of pixels and tiles, and makes room for them.
Result<void> addCounts(const TileDraw& tiles) {
  const StrandTilesBindings bins = binsOf(tiles, 0);
  const auto add = [&](const KernelVariant& kernel, RecordThreads threads) -> Result<void> {
    PassBuilder builder(tiles.list);
    builder.dispatch(kernel, threads.x, threads.y);
    return builder.finish(bins);
  };
  const RecordThreads tileThreads = {tiles.sizes.tiles, 1};
  if (Result<void> added =
          add(clearStrandTilesVariant(), recordThreads(tiles.sizes.pixelBytes / sizeof(uint32_t)));
      !added)
    return added;
  if (Result<void> added = add(rasterStrandsVariant({.fill = false, .occluded = tiles.occluded()}),
                               recordThreads(tiles.batch.vertices));
      !added)
    return added;
  if (Result<void> added = add(sumStrandTilesVariant(), tileThreads); !added) return added;
  if (Result<void> added = add(offsetStrandTilesVariant(), {1, 1}); !added) return added;
  return add(allocateStrandTilesVariant(), tileThreads);
}

// Adds the fragments of a round, and their light.
Result<void> addRound(const TileDraw& tiles, uint32_t round) {
  const View& view = tiles.draw.view.view;
  PassBuilder fill(tiles.list);
  const RecordThreads threads = recordThreads(tiles.batch.vertices);
  fill.dispatch(rasterStrandsVariant({.fill = true, .occluded = tiles.occluded()}), threads.x,
                threads.y);
  if (Result<void> added = fill.finish(binsOf(tiles, round)); !added) return added;

  const RoundSizes rounds = tiles.rounds();
  StrandTilesWeighConstants constants = {};
  constants.weighWidth = view.width;
  constants.weighHeight = view.height;
  constants.weighTileColumns = tiles.sizes.columns;
  constants.weighTileCount = tiles.sizes.tiles;
  constants.weighRoundSpan = rounds.span;
  constants.weighRoundBegin = round * rounds.span;
  constants.weighSegmentBits = tiles.segmentBits();
  constants.weighEpsilon = tiles.draw.settings.epsilon;
  const StrandTilesWeighBindings weighed = {
      .strandTilesWeighConstants = constants,
      .weighRecords = tiles.records(),
      .weighPixels = tiles.pixels(),
      .weighTiles = tiles.tiles(),
      .weighFragments = tiles.fragments(),
      .weighSums = tiles.sums(),
      .weighVisible = tiles.visible(),
      .weighPicture = tiles.picture(),
  };
  const BufferId counters = tiles.counters().buffer;
  PassBuilder weigh(tiles.list);
  weigh.dispatchIndirect(weighStrandTilesVariant(), counters, kDispatchOffset);
  if (Result<void> added = weigh.finish(weighed); !added) return added;

  StrandTilesCompositeConstants composite = {};
  setMaterials(tiles.batch.materials, composite.tileModels, composite.tileBodies,
               composite.tilePrimaries, composite.tileSecondaries, composite.tileFibers);
  composite.tileWidth = view.width;
  composite.tileSumsEnd = static_cast<uint32_t>(tiles.sizes.sumBytes / sizeof(Uint2)) - 2;
  constexpr uint32_t kGroup = kShadeStrandTilesGroupSize.x;
  composite.tileStride = std::min(kShadeThreads, (rounds.capacity + kGroup - 1) / kGroup * kGroup);
  PassBuilder shade(tiles.list);
  const EngineLights* lights = tiles.draw.view.engineLights;
  shade.dispatch(litVariant(lights, shadeStrandTilesVariant()), composite.tileStride);
  if (lights != nullptr) shade.offer(lights->resources);
  if (Result<void> added = shade.finish(StrandTilesCompositeBindings{
          .strandViewConstants = tiles.draw.view.constants,
          .strandTilesCompositeConstants = composite,
          .tileRecords = tiles.records(),
          .tileSums = tiles.sums(),
          .tileShadowWords = {tiles.draw.view.shadowWords, tiles.draw.view.shadowBytes},
          .tileVisible = tiles.visible(),
      });
      !added)
    return added;

  PassBuilder gather(tiles.list);
  gather.dispatchIndirect(gatherStrandTilesVariant(), counters, kDispatchOffset);
  return gather.finish(weighed);
}

Result<void> addShow(const TileDraw& tiles) {
  const View& view = tiles.draw.view.view;
  StrandTilesPictureConstants picture = {};
  picture.pictureX = static_cast<int32_t>(view.x);
  picture.pictureY = static_cast<int32_t>(view.y);
  picture.pictureSize = {view.width, view.height};
  PassBuilder show(tiles.list);
  show.drawIndirect(oitTileVertexVariant(), showStrandTilesVariant(), overTarget(),
                    tiles.counters().buffer)
      .vertices(tileList(tiles.buffers().tiles, view.width, view.height, 2));
  return show.finish(OitTilesBindings{.oitTileConstants = tileConstants(view.width, view.height)},
                     StrandTilesPictureBindings{
                         .strandTilesPictureConstants = picture,
                         .picture = tiles.picture(),
                     });
}

}  // namespace

Result<void> addTilePasses(OitDraw& draw, const MaterialBatch& batch, PassList& list) {
  const View& view = draw.view.view;
  OitBuffers::Tiles& strands = draw.buffers.strands;
  const StrandTileSizes sizes = strandTileSizes(view.width, view.height, batch.vertices);
  constexpr uint32_t kWord = sizeof(uint32_t);
  // Batches share it, and lists of the first one name it already.
  const uint64_t allRecords =
      strandTileSizes(view.width, view.height, draw.plan.vertices).recordBytes;
  const uint64_t capacity = roundSizes(draw.plan.sizes).capacity;
  draw.ensureCapacity(strands.records, "transparency/strands", allRecords, sizeof(Uint4),
                      kRecordUsage);
  draw.ensureCapacity(strands.pixels, "transparency/strand pixels", sizes.pixelBytes, kWord);
  draw.ensureCapacity(strands.tiles, "transparency/strand tiles", sizes.tileBytes, kWord,
                      BufferUsage::kStorage | BufferUsage::kVertex);
  draw.ensureCapacity(strands.fragments, "transparency/strand fragments", capacity * sizeof(Uint2),
                      sizeof(Uint2));
  draw.ensureCapacity(strands.visible, "transparency/visible strands", capacity * sizeof(Uint4),
                      sizeof(Uint4));
  draw.ensureCapacity(strands.sums, "transparency/strand sums", sizes.sumBytes, sizeof(Uint2));
  draw.ensureCapacity(strands.picture, "transparency/strand picture", sizes.pictureBytes,
                      sizeof(Uint2));
  draw.ensureCapacity(draw.buffers.lists.counters, "transparency/counters", kCounterBytes, kWord,
                      BufferUsage::kStorage | BufferUsage::kIndirect | BufferUsage::kReadback);

  uint64_t record = 0;
  for (size_t i = 0; i < batch.hairs.size(); ++i) {
    const DrawnHair& hair = draw.view.hairs[batch.hairs[i]];
    if (Result<void> added = addTransform(draw.view, hair, batch.materialOf[i],
                                          {strands.records, sizes.recordBytes}, record, list);
        !added)
      return added;
    record += hair.drawnVertices();
  }
  const TileDraw tiles = {draw, batch, sizes, list};
  if (Result<void> added = addCounts(tiles); !added) return added;
  for (uint32_t round = 0; round < tiles.rounds().count; ++round)
    if (Result<void> added = addRound(tiles, round); !added) return added;
  return addShow(tiles);
}

}  // namespace pelage::detail
