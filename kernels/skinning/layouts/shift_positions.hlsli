// Resources of shift_positions. Group "shiftPositions", all in space0.
#ifndef PELAGE_SKINNING_LAYOUTS_SHIFT_POSITIONS_HLSLI
#define PELAGE_SKINNING_LAYOUTS_SHIFT_POSITIONS_HLSLI

cbuffer ShiftPositionsConstants : register(b0, space0) {
  uint g_shiftedFirst;  // element; first: decision 0008
  uint g_shiftedCount;
  uint g_shiftedPad0;
  uint g_shiftedPad1;
  float4 g_shift;       // xyz what to add [m]; w unused
};

// xyz world position [m]; w is kept.
RWStructuredBuffer<float4> g_shiftedPositions : register(u0, space0);

#endif
