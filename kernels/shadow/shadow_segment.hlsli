// A strand's segment in the texels of a shadow map, cut into pieces between the centers of texels.
#ifndef PELAGE_SHADOW_SHADOW_SEGMENT_HLSLI
#define PELAGE_SHADOW_SHADOW_SEGMENT_HLSLI

#include "../base/dispatch.hlsli"
#include "layouts/strand_shadow.hlsli"
#define STRAND_POSITIONS g_shadowPositions
#define STRAND_VERTEX_COUNT g_shadowVertexCount
#define STRAND_FOLLOW_HAIRS g_shadowFollowHairRecords
#define STRAND_ROOTS g_shadowRoots
#define STRAND_GUIDE_COUNT g_shadowGuideCount
#define STRAND_EVALUATES_FOLLOWS true
#define STRAND_TIP_SEPARATION g_shadowTipSeparation
#include "../shading/drawn_strand.hlsli"
#include "../shading/shadow_faces.hlsli"

bool isShadowView(StrandShadowView map) {
  return map.width - 1u < kMaxShadowSize && map.height - 1u < kMaxShadowSize &&
         map.layerCount <= kMaxShadowLayers && map.layerRange > 0.0 &&
         (map.faceCount == 1u || map.faceCount == 6u);
}

// A point of a strand. All values except x and y are divided by w: on the map these are linear
// between two points, whatever the projection (Heckbert and Moreton, "Interpolation for polygon
// texture mapping and shading", 1991).
struct ShadowPoint {
  float2 texel;   // from the middle of the first one
  float inverse;  // 1 / w
  float depth;    // distance behind the near plane over w [m]
  float radius;   // [texel]
};

// A segment of a strand in the world.
struct StrandPart {
  bool known;  // its strand is one
  float3 from;
  float3 to;
  float fromRadius;  // [m]
  float toRadius;
};

struct ShadowSegment {
  bool inside;
  ShadowPoint from;
  ShadowPoint to;
};

float affine(float4 row, float3 p) {
  precise float r = row.x * p.x + row.y * p.y + row.z * p.z + row.w;
  return r;
}

float radiusAt(uint strand, uint vertex) {
  precise float along = float(vertex) / float(g_shadowVertexCount - 1u);
  precise float radius = g_shadowFiberRadius * (1.0 + (g_shadowTipRatio - 1.0) * along);
  if (g_shadowStrandCount - strand <= g_shadowFadingCount) radius = radius * g_shadowFade;
  if (g_shadowHasThickness != 0u) radius = radius * g_shadowThickness[strand];
  return radius;
}

StrandPart strandPart(uint strand, uint segment) {
  DrawnVertex a = drawnVertex(strand, segment);
  DrawnVertex b = drawnVertex(strand, segment + 1u);
  StrandPart part;
  part.known = a.known && b.known;
  part.from = a.position;
  part.to = b.position;
  part.fromRadius = radiusAt(strand, segment);
  part.toRadius = radiusAt(strand, segment + 1u);
  return part;
}

// A point on a face: xy / w the texel, z the distance behind the near plane [m].
float4 pointOnFace(StrandShadowView map, uint face, float3 position) {
  return onShadowFace(map, face,
                      float4(affine(map.mapX, position), affine(map.mapY, position),
                             affine(map.mapZ, position), affine(map.mapW, position)));
}

// A point on a face as the offset from the light in the map's axes [m].
float3 fromLight(StrandShadowView map, float4 at) {
  precise float x = (at.x - 0.5 * float(map.width) * at.w) * map.texelSize;
  precise float y = (at.y - 0.5 * float(map.height) * at.w) * map.texelSize;
  return float3(x, y, at.w);
}

