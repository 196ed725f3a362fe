// The tiles that a segment touches: those of the triangles 0 1 2 and 2 1 3, cut at the near and the
// far plane. Corners of one end have one depth, so the planes cut all three edges along the segment,
// or none, each at the same fraction of its length. The including file has
// strand_tile_segment.hlsli.
//
// Invariant (tests/oit): every tile with a pixel center in the triangles is one of them.
#ifndef PELAGE_OIT_TILES_STRAND_TILE_SPAN_HLSLI
#define PELAGE_OIT_TILES_STRAND_TILE_SPAN_HLSLI

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

// Tiles with a pixel center between two coordinates [pixels] on one axis, extended by a hundredth
// of a pixel; none: x > y.
int2 tilesBetween(float low, float high, uint pixels) {
  int first = int(ceil(max(low - 0.51, 0.0)));
  int last = int(floor(min(high - 0.49, float(pixels) - 1.0)));
  int2 tiles = int2(1, 0);
  if (first <= last) tiles = int2(first >> kTileShift, last >> kTileShift);
  return tiles;
}

// The part of a segment between the planes.
struct SegmentHull {
  float2 corners[6];  // along the edges 0 2, 1 2 and 1 3, at both ends [pixels]
  float2 rows;        // lowest and highest; x > y: nothing is left
};

SegmentHull hullOf(uint record, uint4 first, uint4 second) {
  float2 shares = shareInDepth(first, second);
  SegmentEnd a = segmentEnd(SEGMENT_RECORDS[kRecordWords * record], first);
  SegmentEnd b = segmentEnd(SEGMENT_RECORDS[kRecordWords * record + kRecordWords], second);
  if (!isInDepth(first) || !isInDepth(second)) {
    // Fractions of the length are in clip space.
    a = timesW(a, asfloat(first.y));
    b = timesW(b, asfloat(second.y));
  }
  SegmentHull hull;
  hull.corners[0] = pointOnEdge(a.low, a.w, b.low, b.w, shares.x);
  hull.corners[1] = pointOnEdge(a.high, a.w, b.low, b.w, shares.x);
  hull.corners[2] = pointOnEdge(a.high, a.w, b.high, b.w, shares.x);
  hull.corners[3] = pointOnEdge(a.low, a.w, b.low, b.w, shares.y);
  hull.corners[4] = pointOnEdge(a.high, a.w, b.low, b.w, shares.y);
  hull.corners[5] = pointOnEdge(a.high, a.w, b.high, b.w, shares.y);
  hull.rows = hull.corners[0].yy;
  [unroll] for (uint i = 1u; i < 6u; ++i) {
    hull.rows = float2(min(hull.rows.x, hull.corners[i].y), max(hull.rows.y, hull.corners[i].y));
  }
  if (!(shares.x <= shares.y)) hull.rows = float2(kFarPixel, -kFarPixel);
  return hull;
}

// The first and the last tile of a row of tiles that a segment touches; none: x > y.
int2 tileColumnsOf(SegmentHull hull, int row, uint width) {
  // From the first to the last center of the row's pixels, and a little more.
  float2 slab = float2(float(row) * 8.0 + 0.49, float(row) * 8.0 + 7.51);
  float2 span = float2(kFarPixel, -kFarPixel);
  [unroll] for (uint edge = 0u; edge < 3u; ++edge) {
    span = spanWithEdge(span, hull.corners[edge], hull.corners[edge + 3u], slab);
  }
  [unroll] for (uint end = 0u; end < 6u; end += 3u) {
    span = spanWithEdge(span, hull.corners[end], hull.corners[end + 1u], slab);
    span = spanWithEdge(span, hull.corners[end + 1u], hull.corners[end + 2u], slab);
  }
  int2 columns = int2(1, 0);
  if (span.x <= span.y) columns = tilesBetween(span.x, span.y, width);
  return columns;
}

#endif
