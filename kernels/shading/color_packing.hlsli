// Linear colors in two words: four unorms of 16 bits, red in the lowest.
#ifndef PELAGE_SHADING_COLOR_PACKING_HLSLI
#define PELAGE_SHADING_COLOR_PACKING_HLSLI

static const float kUnormRange = 65535.0;

uint packUnorm(float value) {
  // NaN gives 0.
  return value > 0.0 ? uint(min(value, 1.0) * kUnormRange + 0.5) : 0u;
}

uint2 packUnorms(float4 color) {
  return uint2(packUnorm(color.r) | (packUnorm(color.g) << 16),
               packUnorm(color.b) | (packUnorm(color.a) << 16));
}

float4 unpackColor(uint2 packed) {
  return float4(float(packed.x & 0xffffu), float(packed.x >> 16), float(packed.y & 0xffffu),
                float(packed.y >> 16)) *
         (1.0 / kUnormRange);
}

#endif
