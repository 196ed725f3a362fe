// Writes each fragment of the sampled rows as it is, lit and not packed.
#include "../../kernels/shading/layouts/render.hlsli"
#include "../../kernels/shading/strand_alpha.hlsli"
#define SHADOW_WORDS g_shadowWords
#include "../../kernels/shading/light_strand.hlsli"
#include "sample_fragments_layout.hlsli"

[earlydepthstencil]
void sample_fragments(StrandPixel strand) {
  float alpha = strandAlpha(strand);
  if (!(alpha > 0.0)) return;
  InterlockedAdd(g_sampledCounts[0], 1u);
  uint2 at = uint2(strand.clip.xy - g_viewport.xy);
  if (at.y % max(g_sampleRowStep, 1u) != 0u) return;
  uint place;
  InterlockedAdd(g_sampledCounts[1], 1u, place);
  if (place >= g_sampleCapacity) return;
  SampledFragment fragment;
  fragment.x = at.x;
  fragment.y = at.y;
  fragment.depth = strand.clip.z;
  fragment.alpha = alpha;
  fragment.color = float4(
      lightStrand(renderShading(),
                  strandSurface(fragmentPosition(strand.clip.xy - g_viewport.xy, strand.clip.z),
                                strand.tangent, strand.color.rgb)),
      1.0);
  g_sampled[place] = fragment;
}