// Returns how much wider the image of a thin fiber is than 2 radius / w. Its edges lie off by the
// radius along the unit normal m of the plane through the light and the fiber; on the plane w = 1,
// that is radius / w over the length of m's part in that plane. 1 for parallel light.
float widening(StrandShadowView map, float4 a, float4 b) {
  if (!isProjective(map)) return 1.0;
  float3 from = fromLight(map, a);
  precise float3 along = fromLight(map, b) - from;
  precise float3 m =
      float3(from.y * along.z - from.z * along.y, from.z * along.x - from.x * along.z,
             from.x * along.y - from.y * along.x);
  precise float flat = m.x * m.x + m.y * m.y;
  precise float squared = 1.0 + m.z * m.z / flat;
  // 16: a map that is as wide as this is none. NaN counts as 1.
  return squared > 1.0 ? squareRoot(min(squared, 16.0)) : 1.0;
}

ShadowPoint shadowPoint(StrandShadowView map, float4 at, float radius) {
  ShadowPoint r;
  precise float inverse = 1.0 / at.w;
  precise float x = at.x * inverse - 0.5;
  precise float y = at.y * inverse - 0.5;
  precise float depth = at.z * inverse;
  precise float wide = radius * inverse / map.texelSize;
  r.texel = float2(x, y);
  r.inverse = inverse;
  r.depth = depth;
  // 0 for negative values and for NaN, tested on the bits because a driver may assume that there is
  // no NaN. The bound keeps sums from overflowing.
  r.radius = asuint(wide) <= 0x7f800000u ? min(wide, map.maxRadius) : 0.0;
  return r;
}

ShadowPoint between(ShadowPoint a, ShadowPoint b, float share) {
  ShadowPoint r;
  precise float2 texel = a.texel + (b.texel - a.texel) * share;
  precise float inverse = a.inverse + (b.inverse - a.inverse) * share;
  precise float depth = a.depth + (b.depth - a.depth) * share;
  precise float radius = a.radius + (b.radius - a.radius) * share;
  r.texel = texel;
  r.inverse = inverse;
  r.depth = depth;
  r.radius = radius;
  return r;
}

// Returns the fractions of a line at which it enters (x) and leaves (y) the texels -1 .. end of an
// axis.
float2 clipAxis(float from, float to, float end, float2 range) {
  precise float offset = to - from;
  if (offset == 0.0) return from < -1.0 || from > end ? float2(1.0, 0.0) : range;
  precise float low = (-1.0 - from) / offset;
  precise float high = (end - from) / offset;
  return float2(max(range.x, min(low, high)), min(range.y, max(low, high)));
}

// Returns a segment on a face, cut to the face, the texels around it and what lies behind nearW.
// Segments that are not finite are left out.
ShadowSegment shadowSegment(StrandShadowView map, uint face, StrandPart part) {
  ShadowSegment r;
  r.inside = false;
  r.from.texel = float2(0.0, 0.0);
  r.from.inverse = 1.0;
  r.from.depth = 0.0;
  r.from.radius = 0.0;
  r.to = r.from;
  float4 a = pointOnFace(map, face, part.from);
  float4 b = pointOnFace(map, face, part.to);
  if (!(map.nearW > 0.0) || !(max(a.w, b.w) >= map.nearW)) return r;
  precise float fromRadius = part.fromRadius;
  precise float toRadius = part.toRadius;
  if (!(min(a.w, b.w) >= map.nearW)) {
    precise float share = (map.nearW - a.w) / (b.w - a.w);
    precise float4 cut = a + (b - a) * share;
    precise float radius = fromRadius + (toRadius - fromRadius) * share;
    cut.w = map.nearW;
    if (a.w < map.nearW) {
      a = cut;
      fromRadius = radius;
    } else {
      b = cut;
      toRadius = radius;
    }
  }
  float wider = widening(map, a, b);
  r.from = shadowPoint(map, a, fromRadius * wider);
  r.to = shadowPoint(map, b, toRadius * wider);
  if (!isUsable(float4(r.from.texel, r.from.inverse, r.from.depth)) ||
      !isUsable(float4(r.to.texel, r.to.inverse, r.to.depth)))
    return r;
  // A segment without coverage is not visible.
  if (!(max(r.from.radius, r.to.radius) > 0.0) || !(g_shadowOpacity > 0.0)) return r;

  float2 range = float2(0.0, 1.0);
  range = clipAxis(r.from.texel.x, r.to.texel.x, float(map.width), range);
  range = clipAxis(r.from.texel.y, r.to.texel.y, float(map.height), range);
  if (!(range.x < range.y)) return r;
  ShadowPoint from = r.from;
  if (range.x > 0.0) r.from = between(from, r.to, range.x);
  if (range.y < 1.0) r.to = between(from, r.to, range.y);
  r.inside = true;
  return r;
}

