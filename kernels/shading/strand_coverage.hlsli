// Which samples of a pixel a fragment covers, for the project's kernels and for an engine's own: no
// resources.
//
// Of S samples a pixel, floor(alpha S + d) are written, d in [0, 1) from a hash of strand and
// pixel, so that alpha S are on average (Enderton, Sintorn, Shirley and Luebke, "Stochastic
// transparency", I3D 2010, section 3); which ones, a second hash decides, so that strands behind
// each other do not always hide the same samples. The triangles of one strand in a pixel share the
// samples. Alpha is constant across the ribbon: its edges are sampled by the rasteriser, and a
// fall-off besides would take away area that the fibre has.
#ifndef PELAGE_SHADING_STRAND_COVERAGE_HLSLI
#define PELAGE_SHADING_STRAND_COVERAGE_HLSLI

#include "../common/random_hash.hlsli"

// For SV_Coverage. Discard where it is 0: a target with one sample does not look at the mask on
// every API.
// \param alpha opacity times the ribbon's coverage, 0..1, \param sampleCount 1..8
// \param strand its index, \param pixel SV_Position.xy within the viewport,
// \param seed constant for a still image
uint strandSamples(float alpha, uint sampleCount, uint strand, float2 pixel, uint seed) {
  uint2 at = uint2(pixel);
  uint hash = hashUints(strand, hashUints(at.x | (at.y << 16), seed));
  uint samples = clamp(sampleCount, 1u, 8u);
  float wanted = saturate(alpha) * float(samples) + unitFloat(hash);
  uint count = min(uint(wanted), samples);
  uint bits = (1u << count) - 1u;
  // Rotate within the sample bits.
  uint turn = hashUint(hash) % samples;
  uint all = (1u << samples) - 1u;
  return ((bits << turn) | (bits >> (samples - turn))) & all;
}

#endif
