// Measures how deep vertices are inside of colliders [m]: capsules by their shape, meshes by the
// trilinear distance of their SDF. It knows nothing of the solver's contacts.
//
// Threads: one per vertex of a posed strand, in rows of kInspectRow.
// Reads:   g_depthColliders, g_depthSlots, g_depthKeys, g_depthRecords (positions)
// Writes:  g_depthRecords (values, >= 0), g_depthSummary
//
// The first two vertices of a strand, which the bones hold, are not measured: their value is 0.
// Invariant (viewer_test): hair inside of a ball that it does not collide with is seen.
#include "strand_value.hlsli"

cbuffer StrandPenetrationConstants : register(b0, space0) {
  uint g_depthVertexCount;  // vertices a strand
  uint g_depthVertices;     // of all strands that are posed
  uint g_depthCapsuleCount;
  uint g_depthGridCount;
  uint g_depthSlotCount;  // of g_depthSlots
  float g_depthLimit;     // [m] beyond which a vertex is counted
  uint g_depthPad0;
  uint g_depthPad1;
};

// [capsule][2]: xyz of an end in world space, w its radius [m]; then [grid][2]: xyz of node 0 in
// world space, w the cell size [m], and the counts of nodes (bits of uints).
StructuredBuffer<float4> g_depthColliders : register(t0, space0);
StructuredBuffer<uint4> g_depthSlots : register(t1, space0);       // HairBuffers::sdfs
StructuredBuffer<uint> g_depthKeys : register(t2, space0);         // Scene::sdfKeys()
RWStructuredBuffer<float4> g_depthRecords : register(u0, space0);  // as pose_strands writes them
RWStructuredBuffer<uint> g_depthSummary : register(u1, space0);    // kSummaryWords

#define FIELD_SLOTS g_depthSlots
#define FIELD_KEYS g_depthKeys
#define FIELD_SLOT_COUNT g_depthSlotCount
#include "field.hlsli"
#include "contact/colliders.hlsli"

float depthInCapsule(uint capsule, float3 position) {
  Collider shape = (Collider)0;
  shape.head = g_depthColliders[2u * capsule];
  shape.tail = g_depthColliders[2u * capsule + 1u];
  shape.headBefore = float4(shape.head.xyz, 0.0);
  shape.tailBefore = float4(shape.tail.xyz, 0.0);
  return findContact(shape, position, 0.0, 1.0).penetration;
}

float depthInGrid(uint grid, float3 position) {
  uint element = 2u * (g_depthCapsuleCount + grid);
  Sdf sdf;
  if (!findField(g_depthColliders[element], asuint(g_depthColliders[element + 1u]), sdf))
    return 0.0;
  return -fieldDistance(sdf, position);
}

[numthreads(64, 1, 1)]
void measure_penetration(uint3 group : SV_GroupID, uint lane : SV_GroupIndex) {
  uint index = group.y * kInspectRow + group.x * 64u + lane;
  if (index >= g_depthVertices) return;
  uint before;
  float4 record = g_depthRecords[index];
  InterlockedAdd(g_depthSummary[kSummaryMeasured], 1u, before);
  if (!isUsable(record.xyz)) {
    InterlockedAdd(g_depthSummary[kSummaryNotFinite], 1u, before);
    return;
  }
  float depth = 0.0;
  if (index % g_depthVertexCount >= 2u) {
    for (uint capsule = 0; capsule < g_depthCapsuleCount; ++capsule)
      depth = max(depth, depthInCapsule(capsule, record.xyz));
    for (uint grid = 0; grid < g_depthGridCount; ++grid)
      depth = max(depth, depthInGrid(grid, record.xyz));
  }
  g_depthRecords[index].w = depth;
  InterlockedMax(g_depthSummary[kSummaryLargest], asuint(depth), before);
  if (depth > g_depthLimit) InterlockedAdd(g_depthSummary[kSummaryBeyond], 1u, before);
}
