// Draws triangles whose clip positions are in a buffer, each instance with a shift of its own.
//
// One thread a vertex.
// Reads g_corners, g_shifts.
// Invariant: its pixel kernel may be of a group that has the first layouts only.
#include "runtime_record.hlsli"

float4 shift_vertex(uint vertex : SV_VertexID, uint instance : SV_InstanceID) : SV_Position {
  return g_corners[vertex] + g_shifts[instance];
}
