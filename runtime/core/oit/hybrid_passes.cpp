// The nearest fragments of a pixel in layers, the others averaged behind them.
#include "oit/oit_views.h"
#include "pelage/kernels.h"
#include "shading/lit_kernels.h"

namespace pelage::detail {

Result<void> addHybridPasses(OitDraw& draw, uint32_t layers, std::vector<PassList>& lists) {
  const View& view = draw.view.view;
  OitBuffers::Layers& hybrid = draw.buffers.hybrid;
  const LayerSizes sizes = layerSizes(view.width, view.height, layers);
  constexpr uint32_t kWord = sizeof(uint32_t);
  draw.makeRoom(hybrid.depths, "transparency/layer depths", sizes.depthBytes, kWord);
  draw.makeRoom(hybrid.colors, "transparency/layer colors", sizes.colorBytes, kWord);
  draw.makeRoom(hybrid.tail, "transparency/layer tail", sizes.tailBytes, kWord);
  draw.makeRoom(hybrid.tiles, "transparency/layer tiles", sizes.tileBytes, kWord,
                BufferUsage::kStorage | BufferUsage::kVertex);
  draw.makeRoom(hybrid.counters, "transparency/layer counters", kCounterBytes, kWord,
                BufferUsage::kStorage | BufferUsage::kIndirect);

  HybridDepthsConstants depths = {};
  depths.hybridWidth = view.width;
  depths.hybridHeight = view.height;
  depths.hybridLayers = layers;
  depths.hybridTileColumns = sizes.columns;
  PassBuilder clear(lists[0]);
  clear.dispatch(clearHybridVariant(), view.width * layers, view.height)
      .bytes(sizes.depthBytes + sizes.colorBytes + sizes.tailBytes);
  if (Result<void> added = clear.finish(HybridDepthsBindings{
          .hybridDepthsConstants = depths,
          .hybridDepths = {hybrid.depths, sizes.depthBytes},
          .hybridCounters = {hybrid.counters, kCounterBytes},
          .hybridTiles = {hybrid.tiles, sizes.tileBytes},
          .hybridClearedColors = {hybrid.colors, sizes.colorBytes},
          .hybridClearedTail = {hybrid.tail, sizes.tailBytes},
      });
      !added)
    return added;

  const HybridDepthsBindings find{
      .hybridDepthsConstants = depths,
      .hybridDepths = {hybrid.depths, sizes.depthBytes},
      .hybridCounters = {hybrid.counters, kCounterBytes},
      .hybridTiles = {hybrid.tiles, sizes.tileBytes},
  };
  HybridColorsConstants colors = {};
  colors.colorsWidth = view.width;
  colors.colorsHeight = view.height;
  colors.colorsLayers = layers;
  const HybridColorsBindings fill{
      .hybridColorsConstants = colors,
      .foundDepths = {hybrid.depths, sizes.depthBytes},
      .hybridColors = {hybrid.colors, sizes.colorBytes},
      .hybridTail = {hybrid.tail, sizes.tailBytes},
  };
  if (Result<void> added = addStrandDraws(draw.view, hybridDepthsVariant(), find, lists[0]); !added)
    return added;
  const KernelVariant& lit = litVariant(draw.view.engineLights, hybridColorsVariant());
  if (Result<void> added = addStrandDraws(draw.view, lit, fill, lists[1]); !added) return added;

  HybridReadConstants read = {};
  read.layersOrigin = {view.x, view.y};
  read.layersWidth = view.width;
  read.layersHeight = view.height;
  read.layersQuads = layers / 4;
  PassBuilder resolve(lists[2]);
  resolve.drawIndirect(oitTileVertexVariant(), hybridReadVariant(), overTarget(), hybrid.counters)
      .vertices(tileList(hybrid.tiles, view.width, view.height));
  return resolve.finish(
      OitTilesBindings{.oitTileConstants = tileConstants(view.width, view.height)},
      HybridReadBindings{
          .hybridReadConstants = read,
          .layerColors = {hybrid.colors, sizes.colorBytes},
          .layerTail = {hybrid.tail, sizes.tailBytes},
      });
}

}  // namespace pelage::detail
