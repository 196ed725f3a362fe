// Resources of the runtime tests' compute kernels. Group "runtime_compute":
//   space0 RuntimeCompute
#ifndef PELAGE_TESTS_RUNTIME_COMPUTE_HLSLI
#define PELAGE_TESTS_RUNTIME_COMPUTE_HLSLI

cbuffer AccumulateConstants : register(b0, space0) {
  uint g_count;  // elements
  uint g_factor;
  uint g_bias;
  uint g_computePad;
};

// [g_count]
StructuredBuffer<uint> g_source : register(t0, space0);
// [g_count]
RWStructuredBuffer<uint> g_target : register(u0, space0);
// Three thread group counts of an indirect dispatch, or [g_count].
RWStructuredBuffer<uint> g_arguments : register(u1, space0);

#endif
