// Segments of strands, and their fragments in a pixel. The including file defines SEGMENT_RECORDS, the
// buffer of vertices as shading/strand_record.hlsli has them.
//
// A point of a triangle at a pixel p is a sum of its corners with weights e_i, the determinants of
// the two other corners as seen from p (Olano and Greer, "Triangle scan conversion using 2D
// homogeneous coordinates", 1997, section 4); the point is in the triangle if they have the same
// sign. This needs no division of corners by w, so segments are never cut at a plane: a fragment
// exists if its depth is in range. Exchanging two corners only changes the sign of a determinant,
// and equality belongs to one of two triangles: a center on an edge between two triangles belongs
// to one of them. Coverage is computed with corners on the grid of 1/256 of a pixel, as rasterizers
// do; the attributes, with the corners themselves.
#ifndef PELAGE_OIT_TILES_STRAND_TILE_SEGMENT_HLSLI
#define PELAGE_OIT_TILES_STRAND_TILE_SEGMENT_HLSLI

#include "../../shading/strand_common.hlsli"
#include "../../shading/strand_record.hlsli"
#include "../fragment_packing.hlsli"

struct StrandSegment {
  float4 low;       // corners 0 and 1: x and y, times w, on the grid
  float4 high;      // corners 2 and 3
  float4 exactLow;  // as they are
  float4 exactHigh;
  float2 w;  // of both ends, as are the next ones
  float2 z;
  float2 share;
  float2 halfWidth;  // [pixels]
  float2 extent;     // of the ribbon [pixels]
  uint2 keys;        // minimum and maximum depth key; of a segment that a plane cuts not known
};

// Returns whether a vertex and the next one are the ends of a segment that may have fragments.
// Fibers without width have no coverage.
bool isSegment(uint4 first, uint4 second) {
  return (first.w & kRecordStartsSegment) != 0u && (second.w & kRecordDrawn) != 0u &&
         max(asfloat(first.z), asfloat(second.z)) > 0.0;
}

float extentOf(uint4 shape) { return (shape.w & kRecordWide) != 0u ? asfloat(shape.z) + 0.5 : 0.0; }

// \param record of the first vertex. \param shape0, shape1 second words of both vertices.
StrandSegment segmentAt(uint record, uint4 shape0, uint4 shape1, bool reversed) {
  uint4 corners0 = SEGMENT_RECORDS[kRecordWords * record];
  uint4 corners1 = SEGMENT_RECORDS[kRecordWords * record + kRecordWords];
  SegmentEnd a = segmentEnd(corners0, shape0);
  SegmentEnd b = segmentEnd(corners1, shape1);
  StrandSegment segment;
  segment.low = float4(a.low, a.high);
  segment.high = float4(b.low, b.high);
  segment.exactLow = asfloat(corners0);
  segment.exactHigh = asfloat(corners1);
  segment.w = float2(a.w, b.w);
  segment.z = float2(a.z, b.z);
  segment.share = float2(a.share, b.share);
  segment.halfWidth = float2(asfloat(shape0.z), asfloat(shape1.z));
  segment.extent = float2(extentOf(shape0), extentOf(shape1));
  segment.keys = uint2(0u, 0xffffffffu);
  if (isInDepth(shape0) && isInDepth(shape1)) {
    uint first = depthKey(a.z, reversed);
    uint second = depthKey(b.z, reversed);
    segment.keys = uint2(min(first, second), max(first, second));
  }
  return segment;
}

// Twice the area of the triangle of a, b and the origin.
float areaOf(float2 a, float2 b) {
  precise float left = a.x * b.y;
  precise float right = a.y * b.x;
  precise float area = left - right;
  return area;
}

// A segment as seen from a pixel: corners and the areas of its edges.
struct SegmentView {
  float4 low;   // corners 0 and 1
  float4 high;  // corners 2 and 3
  float area01, area12, area20, area13, area32;
};

SegmentView viewSegment(float4 low, float4 high, float2 w, float2 at) {
  SegmentView seen;
  seen.low = low - w.x * at.xyxy;
  seen.high = high - w.y * at.xyxy;
  seen.area01 = areaOf(seen.low.xy, seen.low.zw);
  seen.area12 = areaOf(seen.low.zw, seen.high.xy);
  seen.area20 = areaOf(seen.high.xy, seen.low.xy);
  seen.area13 = areaOf(seen.low.zw, seen.high.zw);
  seen.area32 = areaOf(seen.high.zw, seen.high.xy);
  return seen;
}

