// Samples a texture of an engine at the roots of the guides, for the colors of strands in a view.
//
// Threads: one per guide, in rows of 2^20.
// Reads:   g_colorsPositions, g_strandUvs, g_strandTexture through g_strandSampler
// Writes:  g_strandColors
//
// A strand takes one color, so that nothing along it says how much of the texture the color stands
// for. The mip level is that of the larger of two footprints on the surface: the distance to the
// neighboring roots, between which no strand shows the texture, and a pixel of the view at the
// root, within which strands are averaged.
//
// Invariant (tests/shading): log2 of that footprint in texels, plus the bias, within the levels
// that there are; NaN takes level 0.
#include "layouts/strand_colors.hlsli"
#include "../base/dispatch.hlsli"
#include "color_packing.hlsli"

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
  float4 color =
      g_strandTexture.SampleLevel(g_strandSampler, root.xy, mipLevel(footprint, root.w));
  g_strandColors[2u * guide] = asuint(root.xy);
  g_strandColors[2u * guide + 1u] = packUnorms(color);
}
