// Vertex stage of this engine's head. One thread a vertex of the index buffer.
#include "head_layout.hlsli"

HeadVaryings head_vertex(uint index : SV_VertexID) {
  HeadVaryings result = (HeadVaryings)0;
  result.clip = float4(2.0, 2.0, 2.0, 1.0);
  if (index >= g_headVertexCount) return result;
  result.world = g_headPositions[index].xyz;
  result.normal = g_headNormals[index].xyz;
  result.clip = toClip(result.world);
  return result;
}
