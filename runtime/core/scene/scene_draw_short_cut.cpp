// ShortCut: three fragments of a pixel by their depths, in four passes.
#include "pelage/kernels.h"
#include "scene/scene_draw.h"

namespace pelage {

Result<void> Scene::addShortCutPasses(const DrawFrame& frame, std::vector<PassList>& lists) {
  const View& view = frame.view;
  const detail::LayerSizes sizes =
      detail::layerSizes(view.width, view.height, detail::layerCount(Transparency::kShortCut));
  constexpr uint32_t kWord = sizeof(uint32_t);
  makeRoom({shortCut_.depths, "transparency/short cut depths", sizes.depthBytes, kWord});
  makeRoom({shortCut_.colors, "transparency/short cut colors", sizes.colorBytes, kWord});
  makeRoom({shortCut_.tiles, "transparency/short cut tiles", sizes.tileBytes, kWord});
  makeRoom({shortCut_.counters, "transparency/short cut counters", detail::kCounterBytes, kWord,
            BufferUsage::kStorage | BufferUsage::kIndirect});

  ShortCutDepthsAlphaConstants depths = {};
  depths.shortCutWidth = view.width;
  depths.shortCutHeight = view.height;
  depths.shortCutTileColumns = sizes.columns;
  PassBuilder clear(lists[0]);
  clear.dispatch(clearShortCutVariant(), view.width * 4, view.height)
      .bind("g_shortCutDepths", shortCut_.depths, sizes.depthBytes)
      .bind("g_shortCutClearedColors", shortCut_.colors, sizes.colorBytes)
      .bind("g_shortCutTiles", shortCut_.tiles, sizes.tileBytes)
      .bind("g_shortCutCounters", shortCut_.counters, detail::kCounterBytes)
      .constants("ShortCutDepthsAlphaConstants", depths)
      .bytes(sizes.depthBytes + sizes.colorBytes);
  if (Result<void> added = clear.finish(); !added) return added;

  detail::DrawOffers find;
  find.buffers = {{"g_shortCutDepths", shortCut_.depths, sizes.depthBytes},
                  {"g_shortCutTiles", shortCut_.tiles, sizes.tileBytes},
                  {"g_shortCutCounters", shortCut_.counters, detail::kCounterBytes}};
  find.blockName = "ShortCutDepthsAlphaConstants";
  find.block = std::as_bytes(std::span(&depths, 1));
  ShortCutFillColorsConstants colors = {};
  colors.fillWidth = view.width;
  colors.fillHeight = view.height;
  detail::DrawOffers fill;
  fill.buffers = {{"g_fillDepths", shortCut_.depths, sizes.depthBytes},
                  {"g_shortCutColors", shortCut_.colors, sizes.colorBytes}};
  fill.blockName = "ShortCutFillColorsConstants";
  fill.block = std::as_bytes(std::span(&colors, 1));
  if (Result<void> added = addStrandDraws(frame, shortCutDepthsAlphaVariant(), find, lists[0]);
      !added)
    return added;
  if (Result<void> added = addStrandDraws(frame, shortCutFillColorsVariant(), fill, lists[2]);
      !added)
    return added;

  const OitTileConstants tiles = detail::tileConstants(view.width, view.height);
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
                    shortCut_.counters)
      .bind("g_tiles", shortCut_.tiles, sizes.tileBytes)
      .bind("g_thirdDepths", shortCut_.depths, sizes.depthBytes)
      .constants("OitTileConstants", tiles)
      .constants("ShortCutResolveDepthConstants", third);
  if (Result<void> added = resolveDepth.finish(); !added) return added;

  ShortCutResolveColorConstants front = {};
  front.frontOrigin = {view.x, view.y};
  front.frontWidth = view.width;
  front.frontHeight = view.height;
  PassBuilder resolveColor(lists[3]);
  resolveColor
      .drawIndirect(oitTileVertexVariant(), shortCutResolveColorVariant(), detail::overTarget(),
                    shortCut_.counters)
      .bind("g_tiles", shortCut_.tiles, sizes.tileBytes)
      .bind("g_frontDepths", shortCut_.depths, sizes.depthBytes)
      .bind("g_frontColors", shortCut_.colors, sizes.colorBytes)
      .constants("OitTileConstants", tiles)
      .constants("ShortCutResolveColorConstants", front);
  return resolveColor.finish();
}

}  // namespace pelage
