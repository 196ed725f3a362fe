// Where a strand's state is, and the rigid motion that carries it along with its root.
#ifndef PELAGE_SIMULATION_EXACT_ROD_STATE_HLSLI
#define PELAGE_SIMULATION_EXACT_ROD_STATE_HLSLI

#include "../../layouts/exact.hlsli"
#include "rod_math.hlsli"

static const uint kTileStrands = 32;
static const uint kWaySets = 0;
static const uint kFrameSets = 4;
static const uint kStateSets = 8;
// Words of g_sleep before the list of tiles.
static const uint kSleepHead = 12;
// Vertices a strand may have.
static const uint kMinCount = 2;
static const uint kMaxCount = 256;

// Element of a vertex in a set of g_state, g_rest or g_gains.
uint stateIndex(uint set, uint vertex, ExactStrand strand) {
  return set * g_stateStride + strand.state + vertex * kTileStrands;
}

// False for a record that does not fit the buffers of the state and the roots.
bool isSound(ExactStrand strand) {
  if (strand.count < kMinCount || strand.count > kMaxCount) return false;
  uint reach = (strand.count - 1) * kTileStrands;
  if (reach >= g_stateStride || strand.state >= g_stateStride - reach) return false;
  return strand.root < g_rootCount;
}

// False for one that does not fit g_positions and g_tangents.
bool fitsOutputs(ExactStrand strand) {
  uint outputs = max(strand.count, g_outputVertices);
  return outputs <= g_outputCount && strand.target <= g_outputCount - outputs;
}

uint tileCount() { return (g_strandCount + kTileStrands - 1) / kTileStrands; }

// Elements of a strand in a state.
static const uint kGuessedWay = 0;
static const uint kFirstPosition = 1;
static const uint kTipPosition = 2;
static const uint kRootVelocity = 3;
static const uint kCarryRotation = 4;
static const uint kStrandElements = 5;

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

// \param offset of a tile that slept, 0..3
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
struct Turning {
  float3 x;
  float3 y;
  float3 z;
};

Turning turningOf(float4 q, float factor) {
  float3 ex = rotate(q, float3(1.0, 0.0, 0.0));
  float3 ey = rotate(q, float3(0.0, 1.0, 0.0));
  float3 ez = rotate(q, float3(0.0, 0.0, 1.0));
  precise float3 x = float3(ex.x, ey.x, ez.x) * factor;
  precise float3 y = float3(ex.y, ey.y, ez.y) * factor;
  precise float3 z = float3(ex.z, ey.z, ez.z) * factor;
  Turning turning;
  turning.x = x;
  turning.y = y;
  turning.z = z;
  return turning;
}

float3 turnWay(Turning turning, float3 way) {
  precise float3 r = float3(dot3(turning.x, way), dot3(turning.y, way), dot3(turning.z, way));
  return r;
}

// What a sub-step does to the states that it starts from. Without velocity shock propagation that
// is nothing, and no code. What is stored stays as it is.
struct Carry {
#if VELOCITY_SHOCK_PROPAGATION
  RigidMotion now;       // by this sub-step
  Turning way;           // of the ways of the last three steps, with their shares
  Turning wayBefore;
  Turning wayEarlier;
#else
  uint unused;
#endif
};

#if VELOCITY_SHOCK_PROPAGATION
// \param before, earlier rotations by the two sub-steps before
Carry carryOf(RigidMotion now, float4 before, float4 earlier) {
  float4 both = normalizeProduct(multiplyQuaternions(now.rotation, before));
  float4 all = normalizeProduct(multiplyQuaternions(both, earlier));
  Carry carry;
  carry.now = now;
  carry.way = turningOf(now.rotation, g_wayShare);
  carry.wayBefore = turningOf(both, g_wayShareBefore);
  carry.wayEarlier = turningOf(all, g_wayShareEarlier);
  return carry;
}
#endif

