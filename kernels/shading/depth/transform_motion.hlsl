// Adds the motion of vertices to what transform_strands has written: for devices whose vertex stage
// reads no storage buffers (motion_record_vertex).
//
// Threads: one per vertex, in rows of kRecordDispatchRow.
// Reads:   g_renderPositions, g_previousPositions, g_motionRecords; with FOLLOWS
//          g_renderFollowHairRecords and g_renderRoots
// Writes:  of each record in g_motionRecords the third word: the change of clip x and y as floats,
//          z as it was, and the change of clip w. Tangent and color make room for it, of which only
//          the opacity is still needed.
//
// Invariant (tests/shading): the same motion as from strand_motion_vertex.
#include "strand_motion.hlsli"
#include "../strand_record.hlsli"

[numthreads(128, 1, 1)]
void transform_motion(uint3 group : SV_GroupID, uint lane : SV_GroupIndex) {
  uint index = group.y * kRecordDispatchRow + group.x * 128u + lane;
  if (index >= g_motionRecordCount) return;
  uint4 shape = g_motionRecords[kRecordWords * index + 1u];
  if ((shape.w & kRecordDrawn) == 0u) return;
  uint strand = index / g_renderVertexCount;
  uint vertex = index - strand * g_renderVertexCount;
  DrawnVertex drawn = finiteVertex(strand, vertex);
  float3 change = float3(0.0, 0.0, 0.0);
  if (drawn.known)
    change = clipMotion(drawn.position, previousPosition(strand, vertex, drawn.position));
  uint4 look = g_motionRecords[kRecordWords * index + 2u];
  g_motionRecords[kRecordWords * index + 2u] =
      uint4(asuint(change.x), asuint(change.y), look.z, asuint(change.z));
}
