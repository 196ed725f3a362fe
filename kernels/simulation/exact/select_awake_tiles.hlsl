// Lists the tiles of strands that have to be simulated in this frame; the others sleep.
//
// Threads: one a strand in the order of g_strands, one group a tile; dispatch min(tiles, 2^15) x
//          ceil(tiles / 2^15) groups, once a frame, after skin_roots. Words 0 to 11 of g_sleep are
//          written by the host before.
// Reads:   g_strands, g_rootFrames, g_state (vertex 1 and edge 0), g_exactColliders as far as there
//          are some
// Writes:  g_sleep
//
// A strand rests when all of its vertices were slower than a limit for a while (simulate_rods
// counts the time). It wakes when its root would move its tip by more than g_wakeDistance, or when a
// collider moves within its reach; then it has to rest for the whole while again, which is the
// hysteresis. A tile sleeps when all of its strands rest. Everything else that moves hair, like a
// setting, wakes all of them by the host's flag.
// A tile that sleeps keeps its state where it is: the offset that is added to g_slot goes back by
// as many states as the others go on in this frame.
// The order of the list is that in which groups get there; no result depends on it.
//
// Invariant (tests/kernel): a tile is in the list once or not at all; what sleeps has not moved
// when it wakes, and goes on from the state in which it fell asleep.
#include "../../common/colliders.hlsli"
#include "rod_state.hlsli"

static const uint kTilesARow = 32768;
static const uint kWakeAllFlag = 16;

groupshared uint s_awake;

// How far a rigid motion of the root would take the strand's tip [m], at most about.
float rootMotion(ExactStrand strand, Slots slots, uint index) {
  RodRoot root = rootPath(strand.root).to;
  float4 rest = g_rest[stateIndex(0, 0, strand)];
  float4 frame = normalizeProduct(multiplyQuaternions(root.rotation, rest));
  float3 x1 = g_state[strandIndex(kFirstPosition, slots.now, index)].xyz;
  float edgeLength = g_rest[stateIndex(0, strand.count - 1, strand)].x;
  float4 old = g_state[stateIndex(kFrameSets + slots.now, 0, strand)];
  precise float3 way = root.position + axisX(frame) * edgeLength - x1;
  // 2 sin(angle / 2) is the chord between the two quaternions, or between one and the other's
  // negative, which is the same rotation.
  precise float along = dot4(frame, old);
  precise float4 near = old * (along < 0.0 ? -1.0 : 1.0);
  precise float4 turn = frame - near;
  precise float r =
      squareRoot(dot3(way, way)) + 2.0 * squareRoot(dot4(turn, turn)) * strand.strandLength;
  return r;
}

// True when a collider that moves in this frame can touch the strand.
bool isStirred(ExactStrand strand) {
  float3 root = rootPath(strand.root).to.position;
  for (uint c = 0; c < g_colliderCount; ++c) {
    Collider shape = g_exactColliders[c];
    precise float3 headWay = shape.head.xyz - shape.headBefore.xyz;
    precise float3 tailWay = shape.tail.xyz - shape.tailBefore.xyz;
    precise float moved =
        dot3(headWay, headWay) + dot3(tailWay, tailWay) + dot3(shape.spin.xyz, shape.spin.xyz);
    if (moved <= 0.0) continue;
    // Of the sphere that moves with the larger end, generously.
    precise float reach = strand.strandLength + squareRoot(moved) + g_wakeDistance;
    if (findContact(shape, root, 0.0, 1.0).penetration > -reach) return true;
  }
  return false;
}

[numthreads(32, 1, 1)]
void select_awake_tiles(uint3 group : SV_GroupID, uint lane : SV_GroupIndex) {
  uint tiles = tileCount();
  uint tile = group.y * kTilesARow + group.x;
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
      ExactStrand strand = g_strands[index];
      if (isSound(strand)) {
        Slots slots = slotsOfTile(tile);
        awake = rootMotion(strand, slots, index) > g_wakeDistance;
        awake = awake || isStirred(strand);
      }
    }
    // One that is woken has to come to rest anew.
    if (awake && rested >= g_restTime) g_sleep[word] = 0u;
    if (awake) InterlockedOr(s_awake, 1u);
  }
  GroupMemoryBarrierWithGroupSync();

  if (lane != 0 || tile >= tiles) return;
  if (s_awake != 0u) {
    uint entry;
    InterlockedAdd(g_sleep[0], 1u, entry);
    if (entry < tiles) g_sleep[kSleepHead + entry] = tile;
    InterlockedAdd(g_sleep[3], min(kTileStrands, simulated - tile * kTileStrands));
    InterlockedMax(g_sleep[4], g_followGroups);
    InterlockedAdd(g_sleep[8], 1u);
  } else {
    uint offset = g_sleep[kSleepHead + tiles + tile];
    g_sleep[kSleepHead + tiles + tile] = (offset + g_slotsBack) % 4;
  }
}
