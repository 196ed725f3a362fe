// ShortCut: three fragments of a pixel by their depths, in four passes.
#include "oit/oit_views.h"
#include "pelage/kernels.h"
#include "shading/lit_kernels.h"

namespace pelage::detail {

namespace {

// The third fragment's depth into the target, then the colors of all three over it.
Result<void> addResolves(const OitDraw& draw, const LayerSizes& sizes,
                         std::vector<PassList>& lists) {
  const View& view = draw.view.view;
  const OitBuffers::Layers& shortCut = draw.buffers.shortCut;
  const OitTileConstants tiles = tileConstants(view.width, view.height);
  ShortCutResolveDepthConstants third = {};
  third.thirdOrigin = {view.x, view.y};
  third.thirdWidth = view.width;
  third.thirdHeight = view.height;
  third.thirdReversed = view.reversedDepth ? 1 : 0;
  DrawState nearer;
  nearer.depthCompare = view.reversedDepth ? DepthCompare::kGreater : DepthCompare::kLess;
  nearer.colorWrite = false;
  PassBuilder resolveDepth(lists[1]);
  resolveDepth
      .drawIndirect(oitTileVertexVariant(), shortCutResolveDepthVariant(), nearer,
                    shortCut.counters)
      .vertices(tileList(shortCut.tiles, view.width, view.height));
  if (Result<void> added =
          resolveDepth.finish(OitTilesBindings{.oitTileConstants = tiles},
                              ShortCutResolveDepthBindings{
                                  .shortCutResolveDepthConstants = third,
                                  .thirdDepths = {shortCut.depths, sizes.depthBytes},
                              });
      !added)
    return added;

  ShortCutResolveColorConstants front = {};
  front.frontOrigin = {view.x, view.y};
  front.frontWidth = view.width;
  front.frontHeight = view.height;
  PassBuilder resolveColor(lists[3]);
  resolveColor
      .drawIndirect(oitTileVertexVariant(), shortCutResolveColorVariant(), overTarget(),
                    shortCut.counters)
      .vertices(tileList(shortCut.tiles, view.width, view.height));
  return resolveColor.finish(OitTilesBindings{.oitTileConstants = tiles},
                             ShortCutResolveColorBindings{
                                 .shortCutResolveColorConstants = front,
                                 .frontDepths = {shortCut.depths, sizes.depthBytes},
                                 .frontColors = {shortCut.colors, sizes.colorBytes},
                             });
}

}  // namespace

Result<void> addShortCutPasses(OitDraw& draw, std::vector<PassList>& lists) {
  const View& view = draw.view.view;
  OitBuffers::Layers& shortCut = draw.buffers.shortCut;
  const LayerSizes sizes = layerSizes(view.width, view.height, layerCount(Transparency::kShortCut));
  constexpr uint32_t kWord = sizeof(uint32_t);
  draw.ensureCapacity(shortCut.depths, "transparency/short cut depths", sizes.depthBytes, kWord);
  draw.ensureCapacity(shortCut.colors, "transparency/short cut colors", sizes.colorBytes, kWord);
  draw.ensureCapacity(shortCut.tiles, "transparency/short cut tiles", sizes.tileBytes, kWord,
                      BufferUsage::kStorage | BufferUsage::kVertex);
  draw.ensureCapacity(shortCut.counters, "transparency/short cut counters", kCounterBytes, kWord,
                      BufferUsage::kStorage | BufferUsage::kIndirect);

  ShortCutDepthsAlphaConstants depths = {};
  depths.shortCutWidth = view.width;
  depths.shortCutHeight = view.height;
  depths.shortCutTileColumns = sizes.columns;
  const ShortCutDepthsAlphaBindings find{
      .shortCutDepthsAlphaConstants = depths,
      .shortCutDepths = {shortCut.depths, sizes.depthBytes},
      .shortCutCounters = {shortCut.counters, kCounterBytes},
      .shortCutTiles = {shortCut.tiles, sizes.tileBytes},
      .shortCutClearedColors = {shortCut.colors, sizes.colorBytes},
  };
  PassBuilder clear(lists[0]);
  clear.dispatch(clearShortCutVariant(), view.width * 4, view.height)
      .bytes(sizes.depthBytes + sizes.colorBytes);
  if (Result<void> added = clear.finish(find); !added) return added;

  ShortCutFillColorsConstants colors = {};
  colors.fillWidth = view.width;
  colors.fillHeight = view.height;
  const ShortCutFillColorsBindings fill{
      .shortCutFillColorsConstants = colors,
      .fillDepths = {shortCut.depths, sizes.depthBytes},
      .shortCutColors = {shortCut.colors, sizes.colorBytes},
  };
  if (Result<void> added = addStrandDraws(draw.view, shortCutDepthsAlphaVariant(), find, lists[0]);
      !added)
    return added;
  const KernelVariant& lit = litVariant(draw.view.engineLights, shortCutFillColorsVariant());
  if (Result<void> added = addStrandDraws(draw.view, lit, fill, lists[2]); !added) return added;
  return addResolves(draw, sizes, lists);
}

}  // namespace pelage::detail
