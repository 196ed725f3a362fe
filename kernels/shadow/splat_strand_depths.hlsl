// Finds the distance of the nearest hair from the light, for each texel of a shadow map.
//
// Threads: one per segment of a strand, in rows of 2^20.
// Reads:   g_shadowViews, g_shadowPositions; with g_shadowHasThickness g_shadowThickness; for
//          strands from g_shadowGuideCount on g_shadowFollowHairRecords and g_shadowRoots
// Writes:  the first word of the texels of g_shadowWords, which clear_strand_shadow has emptied
//
// A piece of a strand counts for all texels to which splat_strand_opacity adds a part of it, so
// that everything that pass adds to a texel lies behind the texel's depth. The bits of floats >= 0
// order as the floats.
//
// Invariant (tests/shadow): a texel has the minimum distance of the strands that pass through the
// four squares of a texel's size around its center; any order of the strands gives the same bits.
#include "shadow_segment.hlsli"

void splatDepths(StrandShadowView map, ShadowSegment segment) {
  ShadowWalk walk = beginWalk(map, segment);
  float before = depthOf(segment.from);
  while (walk.pieces > 0u) {
    float after = depthOf(between(segment.from, segment.to, walk.end));
    uint nearest = asuint(min(before, after));
    for (uint corner = 0; corner < 4u; ++corner) {
      uint word = wordOfCorner(map, walk.square, corner);
      // Most hair lies behind other hair, and reading is cheaper.
      if (word != kNoHair && nearest < g_shadowWords[word])
        InterlockedMin(g_shadowWords[word], nearest);
    }
    before = after;
    advance(segment, walk);
  }
}

[numthreads(64, 1, 1)]
void splat_strand_depths(uint3 thread : SV_DispatchThreadID) {
  uint segments = max(g_shadowVertexCount, 1u) - 1u;
  uint strand = indexOfThread(thread) / max(segments, 1u);
  if (segments == 0u || strand >= g_shadowStrandCount) return;
  StrandShadowView map = g_shadowViews[g_shadowView];
  if (!isShadowView(map)) return;
  StrandPart part = strandPart(strand, indexOfThread(thread) % segments);
  if (!part.known) return;
  for (uint face = 0u; face < map.faceCount; ++face) {
    ShadowSegment segment = shadowSegment(map, face, part);
    if (segment.inside) splatDepths(shadowFace(map, face), segment);
  }
}
