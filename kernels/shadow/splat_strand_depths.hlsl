// Finds the distance of the nearest hair from the light, for each texel of a shadow map.
//
// Threads: one per segment of a strand, in rows of 2^20.
// Reads:   g_shadowViews, g_shadowPositions; with g_shadowHasThickness g_shadowThickness; for
//          strands from g_shadowGuideCount on g_shadowFollowHairRecords and g_shadowRoots
// Writes:  the depths of g_shadowWords, which clear_strand_shadow has emptied; zeros to the layers
//          of the texels that get one
//
// A piece of a strand counts for the two texels to which splat_strand_opacity adds a part of it, so
// that everything that pass adds to a texel lies behind the texel's depth. The bits of floats >= 0
// order as the floats.
//
// Invariant (tests/shadow): a texel has the minimum distance of the pieces that count for it; any
// order of the strands gives the same bits.
#include "shadow_segment.hlsli"

void splatDepth(StrandShadowView map, uint texel, uint nearest) {
  uint word = map.firstWord + texel;
  // Most hair lies behind other hair, and reading is cheaper.
  if (nearest >= g_shadowWords[word]) return;
  uint before = 0u;
  InterlockedMin(g_shadowWords[word], nearest, before);
  if (before != kNoHair) return;
  for (uint layer = 0u; layer < map.layerCount; ++layer)
    g_shadowWords[firstLayerOf(map, texel) + layer] = 0u;
}

void splatDepths(StrandShadowView map, ShadowSegment segment) {
  ShadowWalk walk = beginWalk(map, segment);
  float before = depthOf(segment.from);
  while (walk.pieces > 0u) {
    float after = depthOf(between(segment.from, segment.to, walk.end));
    uint nearest = asuint(min(before, after));
    int low = int(floor(acrossRow(walk, middleOf(segment, walk))));
    for (int side = 0; side < 2; ++side) {
      uint texel = texelInRow(map, walk, low + side);
      if (texel != kNoHair) splatDepth(map, texel, nearest);
    }
    before = after;
    advance(walk);
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
