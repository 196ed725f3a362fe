// Adds the optical depth of strands to the layers of a shadow map.
//
// Threads: one per segment of a strand, in rows of 2^20.
// Reads:   as splat_strand_depths, and what that wrote
// Writes:  the layers of g_shadowWords, which clear_strand_shadow has emptied; a layer's own part,
//          accumulate_strand_shadow adds them up
//
// The method is that of deep opacity maps (Yuksel and Keyser, "Deep opacity maps", Eurographics
// 2008): layers begin at the nearest hair of each texel. A fiber of radius r with visible length l
// covers 2 r l, and a texel gets opacity times covered area over the texel's area. The area is
// distributed with the bilinear weights of the four texels around each point of the fiber. Within a
// square between texel centers that is an integral of cubic functions along the piece, which
// Simpson's rule computes exactly; so a fiber much thinner than a texel contributes exactly its
// area.
//
// Sums are integers. The rounding error of a deposit goes to the next deposit of the segment. The
// tent of a texel's weights, along any line, contains at most one texel of length: a straight
// segment adds at most tauScale 2 maxRadius + 4 to a texel, wherever it is. The host sets tauScale
// so that the sum of all segments stays below 2^32, and maxRadius to the actual maximum.
//
// Invariant (tests/shadow): the sum over texels and layers is the covered area, to half a quantum
// per segment; any order of the strands, and any API, gives the same bits.
#include "shadow_segment.hlsli"

float2 weightsIn(int2 square, float2 texel) {
  precise float2 share = min(max(texel - float2(square), 0.0), 1.0);
  return share;
}

float cornerWeight(float2 share, uint corner) {
  precise float2 other = 1.0 - share;
  precise float weight =
      ((corner & 1u) != 0u ? share.x : other.x) * (corner > 1u ? share.y : other.y);
  return weight;
}

void splatOpacity(StrandShadowView map, ShadowSegment segment) {
  precise float2 offset = segment.to.texel - segment.from.texel;
  precise float squared = offset.x * offset.x + offset.y * offset.y;
  // Simpson's rule has a sixth of the ends and four sixths of the middle.
  precise float amount = 2.0 * squareRoot(squared) * min(g_shadowOpacity, 1.0) * map.tauScale / 6.0;
  float layers = float(map.layerCount);
  precise float owed = 0.5;

  ShadowWalk walk = beginWalk(map, segment);
  ShadowPoint before = segment.from;
  while (walk.pieces > 0u) {
    precise float halfway = (walk.begin + walk.end) * 0.5;
    ShadowPoint middle = between(segment.from, segment.to, halfway);
    ShadowPoint after = between(segment.from, segment.to, walk.end);
    precise float scale = amount * (walk.end - walk.begin);
    precise float3 covered = float3(before.radius, 4.0 * middle.radius, after.radius) * scale;
    float2 atBefore = weightsIn(walk.square, before.texel);
    float2 atMiddle = weightsIn(walk.square, middle.texel);
    float2 atAfter = weightsIn(walk.square, after.texel);
    float depth = depthOf(middle);
    for (uint corner = 0; corner < 4u; ++corner) {
      precise float part = covered.x * cornerWeight(atBefore, corner) +
                           covered.y * cornerWeight(atMiddle, corner) +
                           covered.z * cornerWeight(atAfter, corner);
      owed = owed + part;
      precise float quanta = floor(owed);
      owed = owed - quanta;
      uint word = wordOfCorner(map, walk.square, corner);
      if (word == kNoHair || !(quanta >= 1.0)) continue;
      uint nearest = g_shadowWords[word];
      precise float behind = 0.0;
      if (nearest != kNoHair) behind = max(depth - asfloat(nearest), 0.0);
      precise float layerPosition = squareRoot(behind / map.layerRange) * layers;
      uint layer = uint(min(layerPosition, layers - 1.0));
      InterlockedAdd(g_shadowWords[word + 1u + layer], uint(min(quanta, 4294967040.0)));
    }
    before = after;
    advance(segment, walk);
  }
}

[numthreads(64, 1, 1)]
void splat_strand_opacity(uint3 thread : SV_DispatchThreadID) {
  uint segments = max(g_shadowVertexCount, 1u) - 1u;
  uint strand = indexOfThread(thread) / max(segments, 1u);
  if (segments == 0u || strand >= g_shadowStrandCount) return;
  StrandShadowView map = g_shadowViews[g_shadowView];
  if (!isShadowView(map) || map.layerCount == 0u) return;
  StrandPart part = strandPart(strand, indexOfThread(thread) % segments);
  if (!part.known) return;
  for (uint face = 0u; face < map.faceCount; ++face) {
    ShadowSegment segment = shadowSegment(map, face, part);
    if (segment.inside) splatOpacity(shadowFace(map, face), segment);
  }
}
