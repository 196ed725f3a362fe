// The UV of a root in a word: two unorms of 16 bits, u in the low ones.
#ifndef PELAGE_SHADING_UV_PACKING_HLSLI
#define PELAGE_SHADING_UV_PACKING_HLSLI

#include "color_packing.hlsli"

uint packUv(float2 uv) { return packUnorm(uv.x) | (packUnorm(uv.y) << 16); }

float2 unpackUv(uint packed) {
  return float2(float(packed & 0xffffu), float(packed >> 16)) * (1.0 / kUnormRange);
}

#endif
