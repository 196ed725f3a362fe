// Transforms the vertices of an object's strands to the screen, as strand_vertex does with SMOOTH:
// for methods without the rasterizer, and for devices whose vertex stage reads no storage buffers
// (strand_record_vertex).
//
// Threads: one per vertex, in rows of kRecordDispatchRow.
// Reads:   as strand_vertex; with FOLLOWS, for objects whose follow hairs are not stored, also
//          g_renderFollowHairRecords and g_renderRoots
// Writes:  g_strandRecords from g_firstRecord on
#include "layouts/render.hlsli"
#include "drawn_fiber.hlsli"
#include "strand_record.hlsli"

cbuffer StrandRecordsConstants : register(b0, space2) {
  uint g_recordCapacity;  // of g_strandRecords, in records
  uint g_firstRecord;     // of this object
  uint g_objectRecords;   // of this object
  uint g_recordPad0;
};

// [vertex][3], see shading/strand_record.hlsli.
RWStructuredBuffer<uint4> g_strandRecords : register(u0, space2);

// x and y [pixels], times w for a vertex that is not in front of the eye. The steps are those of a
// rasterizer, so that both round to the same position.
float2 pointOfClip(float4 clip) {
  float2 turned = float2(clip.x, -clip.y);
  float2 extent = g_viewport.zw * 0.5;
  float2 coordinate = turned * extent + clip.w * extent;
  if (clip.w > kMinClipW) coordinate = turned * (1.0 / clip.w) * extent + extent;
  return coordinate;
}

[numthreads(128, 1, 1)]
void transform_strands(uint3 group : SV_GroupID, uint lane : SV_GroupIndex) {
  uint index = group.y * kRecordDispatchRow + group.x * 128u + lane;
  if (index >= g_objectRecords) return;
  uint at = g_firstRecord + index;
  if (at >= g_recordCapacity) return;
  uint strand = index / g_renderVertexCount;
  uint vertex = index - strand * g_renderVertexCount;

  uint4 corners = uint4(0u, 0u, 0u, 0u);
  uint4 shape = uint4(0u, 0u, 0u, 0u);
  uint4 look = uint4(0u, 0u, 0u, 0u);
  DrawnFiber fiber = drawnFiber(strand, vertex);
  if (fiber.known) {
    StrandView view = renderView();
    StrandRibbon low = expandStrandRibbon(view, fiber.position, fiber.tangent, fiber.radius, -1.0);
    StrandRibbon high = expandStrandRibbon(view, fiber.position, fiber.tangent, fiber.radius, 1.0);
    float w = low.clip.w;
    uint flags = kRecordDrawn | min(g_materialIndex, kRecordMaterial);
    if (vertex + 1u < g_renderVertexCount) flags |= kRecordStartsSegment;
    if (high.distance > 0.0) flags |= kRecordWide;
    corners = uint4(asuint(pointOfClip(low.clip)), asuint(pointOfClip(high.clip)));
    shape = uint4(asuint(low.clip.z), asuint(w), asuint(low.halfWidth), flags);
    look = uint4(packDirection(fiber.tangent), packHalves(fiber.color.rg),
                 packHalves(float2(fiber.color.b, saturate(fiber.color.a))), packUv(fiber.uv));
  }
  g_strandRecords[kRecordWords * at] = corners;
  g_strandRecords[kRecordWords * at + 1u] = shape;
  g_strandRecords[kRecordWords * at + 2u] = look;
}
