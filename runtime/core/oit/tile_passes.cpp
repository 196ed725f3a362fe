// The exact composite by kernels alone: strands are transformed, sorted into tiles of the screen,
// and composited a tile at a time.
#include <algorithm>

#include "oit/oit_views.h"
#include "pelage/kernels.h"
#include "shading/lit_kernels.h"

namespace pelage::detail {

namespace {

constexpr uint64_t kDispatchOffset = strand_tile_counters::kTileDispatchWord * sizeof(uint32_t);

// Sorts the segments of strands into tiles: counts them, makes room, and writes references.
Result<void> addBins(const StrandTilesBindings& bins, uint32_t tiles, uint64_t vertices,
                     PassList& list) {
  const auto add = [&](const KernelVariant& kernel, uint32_t x, uint32_t y = 1) -> Result<void> {
    PassBuilder builder(list);
    builder.dispatch(kernel, x, y);
    return builder.finish(bins);
  };
  const RecordThreads threads = recordThreads(vertices);
  if (Result<void> added = add(clearStrandTilesVariant(), tiles); !added) return added;
  if (Result<void> added = add(binStrandsVariant({.fill = false}), threads.x, threads.y); !added)
    return added;
  if (Result<void> added = add(sumStrandTilesVariant(), tiles); !added) return added;
  if (Result<void> added = add(offsetStrandTilesVariant(), 1); !added) return added;
  if (Result<void> added = add(allocateStrandTilesVariant(), tiles); !added) return added;
  return add(binStrandsVariant({.fill = true}), threads.x, threads.y);
}

// Composites the tiles, and shows the picture.
Result<void> addComposite(const OitDraw& draw, const MaterialBatch& batch,
                          const StrandTileSizes& sizes, PassList& list) {
  const View& view = draw.view.view;
  const TransparencySettings& settings = draw.settings;
  const OitBuffers::Tiles& strands = draw.buffers.strands;
  const BufferId counters = draw.buffers.lists.counters;
  const uint64_t depthBytes = uint64_t{view.width} * view.height * sizeof(float);
  const uint64_t referenceBytes = uint64_t{draw.plan.sizes.nodeCount} * sizeof(uint32_t);
  const bool occluded = settings.opaqueDepth != BufferId::kInvalid;
  StrandTilesCompositeConstants composite = {};
  setMaterials(batch.materials, composite.tileModels, composite.tileBodies, composite.tilePrimaries,
               composite.tileSecondaries, composite.tileFibers);
  composite.tileWidth = view.width;
  composite.tileHeight = view.height;
  composite.tileRowSize = sizes.columns;
  composite.tileTotal = sizes.tiles;
  composite.tileEpsilon = settings.epsilon;
  PassBuilder builder(list);
  const EngineLights* lights = draw.view.engineLights;
  builder.dispatchIndirect(litVariant(lights, compositeStrandTilesVariant({.occluded = occluded})),
                           counters, kDispatchOffset);
  if (lights != nullptr) builder.offer(lights->resources);
  if (Result<void> added = builder.finish(StrandTilesCompositeBindings{
          .strandViewConstants = draw.view.constants,
          .strandTilesCompositeConstants = composite,
          .tileRecords = {strands.records, sizes.recordBytes},
          .tileBins = {strands.tiles, sizes.tileBytes},
          .tileReferences = {strands.references, referenceBytes},
          .tileCounters = {counters, kCounterBytes},
          .tileShadowWords = {draw.view.shadowWords, draw.view.shadowBytes},
          .tileDepth = {settings.opaqueDepth, depthBytes},
          .tilePicture = {strands.picture, sizes.pictureBytes},
      });
      !added)
    return added;

  StrandTilesPictureConstants picture = {};
  picture.pictureX = static_cast<int32_t>(view.x);
  picture.pictureY = static_cast<int32_t>(view.y);
  picture.pictureSize = {view.width, view.height};
  PassBuilder show(list);
  show.drawIndirect(oitTileVertexVariant(), showStrandTilesVariant(), overTarget(), counters)
      .vertices(tileList(strands.tiles, view.width, view.height, 2));
  return show.finish(OitTilesBindings{.oitTileConstants = tileConstants(view.width, view.height)},
                     StrandTilesPictureBindings{
                         .strandTilesPictureConstants = picture,
                         .picture = {strands.picture, sizes.pictureBytes},
                     });
}

}  // namespace

Result<void> addTilePasses(OitDraw& draw, const MaterialBatch& batch, PassList& list) {
  const View& view = draw.view.view;
  OitBuffers::Tiles& strands = draw.buffers.strands;
  BufferId& counters = draw.buffers.lists.counters;
  const StrandTileSizes sizes = strandTileSizes(view.width, view.height, batch.vertices);
  const uint64_t referenceBytes = uint64_t{draw.plan.sizes.nodeCount} * sizeof(uint32_t);
  constexpr uint32_t kWord = sizeof(uint32_t);
  // Batches share it, and lists of the first one name it already.
  const uint64_t allRecords =
      strandTileSizes(view.width, view.height, draw.plan.vertices).recordBytes;
  draw.ensureCapacity(strands.records, "transparency/strands", allRecords, sizeof(Uint4),
                      kRecordUsage);
  draw.ensureCapacity(strands.tiles, "transparency/strand tiles", sizes.tileBytes, kWord,
                      BufferUsage::kStorage | BufferUsage::kVertex);
  draw.ensureCapacity(strands.references, "transparency/strand references", referenceBytes, kWord);
  draw.ensureCapacity(strands.sums, "transparency/strand sums", sizes.sumBytes, sizeof(Uint2));
  draw.ensureCapacity(strands.picture, "transparency/strand picture", sizes.pictureBytes,
                      sizeof(Uint2));
  draw.ensureCapacity(counters, "transparency/counters", kCounterBytes, kWord,
                      BufferUsage::kStorage | BufferUsage::kIndirect | BufferUsage::kReadback);

  StrandTilesConstants bin = {};
  bin.binWidth = view.width;
  bin.binHeight = view.height;
  bin.binTileColumns = sizes.columns;
  bin.binTileCount = sizes.tiles;
  bin.binRecordCount = static_cast<uint32_t>(batch.vertices);
  bin.binCapacity = draw.plan.sizes.nodeCount;
  const StrandTilesBindings bins{
      .strandTilesConstants = bin,
      .binRecords = {strands.records, sizes.recordBytes},
      .binTiles = {strands.tiles, sizes.tileBytes},
      .binReferences = {strands.references, referenceBytes},
      .binSums = {strands.sums, sizes.sumBytes},
      .binCounters = {counters, kCounterBytes},
  };

  uint64_t record = 0;
  for (size_t i = 0; i < batch.hairs.size(); ++i) {
    const DrawnHair& hair = draw.view.hairs[batch.hairs[i]];
    if (Result<void> added = addTransform(draw.view, hair, batch.materialOf[i],
                                          {strands.records, sizes.recordBytes}, record, list);
        !added)
      return added;
    record += hair.drawnVertices();
  }
  if (Result<void> added = addBins(bins, sizes.tiles, batch.vertices, list); !added) return added;
  return addComposite(draw, batch, sizes, list);
}

}  // namespace pelage::detail