// Areas that weight the corners 0 to 3 in one of the two triangles.
float4 cornerAreas(SegmentView seen, uint side) {
  float4 areas = float4(seen.area12, seen.area20, seen.area01, 0.0);
  if (side != 0u) areas = float4(0.0, seen.area32, seen.area13, -seen.area12);
  return areas;
}

// Returns true if the origin is on the inner side of the edge from a to b, or on the edge if it is
// a top or a left one; rows go down.
bool isInside(float area, float2 a, float2 b, float turn) {
  float signedArea = area * turn;
  bool inside = signedArea > 0.0;
  if (area == 0.0) {
    float2 edge = (b - a) * turn;
    inside = edge.y < 0.0 || (edge.y == 0.0 && edge.x > 0.0);
  }
  return inside;
}

// \param w of both ends.
bool isCovered(SegmentView seen, uint side, float2 w) {
  float whole = dot(cornerAreas(seen, side), w.xxyy);
  float turn = whole > 0.0 ? 1.0 : -1.0;
  float2 one = seen.low.zw;
  float2 two = seen.high.xy;
  bool covered = false;
  if (side == 0u) {
    covered = isInside(seen.area12, one, two, turn) &&
              isInside(seen.area20, two, seen.low.xy, turn) &&
              isInside(seen.area01, seen.low.xy, one, turn);
  } else {
    covered = isInside(-seen.area12, two, one, turn) &&
              isInside(seen.area13, one, seen.high.zw, turn) &&
              isInside(seen.area32, seen.high.zw, two, turn);
  }
  // Rejects triangles without area and those that are not finite.
  return covered && abs(whole) > 0.0 && abs(whole) < 1e37;
}

// Position of a pixel on a segment.
struct SegmentPoint {
  uint key;        // of its depth
  float coverage;  // 0: the segment does not cover the pixel
  float share;     // fraction of the distance from the first end to the second
};

// \param at center of the pixel. \param side the triangle.
SegmentPoint pointAt(StrandSegment segment, uint side, float2 at, bool reversed) {
  SegmentPoint found;
  found.key = 0u;
  found.coverage = 0.0;
  found.share = 0.0;
  SegmentView seen = viewSegment(segment.exactLow, segment.exactHigh, segment.w, at);
  float4 areas = cornerAreas(seen, side);
  float4 weights = areas / dot(areas, segment.w.xxyy);
  float2 ends = weights.xz + weights.yw;
  float depth = dot(ends, segment.z);
  if (depth >= -1e-6 && depth <= 1.0 + 1e-6) {
    // Clamped: rounding must not leave the segment.
    found.key = clamp(depthKey(depth, reversed), segment.keys.x, segment.keys.y);
    // Linear on the screen: distance and width times w.
    float distance = dot(weights.yw - weights.xz, segment.w * segment.extent);
    found.coverage = ribbonCoverage(distance, dot(ends, segment.w * segment.halfWidth));
    // With perspective.
    float2 bent = ends * segment.share;
    found.share = saturate(bent.y / (bent.x + bent.y));
  }
  return found;
}

// Words as in a node of a list.
struct FragmentWords {
  uint shape;
  uint color;
};

// \param record of the first vertex.
FragmentWords wordsAt(uint record, SegmentPoint found) {
  uint4 look0 = SEGMENT_RECORDS[kRecordWords * record + 2u];
  uint4 look1 = SEGMENT_RECORDS[kRecordWords * record + kRecordWords + 2u];
  float2 first = unpackHalves(look0.z);
  float2 second = unpackHalves(look1.z);
  float opacity = first.y + (second.y - first.y) * found.share;
  float3 low = unpackDirection(look0.x);
  float3 high = unpackDirection(look1.x);
  float3 root = float3(unpackHalves(look0.y), first.x);
  float3 tip = float3(unpackHalves(look1.y), second.x);
  FragmentWords words;
  words.shape = packShape(low + (high - low) * found.share, saturate(opacity * found.coverage));
  words.color = packColor(root + (tip - root) * found.share);
  return words;
}

#endif
