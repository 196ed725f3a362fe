// Poses the guides of the exact solver without simulating them: the bind shape, moved rigidly with
// each root. The state becomes one that simulate_exact continues from, with the velocity of the
// motion since the last frame.
//
// Threads: one per strand in the order of the state, in rows of 2^20.
// Reads:   g_rest, g_state (the roots), g_sleep
// Writes:  g_state (now; displacements also of the two steps before), g_positions, g_tangents
//
// The frame counts as the second of two steps of backward Euler with one velocity. As after a step
// of simulate_exact, displacements leave out the motion that velocity shock propagation transports,
// here with g_vspCoefficient alone.
//
// Invariant (tests/simulation): positions are those of the bind pose, moved by the root, to
// rounding; a simulation that continues without gravity moves vertices on with their velocity.
#include "../../base/dispatch.hlsli"
#include "exact_state.hlsli"

// The motion of the bind shape in the frame, without what is transported.
struct Remainder {
  float4 rotation;  // from where the bind shape is now to where it was transported
  float3 pivot;     // the root now
  float3 shift;     // of the root
};

Remainder remainderOf(RootPath path, RigidMotion transported) {
  float4 back = multiplyQuaternions(path.from.rotation, conjugate(path.to.rotation));
  Remainder remainder;
  remainder.rotation = normalizeProduct(multiplyQuaternions(transported.rotation, back));
  remainder.pivot = path.to.position;
  precise float3 shift = (path.to.position - path.from.position) * (1.0 - g_vspCoefficient);
  remainder.shift = shift;
  return remainder;
}

float4 displacementTo(Remainder remainder, float3 x) {
  precise float3 displacement =
      remainder.shift - rotationDelta(remainder.rotation, x - remainder.pivot);
  return float4(displacement, 0.0);
}

// \param turned rotation by which the step transported what was before
void storeVertex(uint vertex, ExactStrand strand, Slots slots, float4 turned, float4 displacement) {
  float4 zero = float4(0.0, 0.0, 0.0, 0.0);
  float4 before = float4(rotate(conjugate(turned), displacement.xyz), 0.0);
  g_state[stateIndex(kDisplacementSets + slots.now, vertex, strand)] = displacement;
  g_state[stateIndex(kDisplacementSets + slots.before, vertex, strand)] = before;
  g_state[stateIndex(kDisplacementSets + slots.earlier, vertex, strand)] = zero;
}

// \param across from the vertex before to the one after
void writeVertex(uint element, uint vertex, float3 x, float3 across, float3 fallback) {
  precise float3 world = x + g_origin.xyz;
  g_positions[element] = float4(world, vertex < 2 ? 0.0 : 1.0);
  g_tangents[element] = float4(directionOr(across, fallback), 0.0);
}

[numthreads(32, 1, 1)]
void skin_exact_strands(uint3 thread : SV_DispatchThreadID) {
  uint index = indexOfThread(thread);
  if (index >= g_strandCount) return;
  ExactStrand strand = strandAt(index);
  if (!isSound(strand) || !fitsOutputs(strand)) return;

  Slots slots = slotsOfTile(index / kTileStrands);
  RootPath path = rootPath(strand.root);
  RigidMotion transported = transportedMotion(path.from, path.to, g_vspCoefficient);
  Remainder remainder = remainderOf(path, transported);

  uint tip = strand.count - 1;
  float4 zero = float4(0.0, 0.0, 0.0, 0.0);
  float4 identity = float4(0.0, 0.0, 0.0, 1.0);
  float4 frame =
      normalizeProduct(multiplyQuaternions(path.to.rotation, g_rest[stateIndex(0, 0, strand)]));
  precise float3 edge = axisX(frame) * g_rest[stateIndex(0, tip, strand)].x;
  precise float3 x = path.to.position;
  writeVertex(strand.target, 0, x, edge, axisX(frame));
  storeVertex(0, strand, slots, identity, zero);
  storeVertex(1, strand, slots, identity, zero);
  g_state[stateIndex(kFrameSets + slots.now, 0, strand)] = frame;
  x = x + edge;
  g_state[strandIndex(kFirstPosition, slots.now, index)] = float4(x, 0.0);
  [loop] for (uint i = 1; i < tip; ++i) {
    frame = normalizeProduct(multiplyQuaternions(frame, bindRotation(i, strand)));
    g_state[stateIndex(kFrameSets + slots.now, i, strand)] = frame;
    precise float3 next = axisX(frame) * g_rest[stateIndex(0, i, strand)].z;
    precise float3 across = edge + next;
    writeVertex(strand.target + i, i, x, across, axisX(frame));
    x = x + next;
    storeVertex(i + 1, strand, slots, transported.rotation, displacementTo(remainder, x));
    edge = next;
  }
  g_state[stateIndex(kFrameSets + slots.now, tip, strand)] = identity;
  for (uint v = tip; v < max(strand.count, g_outputVertices); ++v)
    writeVertex(strand.target + v, tip, x, edge, axisX(frame));

  precise float3 velocity = (path.to.position - path.from.position) / g_frameTime;
  g_state[strandIndex(kGuessedDisplacement, slots.now, index)] = zero;
  g_state[strandIndex(kTipPosition, slots.now, index)] = float4(x, 0.0);
  g_state[strandIndex(kRootVelocity, slots.now, index)] = float4(velocity, 0.0);
  g_state[strandIndex(kTransportRotation, slots.now, index)] = transported.rotation;
  g_state[strandIndex(kTransportRotation, slots.before, index)] = identity;
}
