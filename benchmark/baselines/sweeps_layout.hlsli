// Resources of the classic baseline: the pipeline of TressFX 4.0 as the project's notes describe it
// (its code was not looked at), one step of 1/60 s a frame:
//   verlet_strands  Verlet integration and global shape, a thread a vertex
//   carry_strands   velocity shock propagation, a thread a vertex
//   sweep_shape     local shape, a thread a strand
//   sweep_lengths   red/black Gauss-Seidel on the lengths in group-shared memory, a thread a vertex
// It keeps what makes it what it is: parameters are for a frame and not for a second, lengths do
// not converge, velocity shock propagation loses the twist and blends positions, strands of 64
// vertices get one sweep of local shape, and only 4, 8, 16, 32 and 64 vertices work. Left out is
// what would be undefined (reads past the end, missing barriers, padding strands), and wind and
// collision, which no benchmark scene has; so its times are lower bounds.
#ifndef BASELINE_SWEEPS_LAYOUT_HLSLI
#define BASELINE_SWEEPS_LAYOUT_HLSLI

cbuffer SweepConstants : register(b0, space0) {
  // The roots' rigid motion from bind space, p -> rotate(rotation, p) + shift [m]: in this frame,
  // and in the one and the two before.
  float4 g_rotation;
  float4 g_shift;
  float4 g_rotationBefore;
  float4 g_shiftBefore;
  float4 g_rotationEarlier;
  float4 g_shiftEarlier;
  float4 g_fall;  // xyz gravity times the step squared [m]
  uint g_strandCount;
  uint g_vertexCount;  // a strand
  uint g_lengthSweeps;
  uint g_shapeSweeps;
  float g_damping;          // share of the velocity lost in a frame
  float g_localStiffness;   // 0..1, share of the way in a sweep
  float g_globalStiffness;  // 0..1, share of the way in a frame
  float g_globalRange;      // share of the vertices it acts on
  float g_carryShare;       // share of the root's motion that the strand takes part in
  float g_carryThreshold;   // acceleration [m a frame squared] above which it takes part in all
  uint g_restart;           // not 0: take the bind pose, at rest
  uint g_sweepPad;
};

// All [strand][vertex].
RWStructuredBuffer<float4> g_places : register(u0, space0);        // now [m]
RWStructuredBuffer<float4> g_placesBefore : register(u1, space0);  // a frame ago [m]
RWStructuredBuffer<float4> g_directions : register(u2, space0);    // unit tangents
StructuredBuffer<float4> g_bind : register(t0, space0);            // xyz [m], w inverse mass
// xyz edge from vertex i to i + 1 in the frame of the edge before [m], w its length [m]; at the
// last vertex the frame of edge 0 in bind space, as a quaternion.
StructuredBuffer<float4> g_edges : register(t1, space0);

// Vertices 0 and 1 follow the root.
bool isFree(uint vertex, float inverseMass) { return vertex > 1 && inverseMass > 0.0; }

#endif
