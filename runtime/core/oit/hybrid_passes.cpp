// The nearest fragments of a pixel in layers, the others averaged behind them.
#include "oit/oit_views.h"
#include "pelage/kernels.h"
#include "shading/lit_kernels.h"

namespace pelage::detail {

namespace {

void makeLayerBuffers(OitDraw& draw, const LayerSizes& sizes) {
  OitBuffers::Layers& hybrid = draw.buffers.hybrid;
  constexpr uint32_t kWord = sizeof(uint32_t);
  draw.ensureCapacity(hybrid.depths, "transparency/layer depths", sizes.depthBytes, kWord);
  draw.ensureCapacity(hybrid.colors, "transparency/layer colors", sizes.colorBytes, kWord);
  draw.ensureCapacity(hybrid.tail, "transparency/layer tail", sizes.tailBytes, kWord);
  draw.ensureCapacity(hybrid.tiles, "transparency/layer tiles", sizes.tileBytes, kWord,
                      BufferUsage::kStorage | BufferUsage::kVertex);
  draw.ensureCapacity(hybrid.counters, "transparency/layer counters", kCounterBytes, kWord,
                      BufferUsage::kStorage | BufferUsage::kIndirect);
}

Result<void> addLayerResolve(const OitDraw& draw, const LayerSizes& sizes, uint32_t layers,
                             PassList& list) {
  const View& view = draw.view.view;
  const OitBuffers::Layers& hybrid = draw.buffers.hybrid;
  HybridReadConstants read = {};
  read.layersOrigin = {view.x, view.y};
  read.layersWidth = view.width;
  read.layersHeight = view.height;
  read.layersQuads = layers / 4;
  PassBuilder resolve(list);
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

}  // namespace

Result<void> addHybridPasses(OitDraw& draw, uint32_t layers, std::vector<PassList>& lists) {
  const View& view = draw.view.view;
  const OitBuffers::Layers& hybrid = draw.buffers.hybrid;
  const LayerSizes sizes = layerSizes(view.width, view.height, layers);
  makeLayerBuffers(draw, sizes);
  HybridDepthsConstants depths = {};
  depths.hybridWidth = view.width;
  depths.hybridHeight = view.height;
  depths.hybridLayers = layers;
  depths.hybridTileColumns = sizes.columns;
  const HybridDepthsBindings find{
      .hybridDepthsConstants = depths,
      .hybridDepths = {hybrid.depths, sizes.depthBytes},
      .hybridCounters = {hybrid.counters, kCounterBytes},
      .hybridTiles = {hybrid.tiles, sizes.tileBytes},
      .hybridClearedColors = {hybrid.colors, sizes.colorBytes},
      .hybridClearedTail = {hybrid.tail, sizes.tailBytes},
  };
  PassBuilder clear(lists[0]);
  clear.dispatch(clearHybridVariant(), view.width * layers, view.height)
      .bytes(sizes.depthBytes + sizes.colorBytes + sizes.tailBytes);
  if (Result<void> added = clear.finish(find); !added) return added;

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
  return addLayerResolve(draw, sizes, layers, lists[2]);
}

}  // namespace pelage::detail
