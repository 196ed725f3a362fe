// Adds the optical depth of strands to the layers of a shadow map.
//
// Threads: one per segment of a strand, in rows of 2^20.
// Reads:   as splat_strand_depths, and what that wrote
// Writes:  the layers of g_shadowWords, which splat_strand_depths has emptied; a layer's own part,
//          accumulate_strand_shadow adds them up
//
// The method is that of deep opacity maps (Yuksel and Keyser, "Deep opacity maps", Eurographics
// 2008): layers begin at the nearest hair of each texel. A fiber of radius r with visible length l
// covers 2 r l, and a texel gets opacity times covered area over the texel's area. The area of the
// piece in a row goes to the two texels of the row that are next to the piece's middle, with linear
// weights: across a fiber that is a tent of a texel's width, along it nothing needs to be smoothed.
//
// Sums are integers. The rounding error of a deposit goes to the next deposit of the segment. A
// texel gets one deposit of a straight segment, of at most sqrt(2) texels of length: at most
// tauScale 2 sqrt(2) maxRadius + 1. The host sets tauScale so that the sum of all segments stays
// below 2^32, and maxRadius to the actual maximum.
//
// Invariant (tests/shadow): the sum over texels and layers is the covered area, to half a quantum
// per segment; any order of the strands, and any API, gives the same bits.
#include "shadow_segment.hlsli"

uint nearestAt(StrandShadowView map, uint texel) {
  return texel == kNoHair ? kNoHair : g_shadowWords[map.firstWord + texel];
}

void addQuanta(StrandShadowView map, uint texel, uint nearest, float depth, float layersPerRange,
               float quanta) {
  if (nearest == kNoHair || !(quanta >= 1.0)) return;
  precise float behind = max(depth - asfloat(nearest), 0.0) * layersPerRange;
  float layer = min(floor(squareRoot(behind)), float(map.layerCount) - 1.0);
  InterlockedAdd(g_shadowWords[firstLayerOf(map, texel) + uint(layer)],
                 uint(min(quanta, 4294967040.0)));
}

void splatOpacity(StrandShadowView map, ShadowSegment segment) {
  precise float2 offset = segment.to.texel - segment.from.texel;
  precise float squared = offset.x * offset.x + offset.y * offset.y;
  precise float amount = 2.0 * squareRoot(squared) * min(g_shadowOpacity, 1.0) * map.tauScale;
  float layers = float(map.layerCount);
  precise float layersPerRange = layers * layers / map.layerRange;
  precise float owed = 0.5;

  ShadowWalk walk = beginWalk(map, segment);
  while (walk.pieces > 0u) {
    ShadowPoint middle = middleOf(segment, walk);
    float across = acrossRow(walk, middle);
    int low = int(floor(across));
    uint2 texels = uint2(texelInRow(map, walk, low), texelInRow(map, walk, low + 1));
    // Both before the first addition, which a load of the same buffer would wait for.
    uint2 nearest = uint2(nearestAt(map, texels.x), nearestAt(map, texels.y));
    float depth = depthOf(middle);
    precise float high = across - float(low);
    precise float covered = amount * (walk.end - walk.begin) * middle.radius;
    precise float2 owing = float2(owed + covered * (1.0 - high), 0.0);
    float2 quanta = floor(owing);
    owing.y = owing.x - quanta.x + covered * high;
    quanta.y = floor(owing.y);
    owed = owing.y - quanta.y;
    addQuanta(map, texels.x, nearest.x, depth, layersPerRange, quanta.x);
    addQuanta(map, texels.y, nearest.y, depth, layersPerRange, quanta.y);
    advance(walk);
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
