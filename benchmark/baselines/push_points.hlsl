// Classic baseline of distance fields, collision (field_layout.hlsli).
// Threads: one a vertex. Reads g_fieldKeys; writes g_points, g_pointsBefore.
#include "field_layout.hlsli"

float nodeDistance(uint3 node) {
  return asfloat(g_fieldKeys[node.x + g_fieldNodes.x * (node.y + g_fieldNodes.y * node.z)]);
}

// Trilinear; kNothing outside the grid.
float sampleDistance(float3 p) {
  float3 cells = (p - g_fieldOrigin.xyz) / g_fieldOrigin.w;
  float3 last = float3(g_fieldNodes.xyz) - 1.0;
  if (any(cells < 0.0) || any(cells >= last)) return kNothing;
  float3 corner = floor(cells);
  float3 t = cells - corner;
  uint3 n = uint3(corner);
  float4 low = float4(nodeDistance(n), nodeDistance(n + uint3(1, 0, 0)),
                      nodeDistance(n + uint3(0, 1, 0)), nodeDistance(n + uint3(1, 1, 0)));
  float4 high = float4(nodeDistance(n + uint3(0, 0, 1)), nodeDistance(n + uint3(1, 0, 1)),
                       nodeDistance(n + uint3(0, 1, 1)), nodeDistance(n + uint3(1, 1, 1)));
  float4 plane = lerp(low, high, t.z);
  float2 row = lerp(plane.xy, plane.zw, t.y);
  return lerp(row.x, row.y, t.x);
}

[numthreads(64, 1, 1)]
void push_points(uint3 thread : SV_DispatchThreadID) {
  uint index = nodeOf(thread);
  if (index >= g_pointCount) return;
  float4 place = g_points[index];
  if (!(place.w > 0.0)) return;
  float here = sampleDistance(place.xyz);
  if (here >= g_margin) return;
  float ahead = 0.1 * g_fieldOrigin.w;
  float3 gradient = float3(sampleDistance(place.xyz + float3(ahead, 0.0, 0.0)),
                           sampleDistance(place.xyz + float3(0.0, ahead, 0.0)),
                           sampleDistance(place.xyz + float3(0.0, 0.0, ahead))) -
                    here;
  float steep = length(gradient);
  if (!(steep > 0.0)) return;
  place.xyz += gradient * ((g_margin - here) / steep);
  g_points[index] = place;
  g_pointsBefore[index] = place;
}
