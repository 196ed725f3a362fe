// Where a strand's state is, and the rigid motion that carries it along with its root.
#ifndef PELAGE_SIMULATION_EXACT_ROD_STATE_HLSLI
#define PELAGE_SIMULATION_EXACT_ROD_STATE_HLSLI

#include "../../layouts/exact.hlsli"
#include "rod_math.hlsli"

static const uint kTileStrands = 32;
static const uint kPositionSets = 0;
static const uint kVelocitySets = 3;
static const uint kFrameSets = 6;

// Element of a vertex in a set of g_state, g_rest or g_gains.
uint stateIndex(uint set, uint vertex, ExactStrand strand) {
  return set * g_stateStride + strand.state + vertex * kTileStrands;
}

// The three states of g_state.
struct Slots {
  uint now;
  uint before;
  uint next;
};

// \param offset of a tile that slept, 0..2
Slots stateSlots(uint offset) {
  Slots slots;
  slots.now = (g_slot + offset) % 3;
  slots.next = slots.now == 2 ? 0 : slots.now + 1;
  slots.before = slots.now == 0 ? 2 : slots.now - 1;
  return slots;
}

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

// What a sub-step does to the states that it starts from. Without velocity shock propagation that
// is nothing, and no code. What is stored stays as it is, and differences are taken before they are
// turned.
struct Carry {
#if VELOCITY_SHOCK_PROPAGATION
  RigidMotion now;     // by this sub-step
  RigidMotion before;  // by the last one, of what is the state before now
  float4 both;         // rotation of both
#else
  uint unused;
#endif
};

float3 carryPoint(Carry carry, float3 p) {
#if VELOCITY_SHOCK_PROPAGATION
  return movePoint(carry.now, p);
#else
  return p;
#endif
}
// x_-1 - x.
float3 carriedWayBack(Carry carry, float3 now, float3 before) {
#if VELOCITY_SHOCK_PROPAGATION
  precise float3 way = movePoint(carry.before, before) - now;
  return rotate(carry.now.rotation, way);
#else
  precise float3 way = before - now;
  return way;
#endif
}
// v + share (v_-1 - v).
float3 carriedVelocity(Carry carry, float3 now, float3 before, float share) {
#if VELOCITY_SHOCK_PROPAGATION
  float3 carried = rotate(carry.before.rotation, before);
  precise float3 mixed = now + (carried - now) * share;
  return rotate(carry.now.rotation, mixed);
#else
  precise float3 mixed = now + (before - now) * share;
  return mixed;
#endif
}
float4 carryFrame(Carry carry, float4 q) {
#if VELOCITY_SHOCK_PROPAGATION
  return normalizeProduct(multiplyQuaternions(carry.now.rotation, q));
#else
  return q;
#endif
}
float4 carryFrameBefore(Carry carry, float4 q) {
#if VELOCITY_SHOCK_PROPAGATION
  return normalizeProduct(multiplyQuaternions(carry.both, q));
#else
  return q;
#endif
}

// ---- the root

struct RodRoot {
  float4 rotation;  // bind space to world
  float3 position;  // of vertex 0, relative to the origin [m]
};

// False for a buffer that nobody wrote, and for numbers that cannot be a pose.
bool isRodRoot(RodRoot root) {
  if (!isUsable(root.rotation) || !isUsable(root.position)) return false;
  precise float squared = dot4(root.rotation, root.rotation);
  return squared > 0.25 && squared < 4.0;
}

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
  bool toValid = isRodRoot(path.to);
  bool fromValid = isRodRoot(path.from);
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
  if (share >= 1.0) return path.to;
  if (share <= 0.0) return path.from;
  RodRoot root;
  root.rotation = interpolateQuaternions(path.from.rotation, path.to.rotation, share);
  precise float3 position = path.from.position + (path.to.position - path.from.position) * share;
  root.position = position;
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
