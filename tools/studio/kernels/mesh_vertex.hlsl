// Skins a mesh and puts it into clip space.
//
// One thread a vertex of the index buffer. Reads its inputs and the constants; writes nothing but
// its varyings.
// Invariant: with all bones the same rigid motion, every vertex moves by that motion.
#include "mesh.hlsli"

void addBone(uint bone, float weight, inout float4 row0, inout float4 row1, inout float4 row2) {
  if (weight <= 0.0 || bone >= g_meshBoneCount) return;
  row0 += weight * g_meshBones[3 * bone];
  row1 += weight * g_meshBones[3 * bone + 1];
  row2 += weight * g_meshBones[3 * bone + 2];
}

MeshVaryings mesh_vertex(MeshVertex v) {
  MeshVaryings result;
  float4 row0 = float4(0.0, 0.0, 0.0, 0.0);
  float4 row1 = row0;
  float4 row2 = row0;
  addBone(v.bones.x, v.weights.x, row0, row1, row2);
  addBone(v.bones.y, v.weights.y, row0, row1, row2);
  addBone(v.bones.z, v.weights.z, row0, row1, row2);
  addBone(v.bones.w, v.weights.w, row0, row1, row2);

  float4 bind = float4(v.position.xyz, 1.0);
  float4 world = float4(dot(row0, bind), dot(row1, bind), dot(row2, bind), 1.0);
  result.clip = float4(dot(g_worldToClip[0], world), dot(g_worldToClip[1], world),
                       dot(g_worldToClip[2], world), dot(g_worldToClip[3], world));
  result.world = world.xyz;
  result.normal =
      float3(dot(row0.xyz, v.normal.xyz), dot(row1.xyz, v.normal.xyz), dot(row2.xyz, v.normal.xyz));
  result.covered = float2(v.position.w, v.normal.w);
  return result;
}
