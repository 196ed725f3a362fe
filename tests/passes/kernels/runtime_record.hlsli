// Resources of the runtime tests' draws that write buffers. Group "runtime_record":
//   space0 RuntimeDraw (runtime_draw.hlsli), space1 RuntimeRecord
#ifndef PELAGE_TESTS_RUNTIME_RECORD_HLSLI
#define PELAGE_TESTS_RUNTIME_RECORD_HLSLI

#include "runtime_draw.hlsli"

cbuffer RecordConstants : register(b0, space1) {
  uint g_targetWidth;  // pixels
  uint g_recordPad0;
  uint g_recordPad1;
  uint g_recordPad2;
};

// [instance]: added to the clip positions.
StructuredBuffer<float4> g_shifts : register(t0, space1);
// [pixel]: fragments.
RWStructuredBuffer<uint> g_hits : register(u0, space1);
// [pixel]: bits of a depth.
RWStructuredBuffer<uint> g_depths : register(u1, space1);

uint pixelIndex(float4 position) { return uint(position.y) * g_targetWidth + uint(position.x); }

#endif
