// Four values of 0..1 in 8 bits each, cut.
#ifndef BASELINE_CLASSIC_LIST_PACKING_HLSLI
#define BASELINE_CLASSIC_LIST_PACKING_HLSLI

uint packBytes(float4 value) {
  uint4 cut = uint4(saturate(value) * 255.0);
  return cut.x | (cut.y << 8) | (cut.z << 16) | (cut.w << 24);
}

float4 unpackBytes(uint packed) {
  return float4(float(packed & 255u), float((packed >> 8) & 255u), float((packed >> 16) & 255u),
                float(packed >> 24)) /
         255.0;
}

#endif
