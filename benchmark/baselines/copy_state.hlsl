// The floor that memory sets: moves g_sets float4 a vertex from one buffer to another and does
// nothing else.
// Threads: one a vertex. Reads g_copyFrom, writes g_copyTo.
cbuffer CopyConstants : register(b0, space0) {
  uint g_elementCount;  // of a set
  uint g_sets;
  uint g_copyPad0;
  uint g_copyPad1;
};

RWStructuredBuffer<float4> g_copyTo : register(u0, space0);  // [set][element]
StructuredBuffer<float4> g_copyFrom : register(t0, space0);  // [set][element]

[numthreads(64, 1, 1)]
void copy_state(uint3 thread : SV_DispatchThreadID) {
  if (thread.x >= g_elementCount) return;
  for (uint i = 0; i < g_sets; ++i) {
    uint at = i * g_elementCount + thread.x;
    g_copyTo[at] = g_copyFrom[at];
  }
}
