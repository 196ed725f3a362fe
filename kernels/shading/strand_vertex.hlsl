// Draws a strand as a ribbon that faces the camera and is at least one pixel wide.
//
// Vertices: one instance a strand, index 2 v + side with side 0 or 1 for the edges at vertex v; an
//           index buffer of 6 (V - 1) indices makes two triangles a segment.
// Reads:    g_renderPositions, g_renderTangents, RenderConstants; with STRAND_THICKNESS
//           g_strandThickness; with FOLLOW_STRANDS g_renderFollowStrands and g_renderRoots
// Writes:   the outputs of StrandPixel.
//
// FOLLOW_STRANDS places the follow strands beside their guides here, as update_follow_strands does
// for buffers that hold them. One without a guide is not drawn.
//
// Invariant (tests/kernel): the ribbon's width in pixels times its coverage is the fibre's width,
// for every distance; nothing is NaN for a tangent along the line of sight or a vertex behind the
// eye.
#include "../common/quaternion.hlsli"
#include "../layouts/render.hlsli"
#include "strand_common.hlsli"
#include "strand_interface.hlsli"

#if FOLLOW_STRANDS
float4 guidePosition(uint guide, uint vertex) {
  return g_renderPositions[guide * g_renderVertexCount + vertex];
}

float3 guideTangent(uint guide, uint vertex) {
  return g_renderTangents[guide * g_renderVertexCount + vertex].xyz;
}

float4 guideRotation(uint guide) {
  RootTransform root = g_renderRoots[guide];
  if (!isPose(root.rotation, root.position.xyz)) root = g_renderRoots[g_renderGuideCount + guide];
  float4 rotation = float4(0.0, 0.0, 0.0, 1.0);
  if (isPose(root.rotation, root.position.xyz)) rotation = normalizeQuaternion(root.rotation);
  return rotation;
}

#include "../common/follow_vertex.hlsli"
#endif

StrandPixel strand_vertex(uint corner : SV_VertexID, uint strand : SV_InstanceID) {
  StrandPixel output;
  output.clip = float4(2.0, 2.0, 2.0, 1.0);
  output.position = float3(0.0, 0.0, 0.0);
  output.tangent = float3(0.0, 1.0, 0.0);
  output.ribbon = float3(0.0, 0.0, 0.0);
  output.strand = strand;
  uint vertex = corner >> 1;
  if (vertex >= g_renderVertexCount || strand >= g_renderStrandCount) return output;

#if FOLLOW_STRANDS
  if (strand < g_renderGuideCount) {
    output.position = guidePosition(strand, vertex).xyz;
    output.tangent = guideTangent(strand, vertex);
  } else {
    FollowStrand follow = g_renderFollowStrands[strand - g_renderGuideCount];
    GuideVertex guides =
        loadGuides(follow.guides, follow.weights, vertex, g_renderVertexCount, g_renderGuideCount);
    if (!guides.known) return output;
    FollowVertex placed =
        followVertex(guides, follow.offset, g_renderTipSeparation, vertex, g_renderVertexCount);
    output.position = placed.position;
    output.tangent = placed.tangent;
  }
#else
  uint index = strand * g_renderVertexCount + vertex;
  output.position = g_renderPositions[index].xyz;
  output.tangent = g_renderTangents[index].xyz;
#endif

  float along = float(vertex) / float(max(g_renderVertexCount, 2u) - 1u);
  float radius = g_fiberRadius * lerp(1.0, g_tipRadiusRatio, along);
#if STRAND_THICKNESS
  radius *= g_strandThickness[strand];
#endif

  StrandView view;
  view.clipX = g_worldToClip[0];
  view.clipY = g_worldToClip[1];
  view.clipZ = g_worldToClip[2];
  view.clipW = g_worldToClip[3];
  view.eye = g_eye.xyz;
  view.viewportSize = g_viewport.zw;

  float side = (corner & 1u) != 0u ? 1.0 : -1.0;
  StrandCorner expanded = expandStrandVertex(view, output.position, output.tangent, radius, side);
  output.clip = expanded.clip;
  output.ribbon = float3(along, expanded.coverage, side);
  return output;
}
