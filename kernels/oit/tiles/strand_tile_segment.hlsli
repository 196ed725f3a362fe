// Segments of strands in the memory of a group, and their fragments in a pixel.
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
#include "../fragment_packing.hlsli"
#include "../../shading/strand_record.hlsli"

static const uint kStagedSegments = 64u;

// [segment]: corners 0 and 1, then 2 and 3: x and y, times w, on the grid, and as they are.
groupshared float4 s_corners[2u * kStagedSegments];
groupshared float4 s_exactCorners[2u * kStagedSegments];
// [segment][end]: w, z, share, half width.
groupshared float4 s_ends[2u * kStagedSegments];
// [segment]: minimum and maximum depth key, tangents of both ends.
groupshared uint4 s_keys[kStagedSegments];
// [segment]: colors of both ends.
groupshared uint4 s_looks[kStagedSegments];
// [segment]: extent of both ends [pixels], as floats, the first record, rows and columns of the
// tile.
groupshared uint4 s_segments[kStagedSegments];

struct TileSegment {
  uint4 corners0, corners1;
  uint4 shape0, shape1;
  uint record;
  uint2 keys;  // minimum and maximum depth key
  uint lines;  // bits 0..7 rows of the tile that may have it, 8..15 columns
};

// Bits 0..7 for the centers of a tile's pixels between two coordinates on one axis.
uint linesBetween(float low, float high, float tile) {
  int first = int(ceil(clamp(low - tile - 0.5, 0.0, 8.0)));
  int last = int(floor(clamp(high - tile - 0.5, -1.0, 7.0)));
  uint bits = 0u;
  if (first <= last) bits = ((2u << uint(last)) - 1u) & ~((1u << uint(first)) - 1u);
  return bits;
}

uint linesOfSegment(SegmentEnd a, SegmentEnd b, float2 tile) {
  float2 low = min(min(a.low, a.high), min(b.low, b.high));
  float2 high = max(max(a.low, a.high), max(b.low, b.high));
  uint rows = linesBetween(low.y, high.y, tile.y);
  uint columns = linesBetween(low.x, high.x, tile.x);
  uint lines = 0u;
  if (rows != 0u && columns != 0u) lines = rows | (columns << 8);
  return lines;
}

// \param tile its first pixel.
TileSegment loadSegment(uint record, float2 tile) {
  TileSegment segment;
  segment.record = record;
  segment.corners0 = g_tileRecords[kRecordWords * record];
  segment.shape0 = g_tileRecords[kRecordWords * record + 1u];
  segment.corners1 = g_tileRecords[kRecordWords * record + kRecordWords];
  segment.shape1 = g_tileRecords[kRecordWords * record + kRecordWords + 1u];
  // Not known if a plane cuts the segment.
  segment.keys = uint2(0u, 0xffffffffu);
  segment.lines = 0xffffu;
  if (isInDepth(segment.shape0) && isInDepth(segment.shape1)) {
    bool reversed = g_reversedDepth != 0u;
    uint a = depthKey(asfloat(segment.shape0.x) / asfloat(segment.shape0.y), reversed);
    uint b = depthKey(asfloat(segment.shape1.x) / asfloat(segment.shape1.y), reversed);
    segment.keys = uint2(min(a, b), max(a, b));
    segment.lines = linesOfSegment(segmentEnd(segment.corners0, segment.shape0),
                                   segmentEnd(segment.corners1, segment.shape1), tile);
  }
  return segment;
}

float extentOf(uint4 shape) { return (shape.w & kRecordWide) != 0u ? asfloat(shape.z) + 0.5 : 0.0; }

void stageSegment(uint slot, TileSegment segment) {
  SegmentEnd a = segmentEnd(segment.corners0, segment.shape0);
  SegmentEnd b = segmentEnd(segment.corners1, segment.shape1);
  uint4 look0 = g_tileRecords[kRecordWords * segment.record + 2u];
  uint4 look1 = g_tileRecords[kRecordWords * segment.record + kRecordWords + 2u];
  s_corners[2u * slot] = float4(a.low, a.high);
  s_corners[2u * slot + 1u] = float4(b.low, b.high);
  s_exactCorners[2u * slot] = asfloat(segment.corners0);
  s_exactCorners[2u * slot + 1u] = asfloat(segment.corners1);
  s_ends[2u * slot] = float4(a.w, a.z, a.share, asfloat(segment.shape0.z));
  s_ends[2u * slot + 1u] = float4(b.w, b.z, b.share, asfloat(segment.shape1.z));
  s_keys[slot] = uint4(segment.keys, look0.x, look1.x);
  s_looks[slot] = uint4(look0.yz, look1.yz);
  s_segments[slot] = uint4(asuint(extentOf(segment.shape0)), asuint(extentOf(segment.shape1)),
                           segment.record, segment.lines);
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

// \param areas of the corners 0..3.
SegmentPoint pointAt(uint slot, float4 areas) {
  SegmentPoint found;
  found.key = 0u;
  found.coverage = 0.0;
  found.share = 0.0;
  float4 a = s_ends[2u * slot];
  float4 b = s_ends[2u * slot + 1u];
  float4 weights = areas / dot(areas, float4(a.xx, b.xx));
  float2 ends = weights.xz + weights.yw;
  float depth = ends.x * a.y + ends.y * b.y;
  if (!(depth >= -1e-6) || !(depth <= 1.0 + 1e-6)) return found;
  // Clamped: rounding must not leave the segment.
  uint2 keys = s_keys[slot].xy;
  found.key = clamp(depthKey(depth, g_reversedDepth != 0u), keys.x, keys.y);
  // Linear on the screen: distance and width times w.
  float2 range = asfloat(s_segments[slot].xy);
  float distance = dot(weights.yw - weights.xz, float2(a.x, b.x) * range);
  found.coverage = ribbonCoverage(distance, dot(ends, float2(a.x * a.w, b.x * b.w)));
  // With perspective.
  float2 bent = ends * float2(a.z, b.z);
  found.share = saturate(bent.y / (bent.x + bent.y));
  return found;
}

// Words as in a node of a list.
struct FragmentWords {
  uint shape;
  uint color;
};

FragmentWords wordsAt(uint slot, SegmentPoint found) {
  uint4 look = s_looks[slot];
  float2 first = unpackHalves(look.y);
  float2 second = unpackHalves(look.w);
  float opacity = first.y + (second.y - first.y) * found.share;
  float3 low = unpackDirection(s_keys[slot].z);
  float3 high = unpackDirection(s_keys[slot].w);
  float3 root = float3(unpackHalves(look.x), first.x);
  float3 tip = float3(unpackHalves(look.z), second.x);
  FragmentWords words;
  words.shape = packShape(low + (high - low) * found.share, saturate(opacity * found.coverage));
  words.color = packColor(root + (tip - root) * found.share);
  return words;
}

#endif
