// Where the fragments go that errors are held against. Group "sampleFragments", space2 behind
// RenderPosTan and Render.
#ifndef BASELINE_SAMPLE_FRAGMENTS_LAYOUT_HLSLI
#define BASELINE_SAMPLE_FRAGMENTS_LAYOUT_HLSLI

struct SampledFragment {
  uint x;  // [pixels], in the view
  uint y;
  float depth;
  float alpha;
  float4 color;  // lit, linear rgb
};

cbuffer SampleFragmentsConstants : register(b0, space2) {
  uint g_sampleCapacity;
  uint g_sampleRowStep;  // rows 0, step, 2 step... are sampled
  uint g_samplePad0;
  uint g_samplePad1;
};

RWStructuredBuffer<SampledFragment> g_sampled : register(u0, space2);
// Fragments of all rows; those of sampled rows, room or not.
RWStructuredBuffer<uint> g_sampledCounts : register(u1, space2);

#endif
