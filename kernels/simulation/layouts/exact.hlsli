// Resources of the exact strand solver. Group "exact":
//   space0 ExactPosTan  also read by rendering and contact
//   space1 Exact        only for the solver
//
// Strands with different vertex counts share one object. The host sorts them by vertex count and
// puts them into tiles of 32; within a tile the strand is the fastest index, so that neighboring
// threads read neighboring addresses, and a tile is as long as its longest strand. With T the
// number of float4 of all tiles, sum over tiles of 32 times that count, vertex i of a strand is
// element
//   set * T + ExactStrand.state + 32 i
// of g_state and g_rest, for each of their sets of T elements.
//
// The state stores no positions and velocities but the displacements of the vertices in the last
// three steps: positions follow from the root and the frames of the edges, and the solve does not
// need them. Positions are relative to g_origin, so that their rounding does not depend on where in
// the world the hair is: those of the root transforms and of the colliders.
#ifndef PELAGE_SIMULATION_LAYOUTS_EXACT_HLSLI
#define PELAGE_SIMULATION_LAYOUTS_EXACT_HLSLI

#include "../../contact/layouts/contact_records.hlsli"

struct ExactStrand {
  uint state;   // element of vertex 0 in a set: 32 * (lengths of the tiles before) + lane
  uint count;   // vertices, 2..256
  uint target;  // element of vertex 0 in g_positions and g_tangents
  uint root;    // index of its root transform
  uint seed;    // seed of what varies from strand to strand; independent of the order of strands
  float strandLength;  // sum of its edges [m]
  uint pad0;
  uint pad1;
};

// [strand][vertex]: world position [m]; w = inverse mass, 0 for the two vertices at the root.
RWStructuredBuffer<float4> g_positions : register(u0, space0);
// [strand][vertex]: unit tangent; w = 0.
RWStructuredBuffer<float4> g_tangents : register(u1, space0);

