// Moves vertices out of SDFs: for hair that needs no contacts between its vertices, and for
// measurements. The solvers use the records of find_contacts instead.
//
// Threads: one per vertex, in rows of 2^20.
// Reads:   g_sdfs, g_sdfKeys, g_sdfSurface
// Writes:  g_sdfPositions, g_sdfPositionsBefore
//
// A vertex nearer to a surface than its margin moves out along the normal. CLOSEST_FEATURE: along
// the exact normal of the nearest feature; otherwise along the gradient of the trilinear distance,
// which is 4 degrees off and leaves one in seven vertices below the surface. Coulomb friction, at
// position level: it removes at most friction times the outward displacement from the displacement
// along the surface, relative to the surface. A displacement of more than half a cell relative to
// the surface is swept: it stops at the surface and continues along it, swept again, up to
// kSdfRounds times. Then the vertex is where it stopped last. The remaining velocity has no part
// along the normal relative to the surface: the previous position is moved, too, so that being
// pushed out is not a velocity.
//
// A group first lists the vertices that a surface may touch, then moves those: for hair at rest one
// vertex in 16 is near, and nearly every wave has one, for which all its threads would wait. The
// result of a vertex does not depend on its index in the list.
//
// Invariant (tests/sdf): vertices without inverse mass, those that are not finite, and those
// without contact keep their bits; vertices that were inside are outside afterwards (99.9 %); the
// result of a vertex does not depend on the others; friction on a slope holds and slips as Coulomb
// says; no vertex passes through what is thicker than 1.2 cells in a step of 16 cells.
#include "../base/dispatch.hlsli"
#include "layouts/sdf.hlsli"

cbuffer ApplySdfConstants : register(b0, space0) {
  uint g_sdfVertexCount;
  uint g_sdfCount;
  float g_sdfBegin;  // fraction of the frame of the previous positions, 0..1
  float g_sdfEnd;    // fraction of the frame of the current positions
};

// [vertex]: xyz in the space of the SDFs' origins [m]; w = inverse mass, > 0 for a free one.
RWStructuredBuffer<float4> g_sdfPositions : register(u0, space0);
// [vertex]: xyz position one step earlier [m]; the difference is the velocity. w unused.
RWStructuredBuffer<float4> g_sdfPositionsBefore : register(u1, space0);
// [g_sdfCount]
StructuredBuffer<Sdf> g_sdfs : register(t0, space0);
StructuredBuffer<uint> g_sdfKeys : register(t1, space0);
StructuredBuffer<uint4> g_sdfSurface : register(t2, space0);

#define SDF_KEYS g_sdfKeys
#define SDF_SURFACE g_sdfSurface
#define SDF_CLOSEST_FEATURE CLOSEST_FEATURE
#include "sdf_collision.hlsli"

static const uint kSdfRounds = 4;

struct SdfVertex {
  float3 now;
  float3 before;
  bool moved;
};

// \param frameBegin, frameEnd  shares of the frame at which it is where it was before, and now
void collideWithSdf(inout SdfVertex vertex, Sdf sdf, float frameBegin, float frameEnd) {
  float3 from = vertex.before;
  float3 to = vertex.now;
  float begin = frameBegin;
  float end = frameEnd;
  precise float3 shift = float3(0.0, 0.0, 0.0);  // to where the surface stands still
  precise float3 transported = float3(0.0, 0.0, 0.0);
  precise float3 pointIndex = vertex.now;
  float3 normal = float3(0.0, 0.0, 0.0);
  bool touched = false;
  [loop] for (uint round = 0; round < kSdfRounds; ++round) {
    SdfContact contact = sdfContact(sdf, from, to, begin, end, 0.0, float3(0.0, 0.0, 0.0));
    if (!contact.found) break;
    precise float cell = sdf.origin.w;
    if (round == 0) {
      shift = contact.motion * (cell * (1.0 - frameEnd));
      transported = contact.motion * (cell * (frameEnd - frameBegin));
      pointIndex = pointIndex + shift;
      begin = 1.0;
      end = 1.0;
    }
    touched = true;
    normal = contact.normal;
    precise float push = max(contact.penetration, 0.0);
    precise float3 outward = normal * push;
    precise float3 start = contact.swept ? contact.stop : contact.from;
    precise float3 displacement = contact.to + outward - start;
    precise float off = dot3(displacement, normal);
    precise float3 slip = displacement - normal * off;
    precise float size = squareRoot(dot3(slip, slip));
    precise float most = sdf.friction * push;
    precise float share = size > most ? most / size : 1.0;
    outward = outward - slip * share;
    precise float3 pushed = pointIndex + outward * cell;
    precise float3 stop = sdf.origin.xyz + contact.stop * cell;
    bool stays = contact.swept && round + 1u == kSdfRounds;
    pointIndex = stays ? stop : pushed;
    if (!contact.swept) break;
    from = stop;
    to = pointIndex;
  }
  if (!touched || !isUsable(pointIndex)) return;
  precise float3 now = pointIndex - shift;
  precise float3 velocity = now - vertex.before - transported;
  precise float rising = dot3(velocity, normal);
  precise float3 before = vertex.before + normal * rising;
  vertex.now = now;
  vertex.before = before;
  vertex.moved = true;
}

static const uint kThreads = 64;
static const uint kVerticesAGroup = 64;

groupshared uint s_count;
groupshared uint s_near[kVerticesAGroup];

bool mayMove(uint index) {
  if (index >= g_sdfVertexCount) return false;
  float4 now = g_sdfPositions[index];
  if (!(now.w > 0.0) || !isUsable(now)) return false;
  float3 before = g_sdfPositionsBefore[index].xyz;
  if (!isUsable(before)) before = now.xyz;
  bool may = false;
  for (uint f = 0; f < g_sdfCount && !may; ++f)
    may = sdfMayCollide(g_sdfs[f], before, now.xyz, g_sdfEnd);
  return may;
}

void collideVertex(uint index) {
  float4 now = g_sdfPositions[index];
  float4 before = g_sdfPositionsBefore[index];
  SdfVertex vertex;
  vertex.now = now.xyz;
  vertex.before = isUsable(before.xyz) ? before.xyz : now.xyz;
  vertex.moved = false;
  for (uint f = 0; f < g_sdfCount; ++f) collideWithSdf(vertex, g_sdfs[f], g_sdfBegin, g_sdfEnd);
  if (!vertex.moved) return;
  g_sdfPositions[index] = float4(vertex.now, now.w);
  g_sdfPositionsBefore[index] = float4(vertex.before, before.w);
}

[numthreads(64, 1, 1)]
void collide_vertices(uint3 group : SV_GroupID, uint lane : SV_GroupIndex) {
  uint first = (group.y << kRowBits) + group.x * kVerticesAGroup;
  if (lane == 0u) s_count = 0u;
  GroupMemoryBarrierWithGroupSync();
  for (uint i = lane; i < kVerticesAGroup; i += kThreads) {
    if (!mayMove(first + i)) continue;
    uint slot;
    InterlockedAdd(s_count, 1u, slot);
    s_near[slot] = first + i;
  }
  GroupMemoryBarrierWithGroupSync();
  for (uint entry = lane; entry < s_count; entry += kThreads) collideVertex(s_near[entry]);
}
