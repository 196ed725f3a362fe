// Draws a strand as a ribbon that faces the camera and is at least one pixel wide.
//
// Vertices: one instance a strand, index 2 v + side with side 0 or 1 for the edges at vertex v; an
//           index buffer of 6 (V - 1) indices makes two triangles a segment.
// Reads:    g_renderPositions, g_renderTangents, RenderConstants; with STRAND_THICKNESS
//           g_strandThickness
// Writes:   the outputs of StrandPixel.
//
// Invariant (tests/kernel): the ribbon's width in pixels times its coverage is the fibre's width,
// for every distance; nothing is NaN for a tangent along the line of sight or a vertex behind the
// eye.
#include "../layouts/render.hlsli"
#include "strand_common.hlsli"
#include "strand_interface.hlsli"

StrandPixel strand_vertex(uint corner : SV_VertexID, uint strand : SV_InstanceID) {
  StrandPixel output;
  output.clip = float4(2.0, 2.0, 2.0, 1.0);
  output.position = float3(0.0, 0.0, 0.0);
  output.tangent = float3(0.0, 1.0, 0.0);
  output.ribbon = float3(0.0, 0.0, 0.0);
  output.strand = strand;
  uint vertex = corner >> 1;
  if (vertex >= g_renderVertexCount || strand >= g_renderStrandCount) return output;

  uint index = strand * g_renderVertexCount + vertex;
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
  output.position = g_renderPositions[index].xyz;
  output.tangent = g_renderTangents[index].xyz;
  StrandCorner expanded = expandStrandVertex(view, output.position, output.tangent, radius, side);
  output.clip = expanded.clip;
  output.ribbon = float3(along, expanded.coverage, side);
  return output;
}