// One sub-step of h seconds after one of h_-1. With w = h / h_-1, BDF2 has
//   a2 = -w^2 / (1 + 2 w), he = h (1 + w) / (1 + 2 w);
// without history, or with w outside 0.4..2.1, backward Euler has a2 = 0, he = h. B and Bt are the
// bending and twist stiffness over the mass a length [m4/s2], c the air drag [1/s].
cbuffer ExactConstants : register(b0, space1) {
  uint g_strandRecords;  // element of g_rest where the strands begin; first: decision 0008
  uint g_contactMasks;
  uint g_contactMaskWords;  // of a strand
  float g_twistInertia;     // 0.005 min(1, 60 h): rotary inertia about the tangent over am l^2
  // xyz (g + c wind) / weight [m], weight = 1 / he^2 + c / he; w = fraction by which the
  // accelerations of g_forces are reduced, 0..1
  float4 g_drift;
  // xyz addition of the gusts to g_drift now [m]; w = variation between strands, 0..1
  float4 g_gust0;
  float4 g_gust1;   // xyz the same a quarter of their period later
  float4 g_air;     // xyz wind [m/s], w = c
  float4 g_origin;  // xyz of the state's origin in world space [m]
  float4 g_rebase;  // xyz [m]: with flag bit 2, what to add to a position relative to the last
                    // frame's origin
  // Weights of the displacements of the last three steps in that of a free vertex. With s = 1 / (he
  // weight), a' and he' of the step before, a" and he" of the one before that:
  float g_displacementShare;         // s (1 - a2) / he' - a2
  float g_displacementShareBefore;   // s ((1 - a2) a2' / he' + a2 / he")
  float g_displacementShareEarlier;  // s a2 a2" / he"; 0 for missing steps
  float g_historyShare;              // a2
  float g_inverseStep;               // 1 / he [1/s]
  float g_weight;                    // 1 / he^2 + c / he [1/s2]
  float g_rotationRatio;  // w, 0 without history; 1 exactly while the step does not change
  // 0.02 min(1, (240 h)^2) + c^2 min(1, (60 h)^4) [rad]: rotation of an edge in a step at which the
  // guess extrapolates half of its twist; less of slower edges. At 0 a loose curl never comes to
  // rest with one pass (it creeps on a cycle of 0.1 % of its length); from 0.1 on undamped strands
  // gain energy. With drag the twist, which has no mass, stays as it is
  float g_slowRotation;
  float g_bendStiffness;    // B
  float g_twistStiffness;   // Bt
  float g_damping;          // tau / h of Kelvin-Voigt damping; 0: none
  float g_targetStiffness;  // of the global shape, s / (1 - s) * 3600 [1/s2]
  float g_targetRange;  // fraction of the strand with full stiffness, > 0; fades to 0 at 1.25 times
  float g_passTolerance;    // largest rotation of a first pass without a second one [rad]: 0.04 +
                            // 0.2 (min(c, 3) min(1, 60 h))^2; above 4 there never is one
  float g_rootBegin;        // root pose at the sub-step's start, 0 = last frame, 1 = this frame
  float g_rootEnd;          // root pose at its end
  float g_frameTime;        // of this frame [s], > 0
  float g_frameTimeBefore;  // of the last frame [s]; of this one if there was none
  float g_vspCoefficient;   // fraction of the root's motion that the strand follows, 0..1
  float g_vspThreshold;     // acceleration of the root [m/s2] above which the share grows; it is 1
                            // from twice the value on; > 0, may be infinite
  uint g_strandCount;
  uint g_stateStride;  // T
  uint g_rootCount;
  uint g_outputCount;  // elements of g_positions and g_tangents
  uint g_colliderCount;
  uint g_slot;            // 0..3: the state now; the next one goes to (g_slot + 1) % 4, which the
                          // host passes in the next sub-step
  uint g_flags;           // bits: the flags below
  uint g_outputVertices;  // elements of a strand in g_positions and g_tangents; those past its
                          // own vertices repeat its tip. 0: as many as it has vertices
  uint g_parameterSet;    // set of g_rest with factors of every vertex; 0: there is none
  float g_restSpeed;      // speed below which a strand is at rest [m/s]
  float g_restTime;       // time at rest before it sleeps [s]
  float g_wakeDistance;   // motion of a root or a collider that wakes it [m]
  uint g_followGroups;    // groups in x of an update of the follow hairs
  uint g_slotsBack;       // 0..3: increment of a tile's offset of g_slot per frame of sleep
  // Level of detail, in indices of strands: only those before g_simulatedCount are simulated, and
  // from g_fadeStart on they fade; without it both are g_strandCount (interpolate_guides.hlsl).
  uint g_simulatedCount;
  uint g_fadeStart;
  uint g_restartFrom;
  uint g_contactHead;  // words of g_contactWords, with contacts
  uint g_contactList;
  float g_guessTrend;  // 0.5 min(c, 1): fraction of the last guess's error that a guess adds to
                       // the last rotation of an edge
  uint g_bindSet;      // set of g_rest with the joints of the bind pose; 0: they are those at rest
  uint g_exactPad0;
  uint g_exactPad1;
  uint g_exactPad2;
};

// Bits of g_flags.
static const uint kResetFlag = 1;     // reset to the rest shape
static const uint kLastFlag = 2;      // last sub-step of the frame
static const uint kRebaseFlag = 4;    // rebase the state
static const uint kSleepFlag = 8;     // only the tiles that are awake
static const uint kWakeAllFlag = 16;  // all tiles wake
static const uint kChangedFlag = 32;  // g_rotationRatio is not 1
static const uint kRestartFlag = 64;  // interpolate_guides makes states
// A second round: only listed strands; they continue from the result.
static const uint kAgainFlag = 128;
static const uint kPoseFlag = 256;  // only the reset, with its positions
// Groups of eliminate_strands and roll_out_strands have 8 strands rather than 32.
static const uint kNarrowFlag = 512;

