// What oit_tile_vertex hands to the kernels that resolve transparency.
#ifndef PELAGE_OIT_OIT_TILE_INTERFACE_HLSLI
#define PELAGE_OIT_OIT_TILE_INTERFACE_HLSLI

struct OitTilePixel {
  float4 clip : SV_Position;
};

#endif
