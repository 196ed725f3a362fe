// Transforms a vertex of an iso surface into clip space.
//
// Vertices: one per index that marching cubes wrote.
// Reads:    an IsoVertex (sdf/layouts/sdf_marching_cubes.hlsli) as vertex inputs,
//           RenderMeshConstants
// Writes:   MeshVaryings
//
// Invariant (tests/sdf): the surface appears where its SDF is.
#include "layouts/render_mesh.hlsli"

MeshVaryings iso_surface_vertex([[vk::location(0)]] float4 position : ATTRIBUTE0,
                                [[vk::location(1)]] float4 direction : ATTRIBUTE1) {
  MeshVaryings result;
  float4 homogeneous = float4(position.xyz, 1.0);
  float3 normal = direction.xyz;
  result.position = float3(dot(g_sdfToWorld[0], homogeneous), dot(g_sdfToWorld[1], homogeneous),
                           dot(g_sdfToWorld[2], homogeneous));
  result.normal = float3(dot(g_sdfToWorld[0].xyz, normal), dot(g_sdfToWorld[1].xyz, normal),
                         dot(g_sdfToWorld[2].xyz, normal));
  float4 world = float4(result.position, 1.0);
  result.clip = float4(dot(g_meshToClip[0], world), dot(g_meshToClip[1], world),
                       dot(g_meshToClip[2], world), dot(g_meshToClip[3], world));
  return result;
}
