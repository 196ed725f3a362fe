// Vertex stage of this engine's body. One thread a vertex of the index buffer.
#include "body_layout.hlsli"

BodyVaryings body_vertex(BodyVertex vertex) {
  BodyVaryings result;
  float4 p = float4(vertex.position.xyz, 1.0);
  result.clip = float4(dot(g_bodyRows[0], p), dot(g_bodyRows[1], p), dot(g_bodyRows[2], p),
                       dot(g_bodyRows[3], p));
  result.world = vertex.position.xyz;
  result.normal = vertex.normal.xyz;
  return result;
}
