// The nearest fragments of a pixel in layers, the others averaged behind them.
#include "pelage/kernels.h"
#include "scene/scene_draw.h"

namespace pelage {

Result<void> Scene::addHybridPasses(const DrawFrame& frame, uint32_t layers,
                                    std::vector<PassList>& lists) {
  const View& view = frame.view;
  const detail::LayerSizes sizes = detail::layerSizes(view.width, view.height, layers);
  constexpr uint32_t kWord = sizeof(uint32_t);
  makeRoom({hybrid_.depths, "transparency/layer depths", sizes.depthBytes, kWord});
  makeRoom({hybrid_.colors, "transparency/layer colors", sizes.colorBytes, kWord});
  makeRoom({hybrid_.tail, "transparency/layer tail", sizes.tailBytes, kWord});
  makeRoom({hybrid_.tiles, "transparency/layer tiles", sizes.tileBytes, kWord});
  makeRoom({hybrid_.counters, "transparency/layer counters", detail::kCounterBytes, kWord,
            BufferUsage::kStorage | BufferUsage::kIndirect});

  HybridDepthsConstants depths = {};
  depths.hybridWidth = view.width;
  depths.hybridHeight = view.height;
  depths.hybridLayers = layers;
  depths.hybridTileColumns = sizes.columns;
  PassBuilder clear(lists[0]);
  clear.dispatch(clearHybridVariant(), view.width * layers, view.height)
      .bind("g_hybridDepths", hybrid_.depths, sizes.depthBytes)
      .bind("g_hybridClearedColors", hybrid_.colors, sizes.colorBytes)
      .bind("g_hybridClearedTail", hybrid_.tail, sizes.tailBytes)
      .bind("g_hybridTiles", hybrid_.tiles, sizes.tileBytes)
      .bind("g_hybridCounters", hybrid_.counters, detail::kCounterBytes)
      .constants("HybridDepthsConstants", depths)
      .bytes(sizes.depthBytes + sizes.colorBytes + sizes.tailBytes);
  if (Result<void> added = clear.finish(); !added) return added;

  detail::DrawOffers find;
  find.buffers = {{"g_hybridDepths", hybrid_.depths, sizes.depthBytes},
                  {"g_hybridTiles", hybrid_.tiles, sizes.tileBytes},
                  {"g_hybridCounters", hybrid_.counters, detail::kCounterBytes}};
  find.blockName = "HybridDepthsConstants";
  find.block = std::as_bytes(std::span(&depths, 1));
  HybridColorsConstants colors = {};
  colors.colorsWidth = view.width;
  colors.colorsHeight = view.height;
  colors.colorsLayers = layers;
  detail::DrawOffers fill;
  fill.buffers = {{"g_foundDepths", hybrid_.depths, sizes.depthBytes},
                  {"g_hybridColors", hybrid_.colors, sizes.colorBytes},
                  {"g_hybridTail", hybrid_.tail, sizes.tailBytes}};
  fill.blockName = "HybridColorsConstants";
  fill.block = std::as_bytes(std::span(&colors, 1));
  if (Result<void> added = addStrandDraws(frame, hybridDepthsVariant(), find, lists[0]); !added)
    return added;
  if (Result<void> added = addStrandDraws(frame, hybridColorsVariant(), fill, lists[1]); !added)
    return added;

  HybridReadConstants read = {};
  read.layersOrigin = {view.x, view.y};
  read.layersWidth = view.width;
  read.layersHeight = view.height;
  read.layersQuads = layers / 4;
  PassBuilder resolve(lists[2]);
  resolve
      .drawIndirect(oitTileVertexVariant(), hybridReadVariant(), detail::overTarget(),
                    hybrid_.counters)
      .bind("g_tiles", hybrid_.tiles, sizes.tileBytes)
      .bind("g_layerColors", hybrid_.colors, sizes.colorBytes)
      .bind("g_layerTail", hybrid_.tail, sizes.tailBytes)
      .constants("OitTileConstants", detail::tileConstants(view.width, view.height))
      .constants("HybridReadConstants", read);
  return resolve.finish();
}

}  // namespace pelage
