// Vertex stage of an engine's own hair shader. One instance a strand; HairBuffers::indices makes
// two triangles a segment of the vertices 2 v and 2 v + 1, the two edges of the ribbon at vertex v.
#include "hair_layout.hlsli"
#include "shading/strand_common.hlsli"

StrandView engineView() {
  StrandView view;
  view.clipX = g_cameraRows[0];
  view.clipY = g_cameraRows[1];
  view.clipZ = g_cameraRows[2];
  view.clipW = g_cameraRows[3];
  view.eye = g_cameraEye.xyz;
  view.viewportSize = g_cameraTarget.xy;
  return view;
}

HairVaryings hair_vertex(uint corner : SV_VertexID, uint strand : SV_InstanceID) {
  // Never read past the buffers: such a corner goes outside of the picture.
  HairVaryings result = (HairVaryings)0;
  result.clip = float4(2.0, 2.0, 2.0, 1.0);
  uint vertex = corner >> 1;
  if (vertex >= g_lookVertexCount || strand >= g_lookStrandCount) return result;

  uint at = strand * g_lookVertexCount + vertex;
  float along = float(vertex) / float(g_lookVertexCount - 1u);
  result.world = g_hairPositions[at].xyz;
  result.tangent = g_hairTangents[at].xyz;
  result.color = lerp(g_lookRoot.rgb, g_lookTip.rgb, along);
  result.strand = strand;

  // pelage: a ribbon that faces the camera, never thinner than a pixel. What it is too wide comes
  // back as coverage.
  float radius = lerp(g_lookRootRadius, g_lookTipRadius, along);
  float side = (corner & 1u) != 0u ? 1.0 : -1.0;
  StrandCorner expanded =
      expandStrandVertex(engineView(), result.world, result.tangent, radius, side);
  result.clip = expanded.clip;
  result.alpha = expanded.coverage * g_lookRoot.a;
  return result;
}
