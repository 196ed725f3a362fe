// A strand's segment in the texels of a shadow map, cut into pieces at the edges of texels.
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

// Returns the fractions of a line at which it enters (x) and leaves (y) the texels of an axis, with
// a row around them. Pieces with a part in a texel are whole.
float2 clipAxis(float from, float to, uint count, float2 range) {
  precise float offset = to - from;
  float end = float(count) + 0.5;
  if (offset == 0.0) return from < -1.5 || from > end ? float2(1.0, 0.0) : range;
  precise float low = (-1.5 - from) / offset;
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
  range = clipAxis(r.from.texel.x, r.to.texel.x, map.width, range);
  range = clipAxis(r.from.texel.y, r.to.texel.y, map.height, range);
  if (!(range.x < range.y)) return r;
  ShadowPoint from = r.from;
  if (range.x > 0.0) r.from = between(from, r.to, range.x);
  if (range.y < 1.0) r.to = between(from, r.to, range.y);
  r.inside = true;
  return r;
}

// The walk of a segment over the rows of texels across the axis on which it is longer: a piece a
// row. Row i goes from i - 0.5 to i + 0.5.
struct ShadowWalk {
  bool alongX;  // rows are columns of the map
  int row;
  int direction;
  uint pieces;  // left
  float from;   // where the segment begins, along the axis [texel]
  float perTexel;
  float begin;  // of the piece, share of the segment
  float end;
};

int rowOf(float texel, uint count) { return int(min(max(floor(texel + 0.5), -1.0), float(count))); }

void findPieceEnd(inout ShadowWalk walk) {
  precise float border = float(walk.row) + 0.5 * float(walk.direction);
  precise float share = (border - walk.from) * walk.perTexel;
  walk.end = walk.pieces <= 1u ? 1.0 : min(max(share, walk.begin), 1.0);
}

ShadowWalk beginWalk(StrandShadowView map, ShadowSegment segment) {
  ShadowWalk walk;
  precise float2 offset = segment.to.texel - segment.from.texel;
  walk.alongX = abs(offset.x) > abs(offset.y);
  uint count = walk.alongX ? map.width : map.height;
  walk.from = walk.alongX ? segment.from.texel.x : segment.from.texel.y;
  walk.row = rowOf(walk.from, count);
  int rows = rowOf(walk.alongX ? segment.to.texel.x : segment.to.texel.y, count) - walk.row;
  walk.direction = rows < 0 ? -1 : 1;
  walk.pieces = uint(abs(rows)) + 1u;
  // Not read where the segment stays in a row.
  precise float perTexel = 1.0 / (walk.alongX ? offset.x : offset.y);
  walk.perTexel = perTexel;
  walk.begin = 0.0;
  walk.end = 1.0;
  findPieceEnd(walk);
  return walk;
}

// Goes to the next piece. The rows are counted, not measured, so that the walk ends.
void advance(inout ShadowWalk walk) {
  walk.row += walk.direction;
  walk.begin = walk.end;
  --walk.pieces;
  findPieceEnd(walk);
}

ShadowPoint middleOf(ShadowSegment segment, ShadowWalk walk) {
  precise float halfway = (walk.begin + walk.end) * 0.5;
  return between(segment.from, segment.to, halfway);
}

float acrossRow(ShadowWalk walk, ShadowPoint p) { return walk.alongX ? p.texel.y : p.texel.x; }

// Returns the texel in the walk's row at a distance along the row; kNoHair outside the map.
uint texelInRow(StrandShadowView map, ShadowWalk walk, int across) {
  int x = walk.alongX ? walk.row : across;
  int y = walk.alongX ? across : walk.row;
  if (min(x, y) < 0 || x >= int(map.width) || y >= int(map.height)) return kNoHair;
  return uint(y) * map.width + uint(x);
}

float depthOf(ShadowPoint p) {
  precise float depth = p.depth / p.inverse;
  return depth > 0.0 ? depth : 0.0;
}

#endif
