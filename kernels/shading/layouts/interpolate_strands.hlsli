// Resources of interpolate_strands. Group "interpolateStrands", all in space0.
#ifndef PELAGE_SHADING_LAYOUTS_INTERPOLATE_STRANDS_HLSLI
#define PELAGE_SHADING_LAYOUTS_INTERPOLATE_STRANDS_HLSLI

cbuffer InterpolateStrandsConstants : register(b0, space0) {
  uint g_interpolatedCount;     // elements
  uint g_interpolatedVertices;  // of a strand, >= 2
  float g_interpolatedShare;    // 0: the state before, 1: the state now
  uint g_interpolatedPad0;
};

// [strand][vertex]: xyz world position [m] in the two states; w inverse mass.
StructuredBuffer<float4> g_positionsBefore : register(t0, space0);
StructuredBuffer<float4> g_positionsNow : register(t1, space0);
// [strand][vertex]: what is drawn; the tangents are unit vectors, w = 0.
RWStructuredBuffer<float4> g_drawnPositions : register(u0, space0);
RWStructuredBuffer<float4> g_drawnTangents : register(u1, space0);

#endif
