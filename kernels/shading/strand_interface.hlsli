// What strand_vertex hands to strand_pixel, and to an engine's own pixel shader.
#ifndef PELAGE_SHADING_STRAND_INTERFACE_HLSLI
#define PELAGE_SHADING_STRAND_INTERFACE_HLSLI

struct StrandPixel {
  float4 clip : SV_Position;
  float3 position : TEXCOORD0;  // world [m]
  float3 tangent : TEXCOORD1;   // unit at the vertices
  // x 0 at the root to 1 at the tip; y coverage of the ribbon by the fibre, 0..1; z -1..1 across.
  float3 ribbon : TEXCOORD2;
  nointerpolation uint strand : TEXCOORD3;
};

#endif
