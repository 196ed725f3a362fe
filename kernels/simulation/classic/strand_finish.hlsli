// The last sweep over a strand: lengths and contacts, and the outputs.
#ifndef PELAGE_SIMULATION_CLASSIC_STRAND_FINISH_HLSLI
#define PELAGE_SIMULATION_CLASSIC_STRAND_FINISH_HLSLI

#include "strand_root.hlsli"

#if CONTACTS
#include "../../contact/fit_along_plane.hlsli"
#include "../../contact/contact_access.hlsli"

bool hasContact(Strand s, uint vertex) {
  uint word = g_contactWords[g_contactMasks + s.guide * g_contactMaskWords + vertex / 32u];
  return ((word >> (vertex & 31u)) & 1u) != 0u;
}

// Moves vertex i at x, `rest` meters from its leader, in front of the planes of its contacts and
// back to its length, in turn. Coulomb friction at position level: it removes at most friction
// times the outward displacement from the vertex's displacement along the surface in this sub-step.
float3 keepOut(Strand s, Motion motion, uint i, float3 x, float3 leader, float3 direction,
               float rest) {
  float3 start = untransported(motion, g_state[guideIndex(1, i, s.guide)].xyz);
  uint record = vertexIndex(s.guide, i) * kMaxContacts;
  for (uint round = 0; round < kContactRounds; ++round) {
    precise float3 p = x;
    bool touched = false;
    float3 plane = float3(0.0, 0.0, 0.0);
    [loop] for (uint k = 0; k < kMaxContacts; ++k) {
      ContactRecord contact = loadRecord(record + k);
      float3 n = contact.plane.xyz;
      precise float3 off = p - float3(contact.foundX, contact.foundY, contact.foundZ);
      precise float depth = -(contact.plane.w + dot3(n, off));
      if (depth > 0.0) {
        touched = true;
        plane = n;
        p = p + n * depth;
        if (round == 0 && contact.surface.w > 0.0) {
          precise float3 displacement = p - start - contact.surface.xyz;
          precise float outward = dot3(displacement, n);
          precise float3 slip = displacement - n * outward;
          float size = squareRoot(dot3(slip, slip));
          precise float most = contact.surface.w * depth;
          precise float share = size > most ? most / size : 1.0;
          p = p - slip * share;
        }
      }
      if ((contact.bits & kContactMore) == 0u) break;
    }
    if (!touched) return x;
    precise float3 arm = p - leader;
    arm = fitAlongPlane(arm, plane, rest);
    x = leader + directionOr(arm, direction) * rest;
  }
  return x;
}
#endif

// Follow the leader beyond the last held vertex, with the contacts.
void followLeaders(Strand s, Motion motion, bool free, float3 fallback) {
  float3 before = s.root;
  float3 direction = fallback;
  float2 lengthBefore = loadLength(s, 0);
  float4 pointHere = loadPoint(s, 1);
  float2 lengthHere = loadLength(s, 1);
  uint last = g_vertexCount - 1;
  for (uint i = 1; i <= last; ++i) {
    float4 ahead = loadPoint(s, min(i + 1, last));
    float2 lengthAhead = loadLength(s, min(i + 1, last));
    float3 x = pointHere.xyz;
    bool follows = free && i > s.held;
    float rest = restLength(lengthBefore);
    precise float3 segment = x - before;
    direction = directionOr(segment, direction);
    precise float error = dot3(direction, segment) - rest;
    bool moves = follows && !(abs(error) <= lengthRounding(x, s.root));
    precise float3 fitted = before + direction * rest;
    x = moves ? fitted : x;
#if CONTACTS
    if (follows && hasContact(s, i)) x = keepOut(s, motion, i, x, before, direction, rest);
#endif
    storePoint(s, i, float4(x, inverseMass(lengthHere)));
    before = x;
    lengthBefore = lengthHere;
    pointHere = ahead;
    lengthHere = lengthAhead;
  }
}

// ---- outputs

// Direction of the last segment up to a vertex that has one, else that of the root.
float3 directionUpTo(Strand s, uint vertex) {
  float3 none = float3(0.0, 0.0, 0.0);
  for (uint i = vertex; i > 0; --i) {
    precise float3 segment = position(s, i) - position(s, i - 1);
    float3 direction = directionOr(segment, none);
    if (dot3(direction, direction) > 0.0) return direction;
  }
  float3 bindRoot = restPosition(0, s.guide);
  RootPose end = rootPoseAt(s.guide, bindRoot, g_rootEnd);
  return firstDirection(s.guide, bindRoot, end, firstFrame(s.guide, end));
}

// Two vertices of every strand of the group, on their way to memory: the vertices of a strand are
// contiguous there, so a thread that wrote its own strand would touch a line for each value.
static const uint kTileVertices = 2;
static const uint kTileRow = GROUP_LANES + 4;
groupshared float4 s_positions[kTileVertices * kTileRow];
groupshared float4 s_tangents[kTileVertices * kTileRow];

// A vertex's tangent is the direction from the previous to the next vertex; at the two ends, that
// of the only segment.
void tileOutput(Strand s, uint vertex, uint slot) {
  uint to = min(vertex + 1, g_vertexCount - 1);
  float4 pointHere = loadPoint(s, vertex);
  precise float3 across = position(s, to) - position(s, max(vertex, 1) - 1);
  float3 none = float3(0.0, 0.0, 0.0);
  float3 tangent = directionOr(across, none);
  if (!(dot3(tangent, tangent) > 0.0)) tangent = directionUpTo(s, to);
  precise float3 world = pointHere.xyz + g_origin.xyz;
  s_positions[slot * kTileRow + s.lane] = float4(world, pointHere.w);
  s_tangents[slot * kTileRow + s.lane] = float4(tangent, 0.0);
}

// All threads of the group call it.
void writeOutputs(Strand s, bool alive, uint firstGuide) {
  for (uint vertex = 0; vertex < g_vertexCount; vertex += kTileVertices) {
    uint count = min(g_vertexCount - vertex, kTileVertices);
    if (alive) {
      tileOutput(s, vertex, 0);
      if (count > 1) tileOutput(s, vertex + 1, 1);
    }
    GroupMemoryBarrierWithGroupSync();
    for (uint k = s.lane; k < kTileVertices * GROUP_LANES; k += GROUP_LANES) {
      uint strand = k / kTileVertices;
      uint slot = k - strand * kTileVertices;
      uint guide = firstGuide + strand;
      if (guide < g_guideCount && slot < count) {
        uint to = vertexIndex(guide, vertex + slot);
        g_positions[to] = s_positions[slot * kTileRow + strand];
        g_tangents[to] = s_tangents[slot * kTileRow + strand];
      }
    }
    GroupMemoryBarrierWithGroupSync();
  }
}

#endif
