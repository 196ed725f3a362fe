// Draws a segment of a strand as a ribbon of some pixels, with the value of its vertices.
//
// Vertices: one instance per record but the last one, and of each a strip of 4 vertices. The last
//           vertex of a strand starts no segment; its instance is outside of the picture.
// Reads:    two records in a row as vertex inputs, DrawValuesConstants
// Writes:   ValueVaryings
//
// Invariant (viewer_test): a segment without values, or with an end behind the eye, has no pixel.
#include "draw_values.hlsli"
#include "strand_value.hlsli"

float4 toClip(float3 position) {
  float4 p = float4(position, 1.0);
  return float4(dot(g_valuesToClip[0], p), dot(g_valuesToClip[1], p), dot(g_valuesToClip[2], p),
                dot(g_valuesToClip[3], p));
}

ValueVaryings value_vertex([[vk::location(0)]] float4 first : ATTRIBUTE0,
                           [[vk::location(1)]] float4 second : ATTRIBUTE1,
                           uint corner : SV_VertexID, uint index : SV_InstanceID) {
  ValueVaryings result;
  result.clip = float4(2.0, 2.0, 2.0, 1.0);
  result.value = 0.0;
  uint vertex = index % g_valueVertexCount;
  if (vertex + 1u >= g_valueVertexCount) return result;
  if (!(abs(first.w) < kMostValue) || !(abs(second.w) < kMostValue)) return result;
  float4 from = toClip(first.xyz);
  float4 to = toClip(second.xyz);
  if (!(from.w > 1e-6) || !(to.w > 1e-6)) return result;

  float2 halfSize = g_valueArea.zw * 0.5;
  float2 along = (to.xy / to.w - from.xy / from.w) * halfSize;
  float2 across = float2(1.0, 0.0);
  float squared = dot(along, along);
  if (squared > 1e-12) across = float2(-along.y, along.x) * rsqrt(squared);
  bool atEnd = corner >= 2u;
  float4 clip = atEnd ? to : from;
  float share = float(vertex + (atEnd ? 1u : 0u)) / float(g_valueVertexCount - 1u);
  float radius = g_valueRadius * lerp(1.0, g_valueTipRatio, share) * g_valueFocal / clip.w;
  float side = (corner & 1u) == 0u ? -1.0 : 1.0;
  clip.xy += across / halfSize * (side * max(radius, 0.5 * g_valueWidth) * clip.w);
  result.clip = clip;
  result.value = atEnd ? second.w : first.w;
  return result;
}
