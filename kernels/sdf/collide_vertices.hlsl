// Moves vertices out of signed distance fields: for hair without strands between its vertices, and
// to measure. The solvers have the same contacts inside their loops.
//
// Threads: one a vertex, in rows of 2^20; LISTED: one a vertex of g_sdfNear, dispatchIndirect,
//          groups share the list.
// Reads:   g_sdfFields, g_sdfKeys, g_sdfSurface; LISTED: g_sdfNear
// Writes:  g_sdfPositions, g_sdfPositionsBefore
//
// A vertex that is nearer to a surface than its margin goes out along the normal. CLOSEST_FEATURE:
// the normal of the nearest feature, exact; else the gradient of the trilinear distance, which is 4
// degrees off and leaves one in seven vertices below the surface. WALK: steps from the triangles
// that the nodes know to nearer ones beside them.
// FRICTION: Coulomb's at position level. Of the way along the surface, relative to it, as much is
// taken as friction times the way outwards.
// A way of more than half a cell relative to the surface is swept: it stops at the surface, and
// goes on along it, swept again, up to kRounds times. Then the vertex is where it stopped last.
// The velocity that is left has no part along the normal relative to the surface: the position
// before is moved, so that being pushed out is not a velocity.
//
// LISTED: only those vertices that find_near_vertices has listed. All else would keep their bits; in
// hair as it lies nearly every wave has one that is near, and waits for it.
//
// Invariant (tests/kernel): with LISTED the same bits as without; vertices without inverse mass,
// those that are not finite, and those that nothing touches keep their bits; what is inside is
// outside afterwards (99.9 %); a slope holds and lets slide as Coulomb says; what is thicker than
// 1.2 cells is not passed in a step of 16 cells.
#define SDF_KEYS g_sdfKeys
#define SDF_SURFACE g_sdfSurface
#define SDF_CLOSEST_FEATURE CLOSEST_FEATURE
#define SDF_WALK WALK

#include "../layouts/apply_sdf.hlsli"
#include "sdf_near_list.hlsli"
#include "sdf_response.hlsli"

static const uint kRounds = 4;

struct Vertex {
  float3 now;
  float3 before;
  bool moved;
};

void collide(inout Vertex vertex, SdfField field) {
  float3 from = vertex.before;
  float3 to = vertex.now;
  float begin = g_sdfBegin;
  float end = g_sdfEnd;
  precise float3 shift = float3(0.0, 0.0, 0.0);  // to where the surface stands still
  precise float3 carried = float3(0.0, 0.0, 0.0);
  precise float3 place = vertex.now;
  float3 normal = float3(0.0, 0.0, 0.0);
  bool touched = false;
  [loop] for (uint round = 0; round < kRounds; ++round) {
    SdfContact contact = sdfContact(field, from, to, begin, end, 0.0);
    if (!contact.found) break;
    precise float cell = field.origin.w;
    if (round == 0) {
      shift = contact.motion * (cell * (1.0 - g_sdfEnd));
      carried = contact.motion * (cell * (g_sdfEnd - g_sdfBegin));
      place = place + shift;
      begin = 1.0;
      end = 1.0;
    }
    touched = true;
    normal = contact.normal;
    precise float push = max(contact.penetration, 0.0);
    precise float3 outward = normal * push;
#if FRICTION
    precise float3 start = contact.swept ? contact.stop : contact.from;
    precise float3 way = contact.to + outward - start;
    precise float off = dot3(way, normal);
    precise float3 slip = way - normal * off;
    precise float size = squareRoot(dot3(slip, slip));
    precise float most = field.friction * push;
    precise float share = size > most ? most / size : 1.0;
    outward = outward - slip * share;
#endif
    precise float3 pushed = place + outward * cell;
    precise float3 stop = field.origin.xyz + contact.stop * cell;
    bool stays = contact.swept && round + 1u == kRounds;
    place = stays ? stop : pushed;
    if (!contact.swept) break;
    from = stop;
    to = place;
  }
  if (!touched || !isUsable(place)) return;
  precise float3 now = place - shift;
  precise float3 velocity = now - vertex.before - carried;
  precise float rising = dot3(velocity, normal);
  precise float3 before = vertex.before + normal * rising;
  vertex.now = now;
  vertex.before = before;
  vertex.moved = true;
}

void collideVertex(uint index) {
  float4 now = g_sdfPositions[index];
  if (!(now.w > 0.0) || !isUsable(now)) return;
  float4 before = g_sdfPositionsBefore[index];
  Vertex vertex;
  vertex.now = now.xyz;
  vertex.before = isUsable(before.xyz) ? before.xyz : now.xyz;
  vertex.moved = false;
  for (uint f = 0; f < g_sdfFieldCount; ++f) collide(vertex, g_sdfFields[f]);
  if (!vertex.moved) return;
  g_sdfPositions[index] = float4(vertex.now, now.w);
  g_sdfPositionsBefore[index] = float4(vertex.before, before.w);
}

#if LISTED
[numthreads(64, 1, 1)]
void collide_vertices(uint3 group : SV_GroupID, uint lane : SV_GroupIndex) {
  uint count = min(g_sdfNear[kNearCount], g_sdfVertexCount);
  for (uint entry = group.x * 64u + lane; entry < count; entry += kNearGroups * 64u) {
    uint index = g_sdfNear[kNearList + entry];
    if (index < g_sdfVertexCount) collideVertex(index);
  }
}
#else
[numthreads(64, 1, 1)]
void collide_vertices(uint3 thread : SV_DispatchThreadID) {
  uint index = (thread.y << 20) | thread.x;
  if (index < g_sdfVertexCount) collideVertex(index);
}
#endif
