// Lights a strand's ribbon and covers as much of the pixel as the fiber does, without sorting.
//
// Reads:   RenderConstants, StrandViewConstants, g_shadowWords
// Writes:  SV_Target0 linear color, alpha 1; SV_Coverage
//
// With STOCHASTIC it writes as many samples as the fiber covers: strand_coverage.hlsli. Without
// STOCHASTIC, the cheapest method: a fragment is opaque, or discarded if its alpha is below the
// strand's threshold, uniform in 0..1 (after Wyman and McGuire, "Hashed alpha testing", I3D 2017,
// with one hash per strand): the number of drawn strands matches the coverage of all, and no strand
// flickers.
//
// Invariant (tests/golden, tests/shading): with STOCHASTIC a fiber of w < 1 pixels covers w of
// every pixel's width on average, for 1, 2, 4 and 8 samples.
#include "../base/random_hash.hlsli"
#include "layouts/render.hlsli"
#include "strand_common.hlsli"
#include "strand_coverage.hlsli"
#include "strand_interface.hlsli"
#define SHADOW_WORDS g_shadowWords
#include "light_strand.hlsli"
#include "pixel_surface.hlsli"

struct StrandSample {
  float4 color : SV_Target0;
#if STOCHASTIC
  uint coverage : SV_Coverage;
#endif
};

StrandSample strand_pixel(StrandPixel strand) {
  StrandSample result;
  float alpha = strand.ribbon.x * strand.color.a;
  float2 pixel = strand.clip.xy - g_viewport.xy;
#if STOCHASTIC
  result.coverage = strandSamples(alpha, g_sampleCount, strand.strand, pixel, g_seed);
  if (result.coverage == 0u) discard;
#else
  if (!(alpha > unitFloat(hashUint(strand.strand)))) discard;
#endif
  StrandSurface surface = pixelSurface(strand, strand.color.rgb);
  result.color = float4(lightStrand(renderShading(), surface), 1.0);
  return result;
}
