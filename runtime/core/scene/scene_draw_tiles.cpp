// The exact composite by kernels alone: strands are transformed, sorted into tiles of the screen,
// and composited a tile at a time.
#include <algorithm>
#include <string>

#include "pelage/kernels.h"
#include "scene/scene_draw.h"

namespace pelage {

namespace {

// As in kernels/oit/tiles/strand_tile_counters.hlsli.
constexpr uint32_t kDispatchRow = 4194304;
constexpr uint64_t kDispatchOffset = 5 * sizeof(uint32_t);

Error refuse(const std::string& what) { return {ErrorCode::kInvalidArgument, "view: " + what}; }

uint32_t threadsInRow(uint64_t vertices) {
  return static_cast<uint32_t>(std::min<uint64_t>(vertices, kDispatchRow));
}

uint32_t rowsOf(uint64_t vertices) {
  return static_cast<uint32_t>((vertices + kDispatchRow - 1) / kDispatchRow);
}

}  // namespace

Result<void> Scene::addTilePasses(const DrawFrame& frame, const TransparencySettings& settings,
                                  const TransparencyPlan& plan, uint64_t vertices, PassList& list) {
  const View& view = frame.view;
  const uint64_t depthBytes = uint64_t{view.width} * view.height * sizeof(float);
  const bool occluded = settings.opaqueDepth != BufferId::kInvalid;
  if (occluded && bytesOfBuffer(settings.opaqueDepth) < depthBytes) {
    return refuse("opaqueDepth has " + std::to_string(bytesOfBuffer(settings.opaqueDepth)) +
                  " bytes, but a float a pixel takes " + std::to_string(depthBytes));
  }
  const detail::StrandTileSizes sizes = detail::strandTileSizes(view.width, view.height, vertices);
  const uint64_t referenceBytes = uint64_t{plan.nodeCount} * sizeof(uint32_t);
  constexpr uint32_t kWord = sizeof(uint32_t);
  makeRoom({tiles_.records, "transparency/strands", sizes.recordBytes, sizeof(Uint4)});
  makeRoom({tiles_.tiles, "transparency/strand tiles", sizes.tileBytes, kWord});
  makeRoom({tiles_.references, "transparency/strand references", referenceBytes, kWord});
  makeRoom({tiles_.sums, "transparency/strand sums", sizes.sumBytes, sizeof(Uint2)});
  makeRoom({tiles_.picture, "transparency/strand picture", sizes.pictureBytes, sizeof(Uint2)});
  makeRoom({lists_.counters, "transparency/counters", detail::kCounterBytes, kWord,
            BufferUsage::kStorage | BufferUsage::kIndirect | BufferUsage::kReadback});

  StrandTilesConstants bin = {};
  bin.binWidth = view.width;
  bin.binHeight = view.height;
  bin.binTileColumns = sizes.columns;
  bin.binTileCount = sizes.tiles;
  bin.binRecordCount = static_cast<uint32_t>(vertices);
  bin.binCapacity = plan.nodeCount;
  const auto offer = [&](PassBuilder& builder) -> PassBuilder& {
    return builder.bind("g_binRecords", tiles_.records, sizes.recordBytes)
        .bind("g_binTiles", tiles_.tiles, sizes.tileBytes)
        .bind("g_binReferences", tiles_.references, referenceBytes)
        .bind("g_binSums", tiles_.sums, sizes.sumBytes)
        .bind("g_binCounters", lists_.counters, detail::kCounterBytes)
        .constants("StrandTilesConstants", bin);
  };

  for (size_t i = 0; i < frame.visible.size(); ++i) {
    const HairObject& object = *frame.visible[i];
    bin.binObjectRecords = detail::drawnCount(object) * object.verticesPerStrand();
    const TransformStrandsKey key{.attributes = detail::strandAttributes(object.buffers()) != 0};
    PassBuilder transform(list);
    transform.dispatch(transformStrandsVariant(key), threadsInRow(bin.binObjectRecords),
                       rowsOf(bin.binObjectRecords));
    offerStrands(frame, i, transform);
    if (Result<void> added = offer(transform).finish(); !added) return added;
    bin.binFirstRecord += bin.binObjectRecords;
  }
  const auto add = [&](const KernelVariant& kernel, uint32_t x, uint32_t y = 1) -> Result<void> {
    PassBuilder builder(list);
    builder.dispatch(kernel, x, y);
    return offer(builder).finish();
  };
  const uint32_t row = threadsInRow(vertices), rows = rowsOf(vertices);
  if (Result<void> added = add(clearStrandTilesVariant(), sizes.tiles); !added) return added;
  if (Result<void> added = add(binStrandsVariant({.fill = false}), row, rows); !added) return added;
  if (Result<void> added = add(sumStrandTilesVariant(), sizes.tiles); !added) return added;
  if (Result<void> added = add(offsetStrandTilesVariant(), 1); !added) return added;
  if (Result<void> added = add(placeStrandTilesVariant(), sizes.tiles); !added) return added;
  if (Result<void> added = add(binStrandsVariant({.fill = true}), row, rows); !added) return added;

  StrandTilesCompositeConstants composite = {};
  detail::setMaterials(frame.visible, composite.tileModels, composite.tileBodies,
                       composite.tilePrimaries, composite.tileSecondaries, composite.tileFibers);
  composite.tileWidth = view.width;
  composite.tileHeight = view.height;
  composite.tileRowSize = sizes.columns;
  composite.tileTotal = sizes.tiles;
  composite.tileEpsilon = settings.epsilon;
  PassBuilder builder(list);
  builder
      .dispatchIndirect(compositeStrandTilesVariant({.occluded = occluded}), lists_.counters,
                        kDispatchOffset)
      .bind("g_tileRecords", tiles_.records, sizes.recordBytes)
      .bind("g_tileBins", tiles_.tiles, sizes.tileBytes)
      .bind("g_tileReferences", tiles_.references, referenceBytes)
      .bind("g_tileCounters", lists_.counters, detail::kCounterBytes)
      .bind("g_tileShadowWords", shadowWords_, bytesOfBuffer(shadowWords_))
      .bind("g_tileDepth", settings.opaqueDepth, depthBytes)
      .bind("g_tilePicture", tiles_.picture, sizes.pictureBytes)
      .constants("StrandViewConstants", frame.constants)
      .constants("StrandTilesCompositeConstants", composite);
  if (Result<void> added = builder.finish(); !added) return added;

  StrandTilesPictureConstants picture = {};
  picture.pictureX = static_cast<int32_t>(view.x);
  picture.pictureY = static_cast<int32_t>(view.y);
  picture.pictureSize = {view.width, view.height};
  OitTileConstants tiles = detail::tileConstants(view.width, view.height);
  tiles.tileListStart = 2 * sizes.tiles;
  PassBuilder show(list);
  show.drawIndirect(oitTileVertexVariant(), showStrandTilesVariant(), detail::overTarget(),
                    lists_.counters)
      .bind("g_tiles", tiles_.tiles, sizes.tileBytes)
      .bind("g_picture", tiles_.picture, sizes.pictureBytes)
      .constants("OitTileConstants", tiles)
      .constants("StrandTilesPictureConstants", picture);
  return show.finish();
}

}  // namespace pelage
