// Resources of the XPBD baseline (simulate_cosserat.hlsl). Every set is [vertex][strand], strand
// fastest. Inertias are those of a strand of unit linear density.
#ifndef BASELINE_COSSERAT_LAYOUT_HLSLI
#define BASELINE_COSSERAT_LAYOUT_HLSLI

cbuffer CosseratConstants : register(b0, space0) {
  // The roots' rigid motion from bind space, p -> rotate(rotation, p) + shift [m]: at the end of
  // this frame and of the one before.
  float4 g_rotation;
  float4 g_shift;
  float4 g_rotationBefore;
  float4 g_shiftBefore;
  float4 g_gravity;  // xyz [m/s2]
  uint g_strandCount;
  uint g_vertexCount;  // a strand
  uint g_subSteps;
  uint g_restart;   // not 0: take the bind pose, at rest
  float g_subStep;  // h [s]
  float g_drag;     // c of the air [1/s]
  float g_bend;     // B = E I / (rho A) [m4/s2]; 0 leaves bending and twist out
  float g_twist;    // G J / (rho A) [m4/s2]
  float g_inertia;  // of an edge over its length cubed
  float g_cosseratPad0;
  float g_cosseratPad1;
  float g_cosseratPad2;
};

// 4 sets: x [m], w region of the vertex [m]; v [m/s]; frame of the edge behind the vertex, a
// quaternion whose x axis is the edge's direction; angular velocity of that edge [1/s].
RWStructuredBuffer<float4> g_rods : register(u0, space0);
// [strand][vertex] what is drawn: position [m], direction.
RWStructuredBuffer<float4> g_places : register(u1, space0);
RWStructuredBuffer<float4> g_directions : register(u2, space0);
// 2 sets: rotation from edge i - 1 to edge i at rest (0: frame of edge 0 in bind space); bind
// position [m], w length of the edge behind the vertex [m].
StructuredBuffer<float4> g_rodRest : register(t0, space0);

uint rodIndex(uint set, uint vertex, uint strand) {
  return (set * g_vertexCount + vertex) * g_strandCount + strand;
}

#endif
