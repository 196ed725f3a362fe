// Samples a field of accelerations of an engine at the guides' vertices.
//
// Threads: one per vertex, in rows of 2^20.
// Reads:   g_fieldPositions, g_fieldValues; with g_fieldAddsForces g_fieldOthers
// Writes:  g_fieldForces
// Run it once a simulated frame, before the solver.
//
// Invariant (tests/simulation): a field with the same value at all nodes gives this value, to the
// bit, in the whole grid; outside of the grid, and where a node or a position is not usable, the
// field adds nothing.
#include "../base/dispatch.hlsli"
#include "../base/quaternion.hlsli"

cbuffer ForceFieldConstants : register(b0, space0) {
  uint g_fieldVertexCount;  // elements of g_fieldPositions and g_fieldForces; first: decision 0008
  uint g_fieldAddsForces;   // 0 or 1: g_fieldOthers are added
  uint g_fieldFirst;        // element of node 0 in g_fieldValues
  uint g_fieldKnown;        // 0: there are no positions yet, and the field gives nothing
  float4 g_fieldOrigin;     // xyz of node 0 in world space [m]; w = cell size [m]
  uint4 g_fieldNodes;       // xyz along the axes, each >= 2; w unused
};

// [strand][vertex] of the guides: world position [m]; w unused.
StructuredBuffer<float4> g_fieldPositions : register(t0, space0);
// [z][y][x]: xyz acceleration [m/s2], w drag [1/s].
StructuredBuffer<float4> g_fieldValues : register(t1, space0);
// [strand][vertex]: forces of setForces(); only read with g_fieldAddsForces.
StructuredBuffer<float4> g_fieldOthers : register(t2, space0);
// [strand][vertex]: the sum.
RWStructuredBuffer<float4> g_fieldForces : register(u0, space0);

float4 between(float4 a, float4 b, float share) {
  precise float4 r = a + (b - a) * share;
  return r;
}

float4 valueOfNode(uint3 node) {
  return g_fieldValues[g_fieldFirst + node.x + g_fieldNodes.x * (node.y + g_fieldNodes.y * node.z)];
}

// Nodes of a cell along x.
float4 valueOfEdge(uint3 node, float share) {
  return between(valueOfNode(node), valueOfNode(node + uint3(1u, 0u, 0u)), share);
}

float4 valueOfFace(uint3 node, float3 share) {
  return between(valueOfEdge(node, share.x), valueOfEdge(node + uint3(0u, 1u, 0u), share.x),
                 share.y);
}

float4 fieldAt(float3 position) {
  float4 none = float4(0.0, 0.0, 0.0, 0.0);
  precise float3 p = (position - g_fieldOrigin.xyz) / g_fieldOrigin.w;
  float3 last = float3(g_fieldNodes.xyz - 1u);
  bool inside = isUsable(position) && isUsable(p) && min(p.x, min(p.y, p.z)) >= 0.0 &&
                p.x <= last.x && p.y <= last.y && p.z <= last.z;
  if (!inside) return none;
  uint3 node = min(uint3(p), g_fieldNodes.xyz - 2u);
  precise float3 share = p - float3(node);
  float4 value =
      between(valueOfFace(node, share), valueOfFace(node + uint3(0u, 0u, 1u), share), share.z);
  return isUsable(value) && value.w >= 0.0 ? value : none;
}

[numthreads(64, 1, 1)]
void sample_force_field(uint3 thread : SV_DispatchThreadID) {
  uint index = indexOfThread(thread);
  if (index >= g_fieldVertexCount) return;
  float4 force = float4(0.0, 0.0, 0.0, 0.0);
  if (g_fieldKnown != 0u) force = fieldAt(g_fieldPositions[index].xyz);
  if (g_fieldAddsForces != 0u) {
    float4 others = g_fieldOthers[index];
    precise float4 sum = force + others;
    if (isUsable(others)) force = sum;
  }
  g_fieldForces[index] = force;
}
