// Samples of a pixel that a fragment covers, for the project's kernels and for an engine's own: no
// resources.
//
// A fragment writes floor(alpha S + d) of S samples per pixel, with d in [0, 1) from a hash of
// strand and pixel, so that the mean is alpha S (Enderton, Sintorn, Shirley and Luebke, "Stochastic
// transparency", I3D 2010, section 3). A second hash selects them, so that strands behind each
// other do not always hide the same samples. The triangles of one strand in a pixel share the
// samples. Alpha is constant across the ribbon: the rasterizer samples its edges, and an additional
// fall-off would remove area from the fiber.
#ifndef PELAGE_SHADING_STRAND_COVERAGE_HLSLI
#define PELAGE_SHADING_STRAND_COVERAGE_HLSLI

#include "../base/random_hash.hlsli"

// Returns a mask for SV_Coverage. Discard the fragment if it is 0: on some APIs a target with one
// sample ignores the mask.
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
