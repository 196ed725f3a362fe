// The layout of a strand's state, and the rigid motion that transports it with its root.
#ifndef PELAGE_SIMULATION_EXACT_EXACT_STATE_HLSLI
#define PELAGE_SIMULATION_EXACT_EXACT_STATE_HLSLI

#include "../layouts/exact.hlsli"
#include "exact_math.hlsli"

static const uint kDisplacementSets = 0;
static const uint kFrameSets = 4;
// Vertices a strand may have.
static const uint kMinCount = 2;
static const uint kMaxCount = 256;

static const uint kStrandRecordElements = 2;

// \param index of the strand, in the order of the state.
ExactStrand strandAt(uint index) {
  uint element = g_strandRecords + kStrandRecordElements * index;
  uint4 a = asuint(g_rest[element]);
  uint4 b = asuint(g_rest[element + 1u]);
  ExactStrand strand;
  strand.state = a.x;
  strand.count = a.y;
  strand.target = a.z;
  strand.root = a.w;
  strand.seed = b.x;
  strand.strandLength = asfloat(b.y);
  strand.pad0 = 0u;
  strand.pad1 = 0u;
  return strand;
}

// Element of g_state in which the scratch begins.
uint firstGainElement() {
  return kStateSets * g_stateStride + kStateSlots * kStrandElements * g_strandCount;
}

uint firstRootElement() {
  uint end = firstGainElement() + kGainSets * g_stateStride;
  return (end + kRootAlignment - 1u) / kRootAlignment * kRootAlignment;
}

// Element of a vertex in a set of g_state or g_rest.
uint stateIndex(uint set, uint vertex, ExactStrand strand) {
  return set * g_stateStride + strand.state + vertex * kTileStrands;
}

// Returns the rotation from edge i - 1 to edge i in the bind pose, in the frame of edge i - 1.
float4 bindRotation(uint edge, ExactStrand strand) {
  float3 rest = restRotation(g_rest[stateIndex(0, edge, strand)].xy);
  float4 joint = float4(0.0, rest.x, rest.y, rest.z);
  if (g_bindSet > 0u) joint = g_rest[stateIndex(g_bindSet, edge, strand)];
  return joint;
}

// Returns false for a record that does not fit the buffers of the state and the roots.
bool isSound(ExactStrand strand) {
  if (strand.count < kMinCount || strand.count > kMaxCount) return false;
  uint range = (strand.count - 1) * kTileStrands;
  if (range >= g_stateStride || strand.state >= g_stateStride - range) return false;
  return strand.root < g_rootCount;
}

// Returns false for a record that does not fit g_positions and g_tangents.
bool fitsOutputs(ExactStrand strand) {
  uint outputs = max(strand.count, g_outputVertices);
  return outputs <= g_outputCount && strand.target <= g_outputCount - outputs;
}

uint tileCount() { return (g_strandCount + kTileStrands - 1) / kTileStrands; }

// Elements of a strand in a state.
static const uint kGuessedDisplacement = 0;
static const uint kFirstPosition = 1;
static const uint kTipPosition = 2;
static const uint kRootVelocity = 3;
static const uint kTransportRotation = 4;

uint strandIndex(uint element, uint slot, uint strand) {
  return kStateSets * g_stateStride + (slot * kStrandElements + element) * g_strandCount + strand;
}

// The four states of g_state.
struct Slots {
  uint now;
  uint before;
  uint earlier;
  uint next;
};

// \param offset offset of a tile that slept, 0..3
Slots stateSlots(uint offset) {
  Slots slots;
  slots.now = (g_slot + offset) & 3u;
  slots.next = (slots.now + 1) & 3u;
  slots.earlier = (slots.now + 2) & 3u;
  slots.before = (slots.now + 3) & 3u;
  return slots;
}

Slots slotsOfTile(uint tile) { return stateSlots(g_sleep[kSleepHead + tileCount() + tile]); }

// p -> rotate(rotation, p) + shift.
struct RigidMotion {
  float4 rotation;
  float3 shift;
};

RigidMotion noMotion() {
  RigidMotion motion;
  motion.rotation = float4(0.0, 0.0, 0.0, 1.0);
  motion.shift = float3(0.0, 0.0, 0.0);
  return motion;
}

float3 movePoint(RigidMotion motion, float3 p) {
  precise float3 r = rotate(motion.rotation, p) + motion.shift;
  return r;
}

// The matrix of a rotation, by rows, times a factor.
struct ScaledRotation {
  float3 x;
  float3 y;
  float3 z;
};

ScaledRotation scaledRotationOf(float4 q, float factor) {
  float3 ex = rotate(q, float3(1.0, 0.0, 0.0));
  float3 ey = rotate(q, float3(0.0, 1.0, 0.0));
  float3 ez = rotate(q, float3(0.0, 0.0, 1.0));
  precise float3 x = float3(ex.x, ey.x, ez.x) * factor;
  precise float3 y = float3(ex.y, ey.y, ez.y) * factor;
  precise float3 z = float3(ex.z, ey.z, ez.z) * factor;
  ScaledRotation scaled;
  scaled.x = x;
  scaled.y = y;
  scaled.z = z;
  return scaled;
}

