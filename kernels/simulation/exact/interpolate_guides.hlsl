// Simulation level of detail: gives guides that are not simulated, or that fade in or out, the
// shape of a simulated guide.
//
// Threads: one per strand from g_fadeStart on; dispatch g_strandCount - g_fadeStart x
//          1, after the sub-steps of a frame. With the restart flag: before them, from
//          g_restartFrom on.
// Reads:   g_lodParents, g_rest, g_state, g_sleep
// Writes:  g_positions and g_tangents of these strands; with the restart flag g_state instead
//
// The host has sorted the strands so that every prefix covers the scalp, and given each a parent
// before it, near it. A strand follows its first ancestor that is wholly simulated: it rotates
// every edge from its own rest shape as the ancestor has rotated the edge at the same fraction of
// its length, in the frames of their roots. Between g_fadeStart and g_simulatedCount, where strands
// are simulated as well, the two shapes are blended edge by edge, so that lengths are kept. With
// the restart flag the result becomes the state of strands that are simulated again from now on.
//
// Invariant (tests/simulation): edges have their rest lengths; a strand whose parent is at rest is
// at rest; with a parent of the same rest shape it has the parent's shape.
#include "exact_state.hlsli"

// Returns the frame of the edge after `before` in the bind pose, in bind space.
float4 restFrameAfter(float4 before, uint edge, ExactStrand strand) {
  return normalizeProduct(multiplyQuaternions(before, bindRotation(edge, strand)));
}

[numthreads(32, 1, 1)]
void interpolate_guides(uint3 thread : SV_DispatchThreadID) {
  bool restart = (g_flags & kRestartFlag) != 0u;
  uint index = thread.x + (restart ? g_restartFrom : g_fadeStart);
  uint end = restart ? min(g_simulatedCount, g_strandCount) : g_strandCount;
  if (index >= end || index == 0) return;
  uint parentIndex = g_lodParents[index];
  // Every parent comes before its child.
  for (uint k = 0; k < 32 && parentIndex >= g_fadeStart && parentIndex > 0; ++k)
    parentIndex = min(g_lodParents[parentIndex], parentIndex - 1);
  ExactStrand strand = strandAt(index);
  ExactStrand parent = strandAt(min(parentIndex, index - 1));
  if (!isSound(strand) || !isSound(parent) || !fitsOutputs(strand)) return;

  Slots slots = slotsOfTile(index / kTileStrands);
  Slots parentSlots = slotsOfTile(parentIndex / kTileStrands);
  RootPath path = rootPath(strand.root);
  RodRoot root = rootAt(path, g_rootEnd);
  RodRoot parentRoot = rootAt(rootPath(parent.root), g_rootEnd);
  bool simulated = index < g_simulatedCount && !restart;
  precise float weight = 1.0;
  if (simulated)
    weight = float(index - g_fadeStart + 1) / float(g_simulatedCount - g_fadeStart + 1);

  uint tip = strand.count - 1;
  uint last = strand.count - 2;  // edges
  uint parentLast = parent.count - 2;
  float4 restFrame = g_rest[stateIndex(0, 0, strand)];
  float4 parentRest = g_rest[stateIndex(0, 0, parent)];
  uint parentEdge = 0;
  float4 frame = normalizeProduct(multiplyQuaternions(root.rotation, restFrame));
  float edgeLength = g_rest[stateIndex(0, tip, strand)].x;
  precise float3 x = root.position;
  precise float3 edgeVector = axisX(frame) * edgeLength;
  precise float3 world = x + g_origin.xyz;
  float3 tangent = axisX(frame);
  if (!restart) {
    g_positions[strand.target] = float4(world, 0.0);
    g_tangents[strand.target] = float4(tangent, 0.0);
  } else {
    g_state[stateIndex(kFrameSets + slots.now, 0, strand)] = frame;
    precise float3 first = x + edgeVector;
    g_state[strandIndex(kFirstPosition, slots.now, index)] = float4(first, 0.0);
  }
  x = x + edgeVector;
  [loop] for (uint i = 1; i <= last; ++i) {
    restFrame = restFrameAfter(restFrame, i, strand);
    uint wanted = parentLast > 0 ? 1 + ((i - 1) * parentLast) / last : 0;
    while (parentEdge < wanted) {
      parentEdge = parentEdge + 1;
      parentRest = restFrameAfter(parentRest, parentEdge, parent);
    }
    float4 bent = frame;
    if (wanted > 0) {
      float4 now = g_state[stateIndex(kFrameSets + parentSlots.now, wanted, parent)];
      float4 inBind = multiplyQuaternions(conjugate(parentRoot.rotation), now);
      float4 deformation = multiplyQuaternions(inBind, conjugate(parentRest));
      bent = multiplyQuaternions(root.rotation, multiplyQuaternions(deformation, restFrame));
    } else {
      bent = multiplyQuaternions(root.rotation, restFrame);
    }
    frame = normalizeProduct(bent);
    if (simulated) {
      float4 own = g_state[stateIndex(kFrameSets + slots.now, i, strand)];
      frame = interpolateQuaternions(own, frame, weight);
    }
    float3 direction = axisX(frame);
    precise float3 next = direction * g_rest[stateIndex(0, i, strand)].z;
    precise float3 across = edgeVector + next;
    if (!restart) {
      world = x + g_origin.xyz;
      g_positions[strand.target + i] = float4(world, i < 2 ? 0.0 : 1.0);
      g_tangents[strand.target + i] = float4(directionOr(across, direction), 0.0);
    } else {
      g_state[stateIndex(kFrameSets + slots.now, i, strand)] = frame;
    }
    edgeVector = next;
    tangent = direction;
    x = x + next;
  }
  if (!restart) {
    world = x + g_origin.xyz;
    for (uint v = tip; v < max(strand.count, g_outputVertices); ++v) {
      g_positions[strand.target + v] = float4(world, tip < 2 ? 0.0 : 1.0);
      g_tangents[strand.target + v] = float4(tangent, 0.0);
    }
    return;
  }
  float4 zero = float4(0.0, 0.0, 0.0, 0.0);
  for (uint j = 0; j < strand.count; ++j) {
    g_state[stateIndex(kDisplacementSets + slots.now, j, strand)] = zero;
    g_state[stateIndex(kDisplacementSets + slots.before, j, strand)] = zero;
    g_state[stateIndex(kDisplacementSets + slots.earlier, j, strand)] = zero;
  }
  float4 identity = float4(0.0, 0.0, 0.0, 1.0);
  g_state[strandIndex(kGuessedDisplacement, slots.now, index)] = zero;
  g_state[strandIndex(kTipPosition, slots.now, index)] = float4(x, 0.0);
  g_state[strandIndex(kRootVelocity, slots.now, index)] =
      g_state[strandIndex(kRootVelocity, parentSlots.now, parentIndex)];
  g_state[strandIndex(kTransportRotation, slots.now, index)] = identity;
  g_state[strandIndex(kTransportRotation, slots.before, index)] = identity;
}
