// Resources of the grid for hair-hair contact. Group "hairGrid", all in space0.
//
// The grid has g_gridSize^3 nodes, x fastest, a cell size apart. A node has 1 word, its mass, or
// with g_gridFriction 4: the three components of momentum, too, in two's complement fixed point.
#ifndef PELAGE_CONTACT_LAYOUTS_HAIR_GRID_HLSLI
#define PELAGE_CONTACT_LAYOUTS_HAIR_GRID_HLSLI

// Nodes an axis; the number of words must fit a dispatch.
static const uint kMaxGridSize = 64;

// Mass is length of hair [m]: a guide stands for itself and for its follow hairs. With M the mass
// of all vertices, the host sets
//   g_massScale     <= 2^31 / M          a node's mass is at most M
//   g_momentumScale <= 2^30 / (M vmax)   and its momentum at most M vmax, a component
// as powers of two. No sum overflows, whatever the strands do: N vertices add at most 4 N by
// rounding, for which there is room up to N = 2^28.
cbuffer HairGridConstants : register(b0, space0) {
  uint g_gridPad0;  // first: decision 0008
  uint g_gridPad1;
  uint g_gridFriction;     // 0 or 1: nodes have a momentum
  uint g_addsForces;       // 0 or 1: g_otherForces are added
  float4 g_gridOrigin;     // xyz of node 0 in world space [m]; w = cell size [m]
  float4 g_gridVelocity;   // xyz of the object as a whole [m/s], what momentum is relative to; w =
                           // vmax [m/s], largest component of a velocity relative to it
  float g_massScale;       // quanta per meter of hair
  float g_momentumScale;   // quanta per meter of hair times m/s
  float g_pressure;        // c^2 of apply_hair_grid [m2/s2]; 0: no pressure, and no rest density
  float g_frictionRate;    // fraction of a relative velocity to remove over the step [1/s]
  float g_lookAhead;       // this step [s]
  float g_inverseStep;     // 1 / the last step [1/s]; 0: there is no previous position
  uint g_gridSize;         // nodes per axis, 2..64
  uint g_gridVertexCount;  // elements of g_gridPositions and of all per-vertex buffers
};

// [strand][vertex] of the guides: world position [m]; w unused.
StructuredBuffer<float4> g_gridPositions : register(t0, space0);
// [strand][vertex]: forces of others, as g_gridForces; only read with g_addsForces.
StructuredBuffer<float4> g_otherForces : register(t1, space0);
// [strand][vertex]: xyz position a step before [m], w = mass [m]; 0 leaves the vertex out.
RWStructuredBuffer<float4> g_gridBefore : register(u0, space0);
// [strand][vertex]: mass density in the bind pose, in quanta per cell; only read with a pressure.
RWStructuredBuffer<float> g_gridRest : register(u1, space0);
// [node][channel]
RWStructuredBuffer<uint> g_gridNodes : register(u2, space0);
// [strand][vertex]: xyz acceleration [m/s2], w drag [1/s].
RWStructuredBuffer<float4> g_gridForces : register(u3, space0);

#endif
