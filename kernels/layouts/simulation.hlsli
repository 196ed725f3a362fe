// Resources of the simulation kernels. Group "simulation":
//   space0 SimPosTan  what rendering and the SDF read too
//   space1 Sim        what only the simulation needs
// Every simulation kernel includes this file, so a resource has one slot everywhere.
//
// Sizes: G guide strands, F follow strands, V vertices a strand. Guide strands come first.
#ifndef PELAGE_LAYOUTS_SIMULATION_HLSLI
#define PELAGE_LAYOUTS_SIMULATION_HLSLI

// One guide root's bones: x..w index g_boneTransforms (in bones), the weights sum to anything > 0.
struct RootBinding {
  uint4 bones;
  float4 weights;
};

// Rigid frame of a guide's root in world space: x = rotate(rotation, p - bindRoot) + position.xyz.
struct RootTransform {
  float4 rotation;  // unit quaternion
  float4 position;  // xyz of vertex 0 in metres; w unused
};

// A follow strand: copies its guide, shifted by an offset that turns with the guide's root.
struct FollowStrand {
  float4 offset;  // xyz in bind space [m]; w = factor on the offset at the tip (1 = parallel)
  uint guide;     // index of the guide strand
  uint pad0;
  uint pad1;
  uint pad2;
};

// [strand][vertex], (G + F) * V: world position [m]; w = inverse mass.
RWStructuredBuffer<float4> g_positions : register(u0, space0);
// [strand][vertex], (G + F) * V: unit tangent; w = 0.
RWStructuredBuffer<float4> g_tangents : register(u1, space0);

cbuffer SimulationConstants : register(b0, space1) {
  float4 g_gravity;   // xyz [m/s2]; w unused
  float4 g_wind;      // xyz velocity of the air [m/s], gusts included; w = air drag [1/s]
  uint g_guideCount;
  uint g_followCount;
  uint g_vertexCount;  // vertices a strand, 2..256
  uint g_boneCount;
  float g_timeStep;          // this sub-step [s], > 0
  float g_timeStepRatio;     // this sub-step over the one before, 1 when there was none
  float g_rootBegin;         // root pose at the sub-step's start, 0 = last frame, 1 = this frame
  float g_rootEnd;           // root pose at its end
  float g_dampingKeep;       // velocity kept in this sub-step, (1 - damping)^(60 h)
  float g_gravityStep;       // displacement in this sub-step for 1 m/s2 [s2]
  float g_localStiffness;    // correction a vertex and sub-step, mapped to the sub-step
  float g_globalStiffness;   // share of the way to the goal in this sub-step
  float g_globalRange;       // share of the strand that global stiffness acts on, 0..1
  float g_vspCoefficient;    // share of the root's motion carried by the strand, 0..1
  float g_vspThreshold;      // pseudo-acceleration of the root above which all of it is [m/s2]
  float g_maxSpeed;          // [m/s]
  uint g_localIterations;
  uint g_lengthIterations;
  float g_tipSeparation;     // factor on the follow offsets at the tip, on top of FollowStrand's
  uint g_flags;              // bit 0: reset (take the goal, forget velocities)
};

// [2][G]: root frames of this frame (0) and the last one (1).
RWStructuredBuffer<RootTransform> g_rootTransforms : register(u0, space1);
// [2][V][G], strand fastest: current (0) and previous (1) position of the guides [m]; the w
// components are scratch of the length solve.
RWStructuredBuffer<float4> g_state : register(u1, space1);
// [2][V][G], strand fastest: 0: bind position, w = inverse mass (0 or 1); 1: the next segment's rest
// vector in this vertex's rest frame [m], w = rest length [m].
StructuredBuffer<float4> g_rest : register(t0, space1);
// Skinning matrices, 3 rows a bone (bind space to world), or dual quaternions, 2 float4 a bone.
StructuredBuffer<float4> g_boneTransforms : register(t1, space1);
// [G]
StructuredBuffer<RootBinding> g_rootBindings : register(t2, space1);
// [F]
StructuredBuffer<FollowStrand> g_followStrands : register(t3, space1);

#endif
