// Loads an Sdf from a buffer of uint4, where each has kSdfElements. The including file defines
// SDF_ELEMENTS, the buffer.
#ifndef PELAGE_SDF_LOAD_SDF_HLSLI
#define PELAGE_SDF_LOAD_SDF_HLSLI

#include "layouts/sdf.hlsli"

Sdf loadSdf(uint index) {
  uint element = kSdfElements * index;
  uint4 counts = SDF_ELEMENTS[element + 2u];
  float4 ranges = asfloat(SDF_ELEMENTS[element + 3u]);
  uint4 motion = SDF_ELEMENTS[element + 4u];
  Sdf sdf;
  sdf.origin = asfloat(SDF_ELEMENTS[element]);
  sdf.nodes = SDF_ELEMENTS[element + 1u];
  sdf.triangleCount = counts.x;
  sdf.triangleBits = counts.y;
  sdf.surface = counts.z;
  sdf.surfaceStride = counts.w;
  sdf.band = ranges.x;
  sdf.farRange = ranges.y;
  sdf.margin = ranges.z;
  sdf.friction = ranges.w;
  sdf.motionScale = asfloat(motion.x);
  sdf.pad0 = 0u;
  sdf.pad1 = 0u;
  sdf.pad2 = 0u;
  return sdf;
}

#endif
