// Draws a strand as a ribbon that faces the camera.
//
// Vertices: one instance per strand, index 2 v + side with side 0 or 1 for the edges at vertex v;
//           an index buffer of 6 (V - 1) indices makes two triangles per segment.
// Reads:    g_renderPositions, g_renderTangents, RenderConstants, StrandViewConstants; with
//           g_evaluatesFollows g_renderFollowHairRecords and g_renderRoots; with ATTRIBUTES those
//           of g_strandThickness, g_vertexColors and g_baseTexture that the object has, and
//           g_renderFollowHairRecords for the colors of follow hairs
// Writes:   the outputs of StrandPixel.
//
// With g_evaluatesFollows it computes the follow hairs from their guides, as update_follow_hairs
// does for buffers that store them. A follow hair without a guide is not drawn. SMOOTH makes the
// ribbon a pixel wider than the fiber, for kernels that compute the coverage of a pixel; without it
// the ribbon is as wide as the fiber, but at least one pixel. The last g_fadingStrands of the drawn
// strands get narrower, down to zero; all are wider by g_strandWidening.
//
// Invariant (tests/shading): the ribbon's width in pixels times its coverage is the fiber's width,
// for every distance; nothing is NaN for a tangent along the line of sight or a vertex behind the
// eye.
#include "layouts/render.hlsli"
#include "drawn_fiber.hlsli"
#include "strand_common.hlsli"
#include "strand_interface.hlsli"

StrandPixel strand_vertex(uint corner : SV_VertexID, uint strand : SV_InstanceID) {
  StrandPixel result = hiddenStrandPixel(strand);
  uint vertex = corner >> 1;
  if (vertex >= g_renderVertexCount || strand >= g_renderStrandCount) return result;

  DrawnFiber fiber = drawnFiber(strand, vertex);
  if (!fiber.known) return result;
  result.tangent = fiber.tangent;
  result.color = fiber.color;
#if STRAND_UV
  result.uv = fiber.uv;
#endif

  StrandView view = renderView();
  float side = (corner & 1u) != 0u ? 1.0 : -1.0;
#if SMOOTH
  StrandRibbon ribbon = expandStrandRibbon(view, fiber.position, fiber.tangent, fiber.radius, side);
  result.clip = ribbon.clip;
  result.ribbon = float3(ribbon.distance, ribbon.halfWidth, 1.0) * ribbon.clip.w;
#else
  StrandCorner expanded =
      expandStrandVertex(view, fiber.position, fiber.tangent, fiber.radius, side);
  result.clip = expanded.clip;
  result.ribbon = float3(expanded.coverage, 0.0, 1.0);
#endif
  return result;
}
