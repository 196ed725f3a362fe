// Composites the list of a pixel: the 8 nearest in order, behind them the others in the order in
// which they left the buffer of the nearest; see classic_list_layout.hlsli.
//
// Writes: SV_Target0 premultiplied colour, alpha = 1 - transmittance
#include "classic_list_packing.hlsli"
#include "classic_list_read_layout.hlsli"
#define SHADOW_WORDS g_classicShadowWords
#include "../../kernels/shading/light_strand.hlsli"

static const uint kNearest = 8u;
static const uint kMostFragments = 512u;

struct ClassicFragment {
  uint depth;    // bits of a float that is not negative
  uint tangent;  // and coverage
  uint color;
};

struct ClassicSum {
  float3 light;
  float transmittance;
};

// Blends a fragment over the sum.
void blendOver(inout ClassicSum sum, ClassicFragment fragment, float2 pixel) {
  float4 tangent = unpackBytes(fragment.tangent);
  float3 position = fragmentPosition(pixel - g_viewport.xy, asfloat(fragment.depth));
  StrandShading material = shadingFrom(g_classicModel, g_classicBody, g_classicPrimary,
                                       g_classicSecondary, g_classicFiber);
  float3 light = lightStrand(
      material, strandSurface(position, tangent.xyz * 2.0 - 1.0, unpackBytes(fragment.color).rgb));
  sum.light = sum.light * (1.0 - tangent.w) + light * tangent.w;
  sum.transmittance *= 1.0 - tangent.w;
}

struct ClassicTarget {
  float4 color : SV_Target0;
};

ClassicTarget classic_list_read(ClassicListPixel given) {
  ClassicTarget result;
  result.color = float4(0.0, 0.0, 0.0, 0.0);
  int2 at = int2(given.clip.xy) - int2(g_viewport.xy);
  bool inside =
      at.x >= 0 && at.y >= 0 && uint(at.x) < g_classicReadWidth && uint(at.y) < g_classicReadHeight;
  uint next = inside ? g_classicReadHeads[uint(at.y) * g_classicReadWidth + uint(at.x)] : 0u;
  if (next == 0u) discard;

  // Empty slots are at the far plane, and let all through.
  ClassicFragment nearest[8];
  for (uint slot = 0u; slot < kNearest; ++slot) {
    nearest[slot].depth = asuint(1.0);
    nearest[slot].tangent = 0u;
    nearest[slot].color = 0u;
  }
  ClassicSum sum;
  sum.light = float3(0.0, 0.0, 0.0);
  sum.transmittance = 1.0;
  uint seen = 0u;
  uint farthest = 0u;
  uint farthestDepth = asuint(1.0);
  while (next != 0u && next <= g_classicReadCapacity && seen < kMostFragments) {
    uint4 node = g_classicReadNodes[next - 1u];
    next = node.x;
    ClassicFragment fragment;
    fragment.depth = node.y;
    fragment.tangent = node.z;
    fragment.color = node.w;
    bool fills = seen < kNearest;
    if (fills || fragment.depth < farthestDepth) {
      uint place = fills ? seen : farthest;
      ClassicFragment left = nearest[place];
      nearest[place] = fragment;
      fragment = left;
      if (seen + 1u >= kNearest) {
        farthest = 0u;
        farthestDepth = nearest[0].depth;
        for (uint i = 1u; i < kNearest; ++i) {
          if (nearest[i].depth > farthestDepth) {
            farthest = i;
            farthestDepth = nearest[i].depth;
          }
        }
      }
    }
    if (!fills) blendOver(sum, fragment, given.clip.xy);
    ++seen;
  }
  // From back to front: the farthest one that is left, as often as there are slots.
  for (uint turn = 0u; turn < kNearest; ++turn) {
    uint back = 0u;
    uint depth = nearest[0].depth;
    for (uint i = 1u; i < kNearest; ++i) {
      if (nearest[i].depth > depth) {
        back = i;
        depth = nearest[i].depth;
      }
    }
    blendOver(sum, nearest[back], given.clip.xy);
    nearest[back].depth = 0u;
  }
  result.color = float4(sum.light, 1.0 - sum.transmittance);
  return result;
}
