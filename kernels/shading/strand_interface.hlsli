// Outputs of strand_vertex for the pixel kernels, and for an engine's own pixel shader. To use its
// smooth permutation, define SMOOTH as 1 before, as the kernel does; to have the UV of roots,
// define STRAND_UV as 1 in both stages.
#ifndef PELAGE_SHADING_STRAND_INTERFACE_HLSLI
#define PELAGE_SHADING_STRAND_INTERFACE_HLSLI

struct StrandPixel {
  float4 clip : SV_Position;
  float3 tangent : TEXCOORD0;  // unit at the vertices
  float4 color : TEXCOORD1;    // linear rgb, opacity
  // Without the smooth permutation: x coverage of the ribbon by the fiber, 0..1.
  // With it: x distance from the center line, y half the fiber's width [pixels], each times z; z is
  // the clip w, so that x / z and y / z are linear on the screen.
  float3 ribbon : TEXCOORD2;
#if !SMOOTH
  nointerpolation uint strand : TEXCOORD3;
#endif
#if STRAND_UV
  nointerpolation float2 uv : TEXCOORD4;  // of the root, 0..1; 0 without kHasStrandUvs
#endif
};

// Returns a corner outside of the picture.
StrandPixel hiddenStrandPixel(uint strand) {
  StrandPixel result;
  result.clip = float4(2.0, 2.0, 2.0, 1.0);
  result.tangent = float3(0.0, 1.0, 0.0);
  result.color = float4(0.0, 0.0, 0.0, 0.0);
  result.ribbon = float3(0.0, 0.0, 1.0);
#if !SMOOTH
  result.strand = strand;
#endif
#if STRAND_UV
  result.uv = float2(0.0, 0.0);
#endif
  return result;
}

#endif