float3 rotateDisplacement(ScaledRotation scaled, float3 displacement) {
  precise float3 r = float3(dot3(scaled.x, displacement), dot3(scaled.y, displacement),
                            dot3(scaled.z, displacement));
  return r;
}

// The rigid motion of the states from which a sub-step starts. Without velocity shock propagation
// there is none, and no code. The stored states do not change.
struct Transport {
#if VELOCITY_SHOCK_PROPAGATION
  RigidMotion now;              // by this sub-step
  ScaledRotation displacement;  // of the displacements of the last three steps, with their weights
  ScaledRotation displacementBefore;
  ScaledRotation displacementEarlier;
#else
  uint unused;
#endif
};

#if VELOCITY_SHOCK_PROPAGATION
// \param before, earlier rotations by the two previous sub-steps
Transport transportOf(RigidMotion now, float4 before, float4 earlier) {
  float4 both = normalizeProduct(multiplyQuaternions(now.rotation, before));
  float4 all = normalizeProduct(multiplyQuaternions(both, earlier));
  Transport transport;
  transport.now = now;
  transport.displacement = scaledRotationOf(now.rotation, g_displacementShare);
  transport.displacementBefore = scaledRotationOf(both, g_displacementShareBefore);
  transport.displacementEarlier = scaledRotationOf(all, g_displacementShareEarlier);
  return transport;
}
#endif

float3 transportPoint(Transport transport, float3 p) {
#if VELOCITY_SHOCK_PROPAGATION
  return movePoint(transport.now, p);
#else
  return p;
#endif
}
float3 transportDisplacement(Transport transport, float3 displacement) {
#if VELOCITY_SHOCK_PROPAGATION
  return rotate(transport.now.rotation, displacement);
#else
  return displacement;
#endif
}
// Returns the position to which the last three displacements lead.
float3 transportedDisplacements(Transport transport, float3 displacement, float3 before,
                                float3 earlier) {
#if VELOCITY_SHOCK_PROPAGATION
  precise float3 r = rotateDisplacement(transport.displacement, displacement) +
                     rotateDisplacement(transport.displacementBefore, before) +
                     rotateDisplacement(transport.displacementEarlier, earlier);
#else
  precise float3 r = displacement * g_displacementShare + before * g_displacementShareBefore +
                     earlier * g_displacementShareEarlier;
#endif
  return r;
}
float4 transportFrame(Transport transport, float4 q) {
#if VELOCITY_SHOCK_PROPAGATION
  return polishProduct(multiplyQuaternions(transport.now.rotation, q));
#else
  return q;
#endif
}

// ---- the root

struct RodRoot {
  float4 rotation;  // bind space to world
  float3 position;  // of vertex 0, relative to the origin [m]
};

RodRoot loadRoot(uint frameIndex, uint root) {
  uint index = (frameIndex * g_rootCount + root) * 2;
  RodRoot pose;
  uint element = firstRootElement() + index;
  pose.rotation = g_state[element];
  pose.position = g_state[element + 1u].xyz;
  return pose;
}

struct RootPath {
  RodRoot from;  // last frame
  RodRoot to;    // this frame
};

// If the root of one frame is no pose, that of the other frame replaces it; if neither is, the
// origin does.
RootPath rootPath(uint root) {
  RootPath path;
  path.to = loadRoot(0, root);
  path.from = loadRoot(1, root);
  bool toValid = isPose(path.to.rotation, path.to.position);
  bool fromValid = isPose(path.from.rotation, path.from.position);
  if (!toValid && !fromValid) {
    path.to.rotation = float4(0.0, 0.0, 0.0, 1.0);
    path.to.position = float3(0.0, 0.0, 0.0);
  } else if (!toValid) {
    path.to = path.from;
  }
  if (!fromValid) path.from = path.to;
  path.to.rotation = normalizeProduct(path.to.rotation);
  path.from.rotation = normalizeProduct(path.from.rotation);
  return path;
}

RodRoot rootAt(RootPath path, float share) {
  float4 rotation = interpolateQuaternions(path.from.rotation, path.to.rotation, share);
  precise float3 position = path.from.position + (path.to.position - path.from.position) * share;
  // Selected, not branched on: some drivers recompile a kernel for every value of a constant on
  // which a branch depends.
  bool ended = share >= 1.0;
  bool begun = share > 0.0;
  RodRoot root;
  root.rotation = ended ? path.to.rotation : (begun ? rotation : path.from.rotation);
  root.position = ended ? path.to.position : (begun ? position : path.from.position);
  return root;
}

// Returns the part of the root's motion from `begin` to `end` that transports the strand.
RigidMotion transportedMotion(RodRoot begin, RodRoot end, float share) {
  RigidMotion motion;
  float4 relativeRotation =
      normalizeProduct(multiplyQuaternions(end.rotation, conjugate(begin.rotation)));
  motion.rotation = interpolateQuaternions(float4(0.0, 0.0, 0.0, 1.0), relativeRotation, share);
  precise float3 shift = begin.position + (end.position - begin.position) * share -
                         rotate(motion.rotation, begin.position);
  motion.shift = shift;
  return motion;
}

#endif
