// Inputs and results of pack_samples. Group "pack": space0 Packing.
#ifndef PELAGE_TESTS_OIT_PACKING_SAMPLES_HLSLI
#define PELAGE_TESTS_OIT_PACKING_SAMPLES_HLSLI

struct PackingSample {
  float4 color;    // linear rgb; w alpha
  float4 tangent;  // of any length; w depth
};

struct PackingResult {
  float4 color;    // of packColor(); w alpha of packShape()
  float4 tangent;  // of packShape(); w depth of depthKey()
  float4 light;    // of packLayer(); w its alpha
  uint shape;
  uint colorWord;
  uint layer;
  uint layerAgain;  // packLayer() of `light`
  // packTileFragment() and back, with 24 to 31 bits for the segment.
  uint tileKey;
  uint tileRoot;
  uint tileSegment;
  uint tileBits;
};

cbuffer PackingConstants : register(b0, space0) {
  uint g_packingCount;
  uint g_packingReversed;
  uint g_packingPad0;
  uint g_packingPad1;
};
StructuredBuffer<PackingSample> g_packingSamples : register(t0, space0);
RWStructuredBuffer<PackingResult> g_packingResults : register(u0, space0);

#endif
