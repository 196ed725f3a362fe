// Resources of sample_force_field. Group "forceField", all in space0.
#ifndef PELAGE_SIMULATION_LAYOUTS_FORCE_FIELD_HLSLI
#define PELAGE_SIMULATION_LAYOUTS_FORCE_FIELD_HLSLI

cbuffer ForceFieldConstants : register(b0, space0) {
  uint g_fieldVertexCount;  // elements of g_fieldPositions and g_fieldForces; first: decision 0008
  uint g_fieldAddsForces;   // 0 or 1: g_fieldOthers are added
  uint g_fieldFirst;        // element of node 0 in g_fieldValues
  uint g_fieldKnown;        // 0: there are no positions yet, and the field gives nothing
  float4 g_fieldOrigin;     // xyz of node 0 in world space [m]; w = cell size [m]
  uint4 g_fieldNodes;       // xyz along the axes, each >= 2; w unused
};

// [strand][vertex] of the guides: world position [m]; w unused.
StructuredBuffer<float4> g_fieldPositions : register(t0, space0);
// [z][y][x]: xyz acceleration [m/s2], w drag [1/s].
StructuredBuffer<float4> g_fieldValues : register(t1, space0);
// [strand][vertex]: forces of setForces(); only read with g_fieldAddsForces.
StructuredBuffer<float4> g_fieldOthers : register(t2, space0);
// [strand][vertex]: the sum.
RWStructuredBuffer<float4> g_fieldForces : register(u0, space0);

#endif
