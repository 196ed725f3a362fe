// Puts the vertices of an object's strands on the screen, as strand_vertex does with SMOOTH.
//
// Threads: one a vertex, in rows of kStrandDispatchRow.
// Reads:   as strand_vertex
// Writes:  g_binRecords from g_binFirstRecord on
#include "../../layouts/render.hlsli"
#include "../../layouts/strand_tiles.hlsli"
#include "../../shading/drawn_fiber.hlsli"
#include "strand_record.hlsli"
#include "strand_tile_counters.hlsli"

// x and y [pixels], of a vertex that is not in front of the eye times w. Steps as a rasteriser's,
// so that both round to the same place.
float2 placeOfClip(float4 clip) {
  float2 turned = float2(clip.x, -clip.y);
  float2 extent = g_viewport.zw * 0.5;
  float2 place = turned * extent + clip.w * extent;
  if (clip.w > kLeastClipW) place = turned * (1.0 / clip.w) * extent + extent;
  return place;
}

[numthreads(128, 1, 1)]
void transform_strands(uint3 group : SV_GroupID, uint lane : SV_GroupIndex) {
  uint index = group.y * kStrandDispatchRow + group.x * 128u + lane;
  if (index >= g_binObjectRecords) return;
  uint at = g_binFirstRecord + index;
  if (at >= g_binRecordCount) return;
  uint strand = index / g_renderVertexCount;
  uint vertex = index - strand * g_renderVertexCount;

  uint4 corners = uint4(0u, 0u, 0u, 0u);
  uint4 shape = uint4(0u, 0u, 0u, 0u);
  uint4 look = uint4(0u, 0u, 0u, 0u);
  DrawnFiber fiber = drawnFiber(strand, vertex);
  if (fiber.known) {
    StrandView view = renderView();
    StrandRibbon low =
        expandStrandRibbon(view, fiber.position, fiber.tangent, fiber.radius, -1.0);
    StrandRibbon high =
        expandStrandRibbon(view, fiber.position, fiber.tangent, fiber.radius, 1.0);
    float w = low.clip.w;
    uint flags = kRecordDrawn | min(g_materialIndex, kRecordMaterial);
    if (vertex + 1u < g_renderVertexCount) flags |= kRecordStartsSegment;
    if (high.distance > 0.0) flags |= kRecordWide;
    corners = uint4(asuint(placeOfClip(low.clip)), asuint(placeOfClip(high.clip)));
    shape = uint4(asuint(low.clip.z), asuint(w), asuint(low.halfWidth), flags);
    look = uint4(packDirection(fiber.tangent), packHalves(fiber.color.rg),
                 packHalves(float2(fiber.color.b, saturate(fiber.color.a))), 0u);
  }
  g_binRecords[kRecordWords * at] = corners;
  g_binRecords[kRecordWords * at + 1u] = shape;
  g_binRecords[kRecordWords * at + 2u] = look;
}
