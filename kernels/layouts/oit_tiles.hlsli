// Tiles of the screen that have hair, for draws that touch nothing else. First layout of the groups
// that resolve transparency.
#ifndef PELAGE_LAYOUTS_OIT_TILES_HLSLI
#define PELAGE_LAYOUTS_OIT_TILES_HLSLI

cbuffer OitTileConstants : register(b0, space0) {
  uint g_tileColumns;  // tiles of 8 x 8 pixels in a row
  uint g_tileListStart;  // word of g_tiles where the list begins
  uint g_targetWidth;  // [pixels]
  uint g_targetHeight;
};

// Behind g_tileListStart: tiles, in any order.
StructuredBuffer<uint> g_tiles : register(t0, space0);

#endif
