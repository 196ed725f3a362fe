// Lists the tiles of strands that are simulated in this frame; the others sleep.
//
// Threads: one per strand in the order of the state, one group per tile; dispatch min(tiles, 2^15)
//          x ceil(tiles / 2^15) groups, once per frame, after skin_roots. The host writes words 0
//          to 11 of g_sleep before.
// Reads:   g_state (vertex 1 and edge 0), g_exactColliders if there are
//          any
// Writes:  g_sleep
//
// A strand is at rest when all of its vertices have been slower than a limit for a time
// (simulate_exact measures it). It wakes when its root would move its tip by more than
// g_wakeDistance, or when a collider moves within its range; then it must be at rest for the whole
// time again, which is the hysteresis. A tile sleeps when all of its strands are at rest.
// Everything else that moves hair, such as a setting, wakes all of them by the host's flag. A
// sleeping tile keeps its state in its slot: the offset that is added to g_slot decreases by as
// many states as the others advance in this frame. The list is in the order in which groups append;
// no result depends on it.
//
// Invariant (tests/simulation): a tile is in the list once or not at all; a tile that wakes has not
// moved, and continues from the state in which it fell asleep.
#include "../../contact/colliders.hlsli"
#include "../../base/dispatch.hlsli"
#include "exact_state.hlsli"

groupshared uint s_awake;

// Returns the approximate maximum displacement of the strand's tip by a rigid motion of the root
// [m].
float rootMotion(ExactStrand strand, Slots slots, uint index) {
  RodRoot root = rootPath(strand.root).to;
  float4 rest = g_rest[stateIndex(0, 0, strand)];
  float4 frame = normalizeProduct(multiplyQuaternions(root.rotation, rest));
  float3 x1 = g_state[strandIndex(kFirstPosition, slots.now, index)].xyz;
  float edgeLength = g_rest[stateIndex(0, strand.count - 1, strand)].x;
  float4 old = g_state[stateIndex(kFrameSets + slots.now, 0, strand)];
  precise float3 displacement = root.position + axisX(frame) * edgeLength - x1;
  // 2 sin(angle / 2) is the chord between the two quaternions, or between one and the other's
  // negative, which is the same rotation.
  precise float along = dot4(frame, old);
  precise float4 near = old * (along < 0.0 ? -1.0 : 1.0);
  precise float4 relativeRotation = frame - near;
  precise float r =
      squareRoot(dot3(displacement, displacement)) +
      2.0 * squareRoot(dot4(relativeRotation, relativeRotation)) * strand.strandLength;
  return r;
}

// Returns true if a collider that moves in this frame can touch the strand.
bool isStirred(ExactStrand strand) {
  float3 root = rootPath(strand.root).to.position;
  for (uint c = 0; c < g_colliderCount; ++c) {
    Collider shape = g_exactColliders[c];
    precise float3 headDisplacement = shape.head.xyz - shape.headBefore.xyz;
    precise float3 tailDisplacement = shape.tail.xyz - shape.tailBefore.xyz;
    precise float moved = dot3(headDisplacement, headDisplacement) +
                          dot3(tailDisplacement, tailDisplacement) +
                          dot3(shape.spin.xyz, shape.spin.xyz);
    if (moved <= 0.0) continue;
    // Motion of the sphere that moves with the larger end, an upper bound.
    precise float range = strand.strandLength + squareRoot(moved) + g_wakeDistance;
    if (findContact(shape, root, 0.0, 1.0).penetration > -range) return true;
  }
  return false;
}

[numthreads(32, 1, 1)]
void select_awake_tiles(uint3 group : SV_GroupID, uint lane : SV_GroupIndex) {
  uint tiles = tileCount();
  uint tile = indexOfGroup(group);
  uint index = tile * kTileStrands + lane;
  uint simulated = min(g_strandCount, g_simulatedCount);
  bool inside = tile < tiles && index < simulated;
  if (lane == 0) s_awake = 0u;
  GroupMemoryBarrierWithGroupSync();

  bool awake = false;
  uint word = kSleepHead + 2 * tiles + index;
  if (inside) {
    float rested = asfloat(g_sleep[word]);
    awake = (g_flags & kWakeAllFlag) != 0u || !(rested >= g_restTime);
    if (!awake) {
      ExactStrand strand = strandAt(index);
      if (isSound(strand)) {
        Slots slots = slotsOfTile(tile);
        awake = rootMotion(strand, slots, index) > g_wakeDistance;
        awake = awake || isStirred(strand);
      }
    }
    // A woken strand must come to rest anew.
    if (awake && rested >= g_restTime) g_sleep[word] = 0u;
    if (awake) InterlockedOr(s_awake, 1u);
  }
  GroupMemoryBarrierWithGroupSync();

  if (lane != 0 || tile >= tiles) return;
  if (s_awake != 0u) {
    uint entry;
    InterlockedAdd(g_sleep[kSleepSolveArguments], 1u, entry);
    if (entry < tiles) g_sleep[kSleepHead + entry] = tile;
    InterlockedAdd(g_sleep[kSleepAwakeStrands], min(kTileStrands, simulated - tile * kTileStrands));
    InterlockedMax(g_sleep[kSleepFollowArguments], g_followGroups);
    InterlockedAdd(g_sleep[kSleepFindArguments], 1u);
  } else {
    uint offset = g_sleep[kSleepHead + tiles + tile];
    g_sleep[kSleepHead + tiles + tile] = (offset + g_slotsBack) % 4;
  }
}
