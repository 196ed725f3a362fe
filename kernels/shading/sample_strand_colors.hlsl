// Samples a texture of an engine at the roots of the guides, for the colors of strands in a view.
//
// Threads: one per guide, in rows of 2^20.
// Reads:   g_colorsPositions, g_strandUvs, g_strandTexture through g_strandSampler
// Writes:  g_strandColors
//
// A strand takes one color, for which its length has no footprint in the texture. The mip level is
// that of the larger of two footprints on the surface: the distance to the neighboring roots,
// between which no strand shows the texture, and a pixel of the view at the root, within which
// strands are averaged.
//
// Invariant (tests/shading): the level is log2 of that footprint in texels, plus the bias, clamped
// to the texture's levels; NaN takes level 0.
#include "../base/dispatch.hlsli"
#include "color_packing.hlsli"

cbuffer StrandColorsConstants : register(b0, space0) {
  uint g_colorsGuideCount;   // elements of g_strandUvs; first: decision 0008
  uint g_colorsVertexCount;  // vertices per strand
  float g_colorsTexels;      // of mip level 0, along the longer side
  float g_colorsLastLevel;   // of the mip levels
  float g_colorsLodBias;     // levels
  float g_colorsSpread;      // factor on the distance between roots: guides that are not drawn
  float g_colorsPixelSize;   // size of a pixel where clip w is 1 [m]
  float g_colorsUnused;
  float4 g_colorsClipW;  // row of the matrix that gives clip w
};

// [guide][vertex]: world position [m].
StructuredBuffer<float4> g_colorsPositions : register(t0, space0);
// [guide]: x and y UV of the root, z distance between neighboring roots [m], w change of the UV
// along the surface [1/m].
StructuredBuffer<float4> g_strandUvs : register(t1, space0);
// The engine's, with its mip levels; alpha multiplies the opacity.
Texture2D<float4> g_strandTexture : register(t2, space0);
SamplerState g_strandSampler : register(s0, space0);
// [guide][2]: the UV as the bits of two floats, then linear rgba as two words of two 16-bit unorms.
RWStructuredBuffer<uint2> g_strandColors : register(u0, space0);

// Size of a pixel at a position [m]; 0 behind the eye.
float pixelAt(float3 position) {
  float w = dot(g_colorsClipW.xyz, position) + g_colorsClipW.w;
  return w > 0.0 ? w * g_colorsPixelSize : 0.0;
}

// \param footprint on the surface [m], \param density change of the UV along it [1/m]
float mipLevel(float footprint, float density) {
  const float kRange = 65536.0;  // finite logarithms, beyond all levels
  float texels = footprint * density * g_colorsTexels;
  float level = log2(texels > 1.0 / kRange ? min(texels, kRange) : 1.0 / kRange);
  return clamp(level + g_colorsLodBias, 0.0, g_colorsLastLevel);
}

[numthreads(64, 1, 1)]
void sample_strand_colors(uint3 thread : SV_DispatchThreadID) {
  uint guide = indexOfThread(thread);
  if (guide >= g_colorsGuideCount) return;
  float4 root = g_strandUvs[guide];
  float3 position = g_colorsPositions[guide * g_colorsVertexCount].xyz;
  float footprint = max(root.z * g_colorsSpread, pixelAt(position));
  float4 color = g_strandTexture.SampleLevel(g_strandSampler, root.xy, mipLevel(footprint, root.w));
  g_strandColors[2u * guide] = asuint(root.xy);
  g_strandColors[2u * guide + 1u] = packUnorms(color);
}
