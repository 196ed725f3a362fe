// Unit vectors in 32 bits: the octahedron |x| + |y| + |z| = 1, its lower half folded over the upper
// one (Meyer et al., "On floating-point normal vectors", Computer Graphics Forum 29(4), 2010).
// 16 bits a component, x in the low ones, 32767 for 0 and 65534 for 1: within 0.003 degrees.
#ifndef PELAGE_BASE_OCTAHEDRAL_HLSLI
#define PELAGE_BASE_OCTAHEDRAL_HLSLI

#include "quaternion.hlsli"

static const float kOctahedralScale = 32767.0;

// \param v  of any length; one of no direction gives +z
// \return both coordinates in -1..1
float2 octahedralOf(float3 v) {
  float3 d = directionOr(v, float3(0.0, 0.0, 1.0));
  precise float size = abs(d.x) + abs(d.y) + abs(d.z);
  precise float2 flat = d.xy / size;
  if (d.z < 0.0) {
    precise float2 folded = float2(1.0, 1.0) - abs(flat.yx);
    flat = float2(flat.x < 0.0 ? -folded.x : folded.x, flat.y < 0.0 ? -folded.y : folded.y);
  }
  return flat;
}

float3 directionOfOctahedral(float2 given) {
  precise float2 flat = given;
  precise float z = 1.0 - abs(flat.x) - abs(flat.y);
  if (z < 0.0) {
    precise float2 folded = float2(1.0, 1.0) - abs(flat.yx);
    flat = float2(flat.x < 0.0 ? -folded.x : folded.x, flat.y < 0.0 ? -folded.y : folded.y);
  }
  return directionOr(float3(flat, z), float3(0.0, 0.0, 1.0));
}

uint packDirection(float3 v) {
  precise float2 scaled = (octahedralOf(v) + 1.0) * kOctahedralScale + 0.5;
  uint2 bits = uint2(min(max(scaled, 0.0), 65534.0));
  return bits.x | (bits.y << 16);
}

float3 unpackDirection(uint packed) {
  precise float2 flat =
      float2(float(packed & 0xffffu), float(packed >> 16)) / kOctahedralScale - 1.0;
  return directionOfOctahedral(flat);
}

#endif
