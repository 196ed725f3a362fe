// An engine's own kernel: the distance from root to tip of every strand, read from the positions
// that pelage simulates. One thread a strand.
StructuredBuffer<float4> g_hair : register(t0, space0);
RWStructuredBuffer<float> g_extent : register(u0, space0);

cbuffer MeasureConstants : register(b0, space0) {
  uint g_strands;
  uint g_vertices;
};

[numthreads(64, 1, 1)]
void strand_extent(uint3 id : SV_DispatchThreadID) {
  if (id.x >= g_strands) return;
  uint first = id.x * g_vertices;
  g_extent[id.x] = length(g_hair[first + g_vertices - 1].xyz - g_hair[first].xyz);
}
