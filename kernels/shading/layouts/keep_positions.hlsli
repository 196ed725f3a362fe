// Resources of keep_positions. Group "keepPositions", all in space0.
#ifndef PELAGE_SHADING_LAYOUTS_KEEP_POSITIONS_HLSLI
#define PELAGE_SHADING_LAYOUTS_KEEP_POSITIONS_HLSLI

cbuffer KeepPositionsConstants : register(b0, space0) {
  uint g_keptCount;      // elements
  uint g_keptMovedFrom;  // elements from here on are moved by g_keptMove
  uint g_keptPad0;
  uint g_keptPad1;
  float4 g_keptMove;     // xyz [m]; w unused
};

// [strand][vertex]: xyz world position [m]; w inverse mass.
StructuredBuffer<float4> g_positionsToKeep : register(t0, space0);
RWStructuredBuffer<float4> g_keptPositions : register(u0, space0);

#endif
