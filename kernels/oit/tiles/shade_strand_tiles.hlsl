// Lights the visible fragments of strands.
//
// Threads: any number; each takes every g_tileStride-th fragment.
// Reads:   g_tileRecords, g_tileSums, g_tileShadowWords, StrandViewConstants,
//          StrandTilesCompositeConstants
// Writes:  g_tileVisible
#include "../layouts/strand_tiles_composite.hlsli"
#define SHADOW_WORDS g_tileShadowWords
#include "../../shading/light_strand.hlsli"
#include "../composite_fragment.hlsli"
#define SEGMENT_RECORDS g_tileRecords
#include "strand_tile_fragment.hlsli"
#include "strand_tile_segment.hlsli"

[numthreads(128, 1, 1)]
void shade_strand_tiles(uint thread : SV_DispatchThreadID) {
  uint count = g_tileSums[g_tileSumsEnd].x;
  bool reversed = g_reversedDepth != 0u;
  for (uint i = thread; i < count; i += g_tileStride) {
    uint4 entry = g_tileVisible[i];
    // Room that nothing took.
    if (entry.w == 0u) continue;
    uint record = entry.x >> 1;
    uint4 shape0 = g_tileRecords[kRecordWords * record + 1u];
    uint4 shape1 = g_tileRecords[kRecordWords * record + kRecordWords + 1u];
    float2 at = float2(float(entry.y % g_tileWidth), float(entry.y / g_tileWidth)) + 0.5;
    StrandSegment segment = segmentAt(record, shape0, shape1, reversed);
    SegmentPoint found = pointAt(segment, entry.x & 1u, at, reversed);
    FragmentWords words = wordsAt(record, found);
    float2 uv = float2(0.0, 0.0);
#if STRAND_UV
    uv = unpackUv(g_tileRecords[kRecordWords * record + 2u].w);
#endif
    float3 light = lightStrand(tileShading(shape0.w & kRecordMaterial),
                               surfaceOfFragment(at, found.key, words.shape, words.color, uv));
    float arriving = transmittanceOfDepth(entry.z) * (1.0 - transmittanceOfDepth(entry.w));
    g_tileVisible[i] = uint4(asuint(light * arriving), entry.w);
  }
}