// The walk of a segment over squares between the centers of four texels. Square (x, y) has the
// texels x and x + 1 in the rows y and y + 1; squares start at -1, whose texels are partly outside.
struct ShadowWalk {
  int2 square;
  int2 last;
  int2 direction;
  uint pieces;  // left
  float begin;  // of the piece, share of the segment
  float end;
};

int2 squareOf(StrandShadowView map, float2 texel) {
  float2 bound = float2(float(map.width), float(map.height)) - 1.0;
  return int2(min(max(floor(texel), -1.0), bound));
}

void findPieceEnd(ShadowSegment segment, inout ShadowWalk walk) {
  if (walk.pieces <= 1u) {
    walk.end = 1.0;
    return;
  }
  // 2 is beyond the end: the walk on this axis has ended.
  precise float2 offset = segment.to.texel - segment.from.texel;
  precise float2 share = float2(2.0, 2.0);
  if (walk.square.x != walk.last.x)
    share.x = (float(walk.square.x + max(walk.direction.x, 0)) - segment.from.texel.x) / offset.x;
  if (walk.square.y != walk.last.y)
    share.y = (float(walk.square.y + max(walk.direction.y, 0)) - segment.from.texel.y) / offset.y;
  walk.end = min(max(min(share.x, share.y), walk.begin), 1.0);
}

ShadowWalk beginWalk(StrandShadowView map, ShadowSegment segment) {
  ShadowWalk walk;
  walk.square = squareOf(map, segment.from.texel);
  walk.last = squareOf(map, segment.to.texel);
  int2 squares = walk.last - walk.square;
  walk.direction = int2(squares.x < 0 ? -1 : 1, squares.y < 0 ? -1 : 1);
  walk.pieces = uint(abs(squares.x) + abs(squares.y)) + 1u;
  walk.begin = 0.0;
  walk.end = 1.0;
  findPieceEnd(segment, walk);
  return walk;
}

// Goes to the next piece. The squares are counted, not measured, so that the walk ends.
void advance(ShadowSegment segment, inout ShadowWalk walk) {
  precise float2 offset = segment.to.texel - segment.from.texel;
  bool alongX = walk.square.y == walk.last.y;
  if (walk.square.x != walk.last.x && walk.square.y != walk.last.y) {
    precise float x =
        (float(walk.square.x + max(walk.direction.x, 0)) - segment.from.texel.x) / offset.x;
    precise float y =
        (float(walk.square.y + max(walk.direction.y, 0)) - segment.from.texel.y) / offset.y;
    alongX = x <= y;
  }
  if (alongX) {
    walk.square.x += walk.direction.x;
  } else {
    walk.square.y += walk.direction.y;
  }
  walk.begin = walk.end;
  --walk.pieces;
  findPieceEnd(segment, walk);
}

// First word of the texel at corner 0..3 of a square, or kNoHair outside the map.
uint wordOfCorner(StrandShadowView map, int2 square, uint corner) {
  int2 texel = square + int2(int(corner & 1u), int(corner >> 1));
  if (min(texel.x, texel.y) < 0 || texel.x >= int(map.width) || texel.y >= int(map.height))
    return kNoHair;
  return map.firstWord + (uint(texel.y) * map.width + uint(texel.x)) * (1u + map.layerCount);
}

float depthOf(ShadowPoint p) {
  precise float depth = p.depth / p.inverse;
  return depth > 0.0 ? depth : 0.0;
}

#endif
