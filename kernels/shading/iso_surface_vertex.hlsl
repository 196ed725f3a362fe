// Puts a vertex of an iso surface into clip space.
//
// Vertices: one an index that marching cubes wrote.
// Reads:    g_meshVertices, RenderMeshConstants
// Writes:   MeshVaryings
//
// Invariant (tests/kernel): the surface appears where its field is; an index out of range is
// outside the picture.
#include "../layouts/render_mesh.hlsli"

MeshVaryings iso_surface_vertex(uint index : SV_VertexID) {
  MeshVaryings result;
  result.clip = float4(2.0, 2.0, 2.0, 1.0);
  result.position = float3(0.0, 0.0, 0.0);
  result.normal = float3(0.0, 1.0, 0.0);
  if (index >= g_meshVertexCount) return result;

  float4 place = float4(g_meshVertices[index].position.xyz, 1.0);
  float3 normal = g_meshVertices[index].normal.xyz;
  result.position = float3(dot(g_fieldToWorld[0], place), dot(g_fieldToWorld[1], place),
                           dot(g_fieldToWorld[2], place));
  result.normal =
      float3(dot(g_fieldToWorld[0].xyz, normal), dot(g_fieldToWorld[1].xyz, normal),
             dot(g_fieldToWorld[2].xyz, normal));
  float4 world = float4(result.position, 1.0);
  result.clip = float4(dot(g_meshToClip[0], world), dot(g_meshToClip[1], world),
                       dot(g_meshToClip[2], world), dot(g_meshToClip[3], world));
  return result;
}