static const uint kTileStrands = 32;
// Strands of a group with kNarrowFlag, and in a second round. A group takes as long as all that its
// strands do one after the other where they differ.
static const uint kNarrowStrands = 8;
static const uint kAgainStrands = 4;
// Sets of g_state with states and with gains; number of states; elements of a strand in a state.
static const uint kStateSets = 8;
static const uint kGainSets = 6;
static const uint kStateSlots = 4;
static const uint kStrandElements = 5;
static const uint kRootAlignment = 16;

// 8 sets. 0..3: of four states, the displacement of the vertex in the step that led to it, without
// what was transported [m], 0 for vertices 0 and 1, and in w the next rotation of the edge before
// it (nextHalfRotation() in exact_math.hlsli; 0: none); 4..7: frames of the edges, world space, x
// axis = tangent. Behind the sets, 5 elements a strand for each of the four states, element
// 8 T + (5 slot + k) g_strandCount + index of the strand:
//   0: sum over the free edges of l (t(guess of the next step) - t); valid while the step does not
//      change
//   1: position of vertex 1 [m]   2: of the tip   3: velocity of the root in the last frame [m/s]
//   4: rotation by which this step transported the previous state
// Then 6 sets of scratch, the control law of every edge; vertex 0 has the displacement of the tip
// for a second round of contacts. Then, from a multiple of kRootAlignment
// on, [2][root][2]: of this frame (0) and the last one (1) rotation, then position of vertex 0
// relative to g_origin [m]: two elements as a RootTransform; other kernels bind the buffer from
// there on. The host makes it zero, and starts with a reset.
RWStructuredBuffer<float4> g_state : register(u0, space1);
// Set 0, the joints.
//   Vertices 1..n-2: y / (1 + w) and z / (1 + w) of the rotation q from edge i - 1 to edge i at
//   rest, in the frame of edge i - 1, with w >= 0; frames are those of parallel transport, so that
//   q.x = 0. Then the length of edge i and the Voronoi length of the vertex [m].
//   Vertex 0: the frame of edge 0 in bind space.
//   The tip: the length of edge 0, 0, 0, the tip's Voronoi length.
// With the globalShape permutation a second set: xyz bind position relative to that of vertex 0
// [m], w arc length from the root over the strand's length, 0..1, or -1 for a vertex that is held
// where the bind pose has it. Where the rest shape balances gravity, a set with the rotations from
// edge i - 1 to edge i in the bind pose, in the frame of edge i - 1; they have a twist. One more set
// with factors: x on bending and twist, y on the global shape, z on the air drag; w unused. Behind the sets [strand] an ExactStrand in two elements, as
// its bits.
StructuredBuffer<float4> g_rest : register(t0, space1);
StructuredBuffer<Collider> g_exactColliders : register(t1, space1);

// [strand][vertex] as g_positions; with the forces permutation. xyz = acceleration a [m/s2], w =
// drag k [1/s], >= 0: the equation of motion gets a - k v. With a = k u it is a drag towards the
// velocity u.
StructuredBuffer<float4> g_forces : register(t2, space1);
// The tiles that are awake, T of them, as select_awake_tiles lists them:
//   0..2           groups of an indirect dispatch over the list: kSleepSolveArguments
//   3              strands awake
//   4..6           groups of an indirect dispatch over the follow hairs: 0 while all sleep
//   7              second passes
//   8..10          groups of find_contacts over the list
//   16..16+T-1     the list
//   16+T..16+2T-1  what to add to g_slot for a tile that slept
//   16+2T..        [strand] time at rest [s], as the bits of a float
RWStructuredBuffer<uint> g_sleep : register(u1, space1);
static const uint kSleepSolveArguments = 0;
static const uint kSleepAwakeStrands = 3;
static const uint kSleepFollowArguments = 4;
static const uint kSleepSecondPasses = 7;
static const uint kSleepFindArguments = 8;
static const uint kSleepHead = 16;  // words before the list
// [strand] index of a strand near it and before it.
StructuredBuffer<uint> g_lodParents : register(t3, space1);
// As contact_records.hlsli has them; only kernels with contacts bind them.
RWStructuredBuffer<uint4> g_contacts : register(u2, space1);
RWStructuredBuffer<uint> g_contactWords : register(u3, space1);

#endif
