// Linear colors in two words: four unorms of 16 bits, red in the lowest.
#ifndef PELAGE_SHADING_COLOR_PACKING_HLSLI
#define PELAGE_SHADING_COLOR_PACKING_HLSLI

static const float kUnormRange = 65535.0;

float4 unpackColor(uint2 packed) {
  return float4(float(packed.x & 0xffffu), float(packed.x >> 16), float(packed.y & 0xffffu),
                float(packed.y >> 16)) *
         (1.0 / kUnormRange);
}

#endif
