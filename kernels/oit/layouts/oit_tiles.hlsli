// Tiles of the screen that have hair, for draws that are limited to them. First layout of the
// groups that resolve transparency.
#ifndef PELAGE_OIT_LAYOUTS_OIT_TILES_HLSLI
#define PELAGE_OIT_LAYOUTS_OIT_TILES_HLSLI

cbuffer OitTileConstants : register(b0, space0) {
  uint g_tileColumns;  // tiles of 8 x 8 pixels in a row
  uint g_targetWidth;  // [pixels]
  uint g_targetHeight;
  uint g_tilePad0;
};

// Outputs of oit_tile_vertex.
struct OitTilePixel {
  float4 clip : SV_Position;
};

// Outputs of the kernels that resolve transparency.
struct ResolvedPixel {
  float4 color : SV_Target0;  // premultiplied; alpha = 1 - transmittance
};

#endif