float3 carryPoint(Carry carry, float3 p) {
#if VELOCITY_SHOCK_PROPAGATION
  return movePoint(carry.now, p);
#else
  return p;
#endif
}
float3 carryWay(Carry carry, float3 way) {
#if VELOCITY_SHOCK_PROPAGATION
  return rotate(carry.now.rotation, way);
#else
  return way;
#endif
}
// Where the last three ways lead.
float3 carriedWays(Carry carry, float3 way, float3 before, float3 earlier) {
#if VELOCITY_SHOCK_PROPAGATION
  precise float3 r = turnWay(carry.way, way) + turnWay(carry.wayBefore, before) +
                     turnWay(carry.wayEarlier, earlier);
#else
  precise float3 r =
      way * g_wayShare + before * g_wayShareBefore + earlier * g_wayShareEarlier;
#endif
  return r;
}
#if CONTACTS
// As carriedWays(), without what an impact would make of it. BDF2 goes on with the last change of the
// displacement: after an impact that would be a rebound of two thirds of the speed. Here a change
// goes on only as far as it agrees with the one before it (a minmod limiter, as LeVeque, Finite
// Volume Methods for Hyperbolic Problems, section 6.9). Smooth motion stays as it is.
float3 limitedWays(Carry carry, float3 way, float3 before, float3 earlier) {
  if (g_wayShare == 0.0 || g_wayShareBefore == 0.0 || g_wayShareEarlier == 0.0)
    return carriedWays(carry, way, before, earlier);
#if VELOCITY_SHOCK_PROPAGATION
  precise float3 w0 = turnWay(carry.way, way) / g_wayShare;
  precise float3 w1 = turnWay(carry.wayBefore, before) / g_wayShareBefore;
  precise float3 w2 = turnWay(carry.wayEarlier, earlier) / g_wayShareEarlier;
#else
  precise float3 w0 = way;
  precise float3 w1 = before;
  precise float3 w2 = earlier;
#endif
  precise float3 change = w0 - w1;
  precise float3 changeBefore = w1 - w2;
  precise float3 steady = w0 * (g_wayShare + g_wayShareBefore + g_wayShareEarlier);
  if (!(dot3(change, changeBefore) > 0.0)) return steady;
  precise float size = dot3(change, change);
  precise float sizeBefore = dot3(changeBefore, changeBefore);
  if (size > 4.0 * sizeBefore) change = change * squareRoot(4.0 * sizeBefore / size);
  if (sizeBefore > 4.0 * size) changeBefore = changeBefore * squareRoot(4.0 * size / sizeBefore);
  precise float3 r = steady - change * (g_wayShareBefore + g_wayShareEarlier) -
                     changeBefore * g_wayShareEarlier;
  return r;
}
#endif
float4 carryFrame(Carry carry, float4 q) {
#if VELOCITY_SHOCK_PROPAGATION
  return polishProduct(multiplyQuaternions(carry.now.rotation, q));
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
  pose.rotation = g_rootFrames[index];
  pose.position = g_rootFrames[index + 1].xyz;
  return pose;
}

struct RootPath {
  RodRoot from;  // last frame
  RodRoot to;    // this frame
};

// Where one frame's root is no pose, the other one's stands in for it; where both are none, the
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
  // Selected, not branched on: some drivers compile a kernel anew for every value of a constant that
  // a branch depends on.
  bool ended = share >= 1.0;
  bool begun = share > 0.0;
  RodRoot root;
  root.rotation = ended ? path.to.rotation : (begun ? rotation : path.from.rotation);
  root.position = ended ? path.to.position : (begun ? position : path.from.position);
  return root;
}

// The share of the root's motion from `begin` to `end` that the strand is carried by.
RigidMotion carriedMotion(RodRoot begin, RodRoot end, float share) {
  RigidMotion motion;
  float4 turn =
      normalizeProduct(multiplyQuaternions(end.rotation, conjugate(begin.rotation)));
  motion.rotation = interpolateQuaternions(float4(0.0, 0.0, 0.0, 1.0), turn, share);
  precise float3 shift = begin.position + (end.position - begin.position) * share -
                         rotate(motion.rotation, begin.position);
  motion.shift = shift;
  return motion;
}

#endif
