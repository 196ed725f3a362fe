// Outputs of oit_tile_vertex for the kernels that resolve transparency, and their outputs.
#ifndef PELAGE_OIT_OIT_TILE_INTERFACE_HLSLI
#define PELAGE_OIT_OIT_TILE_INTERFACE_HLSLI

struct OitTilePixel {
  float4 clip : SV_Position;
};

struct ResolvedPixel {
  float4 color : SV_Target0;  // premultiplied; alpha = 1 - transmittance
};

#endif
