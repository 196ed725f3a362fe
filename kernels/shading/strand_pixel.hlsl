// Lights a strand's ribbon and covers as much of the pixel as the fibre does, without sorting.
//
// Reads:   RenderConstants
// Writes:  SV_Target0 linear colour, alpha 1; SV_Coverage
//
// Light: Kajiya-Kay diffuse and two shifted highlights, the second in the hair's colour.
// Coverage: of S samples a pixel, floor(alpha S + d) are written, d in [0, 1) from a hash of strand
// and pixel, so that alpha S are on average (Enderton, Sintorn, Shirley and Luebke, "Stochastic
// transparency", I3D 2010, section 3); which ones, a second hash decides, so that strands behind
// each other do not always hide the same samples. The triangles of one strand in a pixel share the
// samples. Alpha is constant across the ribbon: its edges are sampled by the rasteriser, and a
// fall-off besides would take away area that the fibre has.
//
// Invariant (tests/golden, tests/kernel): a fibre of w < 1 pixels covers w of every pixel's width
// on average, for 1, 2, 4 and 8 samples.
#include "../common/random_hash.hlsli"
#include "../layouts/render.hlsli"
#include "strand_common.hlsli"
#include "strand_interface.hlsli"

struct StrandSample {
  float4 color : SV_Target0;
  uint coverage : SV_Coverage;
};

// Light that strands differ by around the mean, as a share of it: enough to tell neighbours apart,
// from 0.3 on a groom looks dyed.
static const float kStrandVariation = 0.15;

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

StrandSample strand_pixel(StrandPixel input) {
  StrandSample output;
  uint2 pixel = uint2(input.clip.xy);
  uint hash = hashUints(input.strand, hashUints(pixel.x | (pixel.y << 16), g_seed));
  output.coverage = coverageMask(input.ribbon.y * g_rootColor.a, g_sampleCount, hash);
  // A target with one sample does not look at the mask on every API.
  if (output.coverage == 0u) discard;

  float3 tangent = input.tangent * (1.0 / sqrt(max(dot(input.tangent, input.tangent), 1e-12)));
  float3 toEye = g_eye.xyz - input.position;
  toEye *= 1.0 / sqrt(max(dot(toEye, toEye), 1e-20));
  float3 toLight = g_lightDirection.xyz;
  float3 normal = toEye - tangent * dot(tangent, toEye);
  normal *= 1.0 / sqrt(max(dot(normal, normal), 1e-12));

  float random = unitFloat(hashUint(input.strand)) * 2.0 - 1.0;
  float3 hair = lerp(g_rootColor.rgb, g_tipColor.rgb, saturate(input.ribbon.x)) *
                (1.0 + kStrandVariation * random);
  float primary = g_specular.x * fiberSpecular(tangent, normal, toLight, toEye, g_specularShift.x,
                                               g_specular.y);
  float secondary = g_specular.z * fiberSpecular(tangent, normal, toLight, toEye,
                                                 g_specularShift.y, g_specular.w);
  float3 light = g_lightColor.rgb * (hair * (fiberDiffuse(tangent, toLight) + secondary) +
                                     float3(primary, primary, primary));
  output.color = float4(g_ambientColor.rgb * hair + light, 1.0);
  return output;
}
