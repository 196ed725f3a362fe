// Resources of the simulation kernels. Group "simulation":
//   space0 SimPosTan  also read by rendering and contact
//   space1 Sim        only for the simulation
// Every simulation kernel includes this file, so a resource has one slot everywhere.
//
// Sizes: G guide strands, F follow hairs, V vertices per strand. Guides come first. Follow hairs
// that only drawing needs are not stored: F is then 0.
#ifndef PELAGE_SIMULATION_LAYOUTS_SIMULATION_HLSLI
#define PELAGE_SIMULATION_LAYOUTS_SIMULATION_HLSLI

#include "../../contact/layouts/contact_records.hlsli"
#include "follow.hlsli"

// The bones of one guide root: x..w index g_boneTransforms (in bones), the weights sum to anything
// > 0.
struct RootBinding {
  uint4 bones;
  float4 weights;
};

// [strand][vertex], (G + F) * V: world position [m]; w = inverse mass.
RWStructuredBuffer<float4> g_positions : register(u0, space0);
// [strand][vertex], (G + F) * V: unit tangent; w = 0.
RWStructuredBuffer<float4> g_tangents : register(u1, space0);

// One sub-step of h seconds. The artist's damping d, stiffnesses s and iterations are defined for
// steps of h0 = 1/60 s, and the classic solver works with these steps even if h is shorter: it
// computes where a step of H = max(h, h0) would take the hair, and applies a fraction of that
// (simulate_classic.hlsl). The host converts values to H, which changes them only if h > h0:
//   keep(t)   = (1 - d)^(t / h0)
//   square(t) = t h0 (1 - keep(t)) / d [s2]: displacement in a step of t for 1 m/s2; t^2 for d = 0
//   map(s)    = a / (1 + a), a = (H / h0)^2 s / (1 - s), with s <= 0.9999: a spring of the same
//               stiffness, taken implicitly over H instead of h0
cbuffer SimulationConstants : register(b0, space1) {
  uint g_contactMasks;      // words of g_contactWords, with contacts; first: decision 0008
  uint g_contactMaskWords;  // of a strand
  uint g_factorSet;         // set of g_rest with factors of every vertex, 2; 0: there is none
  float g_forceShare;       // square(h) / square(H), in 0..1
  float4 g_gravity;  // xyz [m/s2]; w = fraction by which the accelerations of g_strandForces are
                     // reduced, 0..1
  float4 g_wind;     // xyz velocity of the air [m/s], gusts included; w = air drag c [1/s]; 0: none
  float4 g_gust0;    // xyz part of the gusts in it now [m/s]; w = variation between strands, 0..1
  float4 g_gust1;    // xyz the same a quarter of their period later
  float4 g_origin;   // xyz of the object's origin in world space [m]; state, roots and colliders
                     // are relative to it
  float4 g_rebase;   // xyz [m]: what to add to a position relative to the last frame's origin; 0
                     // while the origin stays. skin_roots moves the roots, and the sub-step with
                     // flag bit 1 the state
  uint g_guideCount;
  uint g_followCount;
  uint g_vertexCount;  // vertices per strand, 2..256
  uint g_boneCount;
  float g_timeStep;       // h, this sub-step [s], > 0
  float g_timeStepRatio;  // this sub-step over the last one, 1 if there was none
  float g_rootBegin;      // root pose at the sub-step's start, 0 = last frame, 1 = this frame
  float g_rootEnd;        // root pose at its end
  float g_dampingKeep;    // keep(H): fraction of the velocity that remains after H
  float g_gravityStep;    // square(H)
  // map(min(s, 0.95)): fraction of the displacement to the rest vector per sweep
  float g_localStiffness;
  float g_globalStiffness;  // map(s): fraction of the displacement to the target in H; 0: none
  float g_globalRange;  // fraction of the strand's vertices on which it acts, 0..1, from the root
  // fraction of the root's motion that the strand follows, 0..1; with 0 and an infinite threshold
  // there is no shock propagation
  float g_vspCoefficient;
  float g_vspThreshold;     // acceleration of the root [m/s2] above which the share grows; it is
                            // 1 from twice the value on; > 0, may be infinite
  float g_maxSpeed;         // of the free motion, without the transport [m/s]
  uint g_localIterations;   // sweeps of the local shape, at most 64; 0: none
  uint g_lengthIterations;  // the solve of tensions and the Newton steps after it, at most 64
  float g_tipSeparation;    // factor on the follow offsets at the tip, on top of FollowHairRecord's
  uint g_flags;             // bits: the flags below
};

// Bits of g_flags.
static const uint kResetFlag = 1;            // take the bind-pose target, forget velocities
static const uint kRebaseFlag = 2;           // the origin has moved
static const uint kDualQuaternionsFlag = 4;  // the bones are dual quaternions

// Sets of g_rootTransforms and of g_state.
static const uint kRootSets = 2;
static const uint kStateSets = 4;
static const uint kRootAlignment = 16;
// Follow hairs that a thread of update_follow_hairs poses.
static const uint kStrandsAThread = 4;

// [2][G]: root frames of this frame (0) and the last one (1): a part of g_state's buffer.
RWStructuredBuffer<RootTransform> g_rootTransforms : register(u0, space1);
// [4][V][G], strand fastest: current (0) and previous (1) position of the guides [m], relative to
// g_origin; the w components and sets 2 and 3 are scratch, set 3 that of the length solve. Then,
// from a multiple of kRootAlignment on, the elements of g_rootTransforms, two each.
RWStructuredBuffer<float4> g_state : register(u1, space1);
// [2 or 3][V][G], strand fastest. 0: bind position b_i [m], w = inverse mass (0 or 1; vertices 0
// and 1 are always held). 1: rest vector of the segment from vertex i to i + 1 in the frame of the
// previous segment [m], w = rest length |b_i+1 - b_i| [m]; at the last vertex, which has no next
// segment, F_0 as a quaternion. The frames F_i of the segments have the segment's direction t_i as
// x axis (that of the previous segment if the length is 0) and are transported from the root
// without twist: F_0 = between(e_x, t_0), F_i = between(t_i-1, t_i) F_i-1. The rest vector of
// segment i is conj(F_max(i-1, 0)) (b_i+1 - b_i). With factors a third set: x on the spring of the
// local shape that ends at the vertex, y on that of the global shape, z on the damping; >= 0, w
// unused.
StructuredBuffer<float4> g_rest : register(t0, space1);
// Skinning transforms, bind space to world: 3 rows of [M | t] a bone, or, with bit 2 of g_flags,
// 2 quaternions a bone: the rotation r and the dual part t r / 2 (skinning/bones.hlsli).
StructuredBuffer<float4> g_boneTransforms : register(t1, space1);
// [G]
StructuredBuffer<RootBinding> g_rootBindings : register(t2, space1);
// [F]; neighbors with the same guides share the work on them.
StructuredBuffer<FollowHairRecord> g_followHairRecords : register(t3, space1);
// [G][V] as g_positions; with the forces permutation. xyz = acceleration a [m/s2], w = drag k
// [1/s], >= 0: the equation of motion gets a - k v. A drag towards the velocity u is a = k u.
StructuredBuffer<float4> g_strandForces : register(t5, space1);
// With the contacts permutation: contact_records.hlsli.
StructuredBuffer<uint4> g_contacts : register(t4, space1);
StructuredBuffer<uint> g_contactWords : register(t6, space1);

#endif
