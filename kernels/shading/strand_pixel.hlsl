// Lights a strand's ribbon and covers as much of the pixel as the fibre does, without sorting.
//
// Reads:   RenderConstants, StrandViewConstants, g_shadowWords
// Writes:  SV_Target0 linear colour, alpha 1; SV_Coverage
//
// Coverage: of S samples a pixel, floor(alpha S + d) are written, d in [0, 1) from a hash of strand
// and pixel, so that alpha S are on average (Enderton, Sintorn, Shirley and Luebke, "Stochastic
// transparency", I3D 2010, section 3); which ones, a second hash decides, so that strands behind
// each other do not always hide the same samples. The triangles of one strand in a pixel share the
// samples. Alpha is constant across the ribbon: its edges are sampled by the rasteriser, and a
// fall-off besides would take away area that the fibre has.
// Without STOCHASTIC, the cheapest tier: a fragment is opaque, or left out where its alpha is below
// a threshold of the strand's own, uniform in 0..1 (after Wyman and McGuire, "Hashed alpha testing",
// I3D 2017, with one hash a strand): as many strands are drawn as cover what all do, and no strand
// flickers.
//
// Invariant (tests/golden, tests/kernel): with STOCHASTIC a fibre of w < 1 pixels covers w of every
// pixel's width on average, for 1, 2, 4 and 8 samples.
#include "../common/random_hash.hlsli"
#include "../layouts/render.hlsli"
#include "strand_common.hlsli"
#include "strand_interface.hlsli"
#define SHADOW_WORDS g_shadowWords
#include "light_strand.hlsli"

struct StrandSample {
  float4 color : SV_Target0;
#if STOCHASTIC
  uint coverage : SV_Coverage;
#endif
};

// Mask of about alpha * sampleCount of the samples.
uint coverageMask(float alpha, uint sampleCount, uint hash) {
  uint samples = clamp(sampleCount, 1u, 8u);
  float wanted = saturate(alpha) * float(samples) + unitFloat(hash);
  uint count = min(uint(wanted), samples);
  uint bits = (1u << count) - 1u;
  // Rotate within the sample bits.
  uint turn = hashUint(hash) % samples;
  uint all = (1u << samples) - 1u;
  return ((bits << turn) | (bits >> (samples - turn))) & all;
}

StrandSample strand_pixel(StrandPixel strand) {
  StrandSample result;
  float alpha = strand.ribbon.x * strand.color.a;
#if STOCHASTIC
  uint2 pixel = uint2(strand.clip.xy);
  uint hash = hashUints(strand.strand, hashUints(pixel.x | (pixel.y << 16), g_seed));
  result.coverage = coverageMask(alpha, g_sampleCount, hash);
  // A target with one sample does not look at the mask on every API.
  if (result.coverage == 0u) discard;
#else
  if (!(alpha > unitFloat(hashUint(strand.strand)))) discard;
#endif
  StrandSurface surface = strandSurface(
      fragmentPosition(strand.clip.xy - g_viewport.xy, strand.clip.z), strand.tangent, strand.color.rgb);
  result.color = float4(lightStrand(renderShading(), surface), 1.0);
  return result;
}
