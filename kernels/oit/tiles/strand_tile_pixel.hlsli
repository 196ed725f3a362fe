// Pixels of the tiles that have hair. The including file has strand_tiles_weigh.hlsli.
#ifndef PELAGE_OIT_TILES_STRAND_TILE_PIXEL_HLSLI
#define PELAGE_OIT_TILES_STRAND_TILE_PIXEL_HLSLI

struct TilePixel {
  uint2 at;
  uint tile;
  uint index;    // in the tile
  bool inside;   // of the view
  bool inRound;  // the tile has fragments, and this is their round
  bool known;    // the tile has hair
};

// Pixels of a group: kMostPixels, or 1.
uint groupPixels() { return g_weighSums[weighSumsEnd() + 2u]; }

// Lanes of a group of 128 for each of its pixels.
uint lanesOfPixel(uint pixels) { return pixels == 1u ? 128u : 128u / kMostPixels; }

// The pixel of a lane.
uint pixelOfLane(uint lane, uint lanes) { return lanes == 128u ? 0u : lane / (128u / kMostPixels); }

// \param pixels of the group, \param pixel one of them.
TilePixel tilePixelOf(uint3 group, uint pixels, uint pixel) {
  uint listed = group.y * kTileDispatchRow + group.x;
  uint count = g_weighSums[weighSumsEnd() + 1u];
  TilePixel found;
  // The last row of groups may extend beyond the tiles: these groups do nothing.
  found.known = listed < count;
  found.tile = g_weighTiles[2u * g_weighTileCount + min(listed, count - 1u)];
  uint offset = g_weighTiles[g_weighTileCount + found.tile];
  found.inRound = found.known && offset - g_weighRoundBegin < g_weighRoundSpan;
  found.index = group.z * pixels + pixel;
  found.at = uint2(found.tile % g_weighTileColumns, found.tile / g_weighTileColumns) * kTileEdge +
             uint2(found.index & 7u, found.index >> kTileShift);
  found.inside = found.known && found.at.x < g_weighWidth && found.at.y < g_weighHeight;
  return found;
}

#endif
