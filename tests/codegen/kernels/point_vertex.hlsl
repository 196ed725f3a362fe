#include "draw.hlsli"

PointOutput point_vertex(uint vertex : SV_VertexID, uint instance : SV_InstanceID) {
  const float4 p = float4(g_points[vertex].xyz, 1.0 + float(instance));
  PointOutput output;
  output.clip = float4(dot(g_worldToClip[0], p), dot(g_worldToClip[1], p), dot(g_worldToClip[2], p),
                       dot(g_worldToClip[3], p));
  output.color = g_color;
  return output;
}
