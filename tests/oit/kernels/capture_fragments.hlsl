// Writes each fragment of smooth ribbons as it is, lit and not packed.
#include "../../../kernels/shading/strand_alpha.hlsli"
#include "../../../kernels/shading/layouts/render.hlsli"
#define SHADOW_WORDS g_shadowWords
#include "../../../kernels/shading/light_strand.hlsli"
#include "capture_layout.hlsli"

[earlydepthstencil]
void capture_fragments(StrandPixel strand) {
  float alpha = strandAlpha(strand);
  if (!(alpha > 0.0)) return;
  uint index;
  InterlockedAdd(g_capturedCount[0], 1u, index);
  if (index >= g_captureCapacity) return;
  CapturedFragment fragment;
  fragment.x = uint(strand.clip.x - g_viewport.x);
  fragment.y = uint(strand.clip.y - g_viewport.y);
  fragment.depth = strand.clip.z;
  fragment.alpha = alpha;
  float3 light =
      lightStrand(renderShading(),
                  strandSurface(fragmentPosition(strand.clip.xy - g_viewport.xy, strand.clip.z),
                                strand.tangent, strand.color.rgb));
  fragment.color = float4(light, 1.0);
  g_captured[index] = fragment;
}
