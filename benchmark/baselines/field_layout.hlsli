// Resources of the classic baseline of distance fields: the build and the collision of TressFX 4.0
// as its behaviour is known: the measured node counts, wrong signs and unset nodes of the body
// fixed the sizes of grid and boxes here:
//   clear_field    every node gets a distance that nothing has
//   scatter_field  a thread a triangle: each node of its box, two cells larger on every side, takes
//                  the distance of the smallest magnitude, with the sign of that triangle's plane
//   finish_field   keys become floats, every node of them
//   push_points    trilinear distance, gradient by forward differences: four samples
// It keeps what makes it what it is: the sign is that of whichever triangle wins a tie, the inside
// beyond those cells is never written, nodes without a distance have 1e10 and take part in
// gradients, and what is pushed out stands still afterwards. Left out is what would be undefined (a
// signed minimum on unsigned keys, more than 65,535 groups, reads outside the grid).
#ifndef BASELINE_FIELD_LAYOUT_HLSLI
#define BASELINE_FIELD_LAYOUT_HLSLI

cbuffer FieldConstants : register(b0, space0) {
  float4 g_fieldOrigin;  // xyz node 0 [m], w cell size [m]
  uint4 g_fieldNodes;    // xyz counts, x fastest; w all of them
  uint g_triangleCount;
  uint g_pointCount;
  float g_margin;  // [m] what is nearer is pushed out to here
  uint g_fieldPad;
};

// [node] while it is built: magnitude in the upper 31 bits, sign in the lowest one, so that a
// smaller key is a smaller magnitude; then the bits of the signed distance [m].
RWStructuredBuffer<uint> g_fieldKeys : register(u0, space0);
RWStructuredBuffer<float4> g_points : register(u1, space0);        // xyz now [m], w > 0 free
RWStructuredBuffer<float4> g_pointsBefore : register(u2, space0);  // xyz a step ago [m]
StructuredBuffer<float4> g_corners : register(t0, space0);         // [vertex] xyz [m]
StructuredBuffer<uint> g_triangles : register(t1, space0);         // [triangle][corner] vertex

static const float kNothing = 1e10;

// Threads come in rows of 2^20, because an axis has at most 65,535 groups.
uint nodeOf(uint3 thread) { return (thread.y << 20) | thread.x; }

uint toKey(float distance) {
  uint bits = asuint(distance);
  return (bits << 1) | (bits >> 31);
}

float fromKey(uint key) { return asfloat((key >> 1) | (key << 31)); }

#endif
