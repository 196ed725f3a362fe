// Counts the tiles that each segment of a strand touches. With FILL, writes the segment into those
// tiles that have capacity.
//
// Threads: one per vertex, in rows of kRecordDispatchRow; a segment is that of its first vertex.
// Reads:   g_binRecords
// Writes:  g_binTiles; with FILL g_binReferences
//
// The pixels of a segment are those of the triangles 0 1 2 and 2 1 3, cut at the near and the far
// plane. Corners of one end have one depth, so the planes cut all three edges along the segment, or
// none, each at the same fraction of its length.
//
// Invariant (tests/oit): every tile with a pixel center in the triangles has the segment.
#include "../layouts/strand_tiles.hlsli"
#include "../pixel_tiles.hlsli"
#include "../../shading/strand_record.hlsli"
#include "strand_tile_counters.hlsli"

// The fractions of a segment's length between which it is in front of the near and of the far
// plane.
float2 shareInDepth(uint4 first, uint4 second) {
  float2 ends = float2(0.0, 1.0);
  [unroll] for (uint plane = 0u; plane < 2u; ++plane) {
    float a = plane == 0u ? asfloat(first.x) : asfloat(first.y) - asfloat(first.x);
    float b = plane == 0u ? asfloat(second.x) : asfloat(second.y) - asfloat(second.x);
    if (!(a >= 0.0) && !(b >= 0.0)) return float2(1.0, 0.0);
    float cut = saturate(a / (a - b));
    if (!(a >= 0.0)) ends.x = max(ends.x, cut);
    if (!(b >= 0.0)) ends.y = min(ends.y, cut);
  }
  return ends;
}

SegmentEnd timesW(SegmentEnd end, float w) {
  float scale = w > kMinClipW ? w : 1.0;
  end.low *= scale;
  end.high *= scale;
  end.w = w;
  return end;
}

// Coordinates beyond this are not on a screen.
static const float kFarPixel = 1048576.0;

float boundedPixel(float coordinate) {
  return coordinate > -kFarPixel ? min(coordinate, kFarPixel) : -kFarPixel;
}

// On the edge between two corners.
float2 pointOnEdge(float2 a, float aw, float2 b, float bw, float share) {
  float2 coordinate = a + (b - a) * share;
  float w = max(aw + (bw - aw) * share, 1e-12);
  return float2(boundedPixel(coordinate.x / w), boundedPixel(coordinate.y / w));
}

// Extends the span of x by that of an edge between two rows.
float2 spanWithEdge(float2 span, float2 a, float2 b, float2 rows) {
  float2 low = a.y <= b.y ? a : b;
  float2 high = a.y <= b.y ? b : a;
  if (high.y < rows.x || low.y > rows.y) return span;
  float rise = high.y - low.y;
  float slope = rise > 0.0 ? (high.x - low.x) / rise : 0.0;
  float begin = low.x + slope * (max(rows.x, low.y) - low.y);
  float end = low.x + slope * (min(rows.y, high.y) - low.y);
  // An edge along the rows.
  if (!(rise > 0.0)) end = high.x;
  // Rounding does not leave the edge.
  float2 range = float2(min(low.x, high.x), max(low.x, high.x));
  begin = clamp(begin, range.x, range.y);
  end = clamp(end, range.x, range.y);
  return float2(min(span.x, min(begin, end)), max(span.y, max(begin, end)));
}

void addToTile(uint tile, uint reference) {
#if FILL
  // A tile without capacity gets nothing.
  if (g_binTiles[tile] == 0u) return;
  uint coordinate;
  InterlockedAdd(g_binTiles[g_binTileCount + tile], 1u, coordinate);
  if (coordinate < g_binCapacity) g_binReferences[coordinate] = reference;
#else
  InterlockedAdd(g_binTiles[tile], 1u);
#endif
}

// Tiles with a pixel center between two coordinates [pixels] on one axis, extended by a hundredth
// of a pixel; none: x > y.
int2 tilesBetween(float low, float high, uint pixels) {
  int first = int(ceil(max(low - 0.51, 0.0)));
  int last = int(floor(min(high - 0.49, float(pixels) - 1.0)));
  int2 tiles = int2(1, 0);
  if (first <= last) tiles = int2(first >> kTileShift, last >> kTileShift);
  return tiles;
}

[numthreads(128, 1, 1)]
void bin_strands(uint3 group : SV_GroupID, uint lane : SV_GroupIndex) {
  uint index = group.y * kRecordDispatchRow + group.x * 128u + lane;
  if (index + 1u >= g_binRecordCount) return;
  uint4 first = g_binRecords[kRecordWords * index + 1u];
  if ((first.w & kRecordStartsSegment) == 0u) return;
  uint4 second = g_binRecords[kRecordWords * (index + 1u) + 1u];
  if ((second.w & kRecordDrawn) == 0u) return;
  // Fibers without width have no coverage.
  if (!(max(asfloat(first.z), asfloat(second.z)) > 0.0)) return;
  float2 shares = shareInDepth(first, second);
  if (!(shares.x <= shares.y)) return;

  SegmentEnd a = segmentEnd(g_binRecords[kRecordWords * index], first);
  SegmentEnd b = segmentEnd(g_binRecords[kRecordWords * (index + 1u)], second);
  if (!isInDepth(first) || !isInDepth(second)) {
    // Fractions of the length are in clip space.
    a = timesW(a, asfloat(first.y));
    b = timesW(b, asfloat(second.y));
  }
  // Along the edges 0 2, 1 2 and 1 3, at both ends.
  float2 corners[6];
  corners[0] = pointOnEdge(a.low, a.w, b.low, b.w, shares.x);
  corners[1] = pointOnEdge(a.high, a.w, b.low, b.w, shares.x);
  corners[2] = pointOnEdge(a.high, a.w, b.high, b.w, shares.x);
  corners[3] = pointOnEdge(a.low, a.w, b.low, b.w, shares.y);
  corners[4] = pointOnEdge(a.high, a.w, b.low, b.w, shares.y);
  corners[5] = pointOnEdge(a.high, a.w, b.high, b.w, shares.y);
  float2 rows = corners[0].yy;
  [unroll] for (uint i = 1u; i < 6u; ++i) {
    rows = float2(min(rows.x, corners[i].y), max(rows.y, corners[i].y));
  }

  int2 tileRows = tilesBetween(rows.x, rows.y, g_binHeight);
  for (int row = tileRows.x; row <= tileRows.y; ++row) {
    // From the first to the last center of the row's pixels, and a little more.
    float2 slab = float2(float(row) * 8.0 + 0.49, float(row) * 8.0 + 7.51);
    float2 span = float2(kFarPixel, -kFarPixel);
    [unroll] for (uint edge = 0u; edge < 3u; ++edge) {
      span = spanWithEdge(span, corners[edge], corners[edge + 3u], slab);
    }
    [unroll] for (uint end = 0u; end < 6u; end += 3u) {
      span = spanWithEdge(span, corners[end], corners[end + 1u], slab);
      span = spanWithEdge(span, corners[end + 1u], corners[end + 2u], slab);
    }
    if (!(span.x <= span.y)) continue;
    int2 columns = tilesBetween(span.x, span.y, g_binWidth);
    for (int column = columns.x; column <= columns.y; ++column)
      addToTile(uint(row) * g_binTileColumns + uint(column), index);
  }
}
