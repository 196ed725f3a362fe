// Counts the fragments that segments of strands have in each pixel. With FILL, writes those of the
// round.
//
// Threads: one per vertex, in rows of kRecordDispatchRow; a segment is that of its first vertex.
// Reads:   g_binRecords; with OCCLUDED g_binDepth; with FILL g_binTiles
// Writes:  g_binPixels; with FILL g_binFragments, g_binSums
//
// The pixels of a segment are those of the triangles 0 1 2 and 2 1 3. Most segments are cut into
// slices, a row or a column of pixels across the longer side of their bounds, which the threads of a
// group share. Segments that are large, or that a plane cuts, are walked by the whole group, tile by
// tile.
//
// Invariant (tests/oit): the fragments of a rasterizer.
#include "../layouts/strand_tiles.hlsli"
#include "../pixel_tiles.hlsli"
#define SEGMENT_RECORDS g_binRecords
#include "strand_tile_fragment.hlsli"
#include "strand_tile_segment.hlsli"
#include "strand_tile_span.hlsli"

// Larger segments [pixels] are not small: their areas have no 32 bits in units of 1/256 squared.
static const float kSmallExtent = 160.0;
// Coordinates up to this are on the grid.
static const float kSmallCoordinate = 16384.0;

// Segments that are not small.
groupshared uint s_largeCount;
groupshared uint s_large[128];
// Small segments. Corners are in 1/256 of a pixel from the center of the first pixel.
groupshared int4 s_low[128];
groupshared int4 s_high[128];
groupshared uint2 s_first[128];
groupshared uint s_nearest[128];  // depth keys
groupshared uint s_slices[128];   // of this segment and those before it
groupshared uint s_pixels[128];   // of a slice, times 2, plus 1 if slices are columns

// \param opacities of the ends; of no matter without FILL.
void addFragment(StrandSegment segment, float2 opacities, uint record, uint side, uint2 pixel) {
  bool reversed = g_binReversedDepth != 0u;
  // Nothing is visible from this depth key on, as in a cleared target.
  uint behind = depthKey(reversed ? 0.0 : 1.0, reversed);
#if OCCLUDED
  behind = depthKey(g_binDepth[pixel.y * g_binWidth + pixel.x], reversed);
#endif
  if (segment.keys.x < behind) {
    uint tile = (pixel.y >> kTileShift) * g_binTileColumns + (pixel.x >> kTileShift);
    uint word = 64u * tile + ((pixel.y & 7u) << kTileShift) + (pixel.x & 7u);
#if FILL
    if (g_binTiles[g_binTileCount + tile] - g_binRoundBegin < g_binRoundSpan) {
      // Nothing but the write waits for the sum.
      uint end;
      InterlockedAdd(g_binPixels[word], 1u, end);
      SegmentPoint found = pointAt(segment, side, float2(pixel) + 0.5, reversed);
      float opacity = opacities.x + (opacities.y - opacities.x) * found.share;
      TileFragment fragment;
      fragment.key = found.key;
      fragment.root = 0u;
      if (found.coverage > 0.0 && found.key < behind)
        fragment.root = roundedRoot(saturate(opacity * found.coverage), kTileRoots);
      fragment.segment = 2u * record + side;
      uint2 packed = packTileFragment(fragment, g_binSegmentBits);
      uint slot = end - g_binRoundBegin;
      if (slot < g_binCapacity) g_binFragments[slot] = packed;
    }
#else
    InterlockedAdd(g_binPixels[word], 1u);
#endif
  }
}

// Returns the opacities of the ends of a segment.
float2 opacitiesOf(uint record) {
  float2 first = unpackHalves(g_binRecords[kRecordWords * record + 2u].z);
  float2 second = unpackHalves(g_binRecords[kRecordWords * record + kRecordWords + 2u].z);
  return float2(first.y, second.y);
}

// Twice the areas of the edges 12, 20, 01 and 21, 13, 32 with a pixel, whose signs say on which side
// it is, and their steps from pixel to pixel.
struct SideEdges {
  int3 first;   // at the first pixel
  int3 column;  // step to the right
  int3 row;     // step down
};

// \param a, b, c corners, in 1/256 of a pixel from the center of the first pixel.
SideEdges edgesOf(int2 a, int2 b, int2 c) {
  int3 areas = int3(a.x * b.y - a.y * b.x, b.x * c.y - b.y * c.x, c.x * a.y - c.y * a.x);
  int whole = areas.x + areas.y + areas.z;
  int turn = whole > 0 ? 1 : -1;
  int3 alongX = int3(b.x - a.x, c.x - b.x, a.x - c.x) * turn;
  int3 alongY = int3(b.y - a.y, c.y - b.y, a.y - c.y) * turn;
  SideEdges edges;
  edges.first = areas * turn;
  // An edge that is neither a top nor a left one belongs to the other triangle.
  if (!(alongY.x < 0 || (alongY.x == 0 && alongX.x > 0))) edges.first.x -= 1;
  if (!(alongY.y < 0 || (alongY.y == 0 && alongX.y > 0))) edges.first.y -= 1;
  if (!(alongY.z < 0 || (alongY.z == 0 && alongX.z > 0))) edges.first.z -= 1;
  edges.column = -256 * alongY;
  edges.row = 256 * alongX;
  // A triangle without area has no pixel.
  if (whole == 0) {
    edges.first = int3(-1, -1, -1);
    edges.column = int3(0, 0, 0);
    edges.row = int3(0, 0, 0);
  }
  return edges;
}

int2 gridPoint(float2 corner, float2 center) { return int2((corner - center) * 256.0); }

// Pixels of a slice on the inner side of an edge: those from x to y.
// \param area at the first pixel. \param step from pixel to pixel.
int2 clipSlice(int2 slice, int area, int step) {
  // The quotient of floats is one off at most.
  int forward = step > 0 ? 1 : -1;
  float crossing = clamp(float(area) / float(-step), -1.0, float(slice.y) + 1.0);
  int limit = int(step > 0 ? ceil(crossing) : floor(crossing));
  int there = area + step * limit;
  limit += there < 0 ? forward : (there - step * forward >= 0 ? -forward : 0);
  int2 cut =
      int2(step > 0 ? max(slice.x, limit) : slice.x, step > 0 ? slice.y : min(slice.y, limit));
  int2 whole = area < 0 ? int2(1, 0) : slice;
  return step == 0 ? whole : cut;
}

// Pixels of a slice in a triangle: those from x to y.
int2 sliceOf(SideEdges edges, bool columns, int along, int pixels) {
  int3 areas = edges.first + (columns ? edges.column : edges.row) * along;
  int3 steps = columns ? edges.row : edges.column;
  int2 slice = int2(0, pixels - 1);
  slice = clipSlice(slice, areas.x, steps.x);
  slice = clipSlice(slice, areas.y, steps.y);
  slice = clipSlice(slice, areas.z, steps.z);
  return slice;
}

void rasterSlice(uint record, uint own, int along) {
  int2 low = s_low[own].xy;
  int2 one = s_low[own].zw;
  int2 two = s_high[own].xy;
  int2 high = s_high[own].zw;
  bool columns = (s_pixels[own] & 1u) != 0u;
#if FILL
  uint4 shape0 = g_binRecords[kRecordWords * record + 1u];
  uint4 shape1 = g_binRecords[kRecordWords * record + kRecordWords + 1u];
  StrandSegment segment = segmentAt(record, shape0, shape1, g_binReversedDepth != 0u);
  float2 opacities = opacitiesOf(record);
#else
  StrandSegment segment = (StrandSegment)0;
  segment.keys.x = s_nearest[own];
  float2 opacities = float2(0.0, 0.0);
#endif
  int2 slice0 = sliceOf(edgesOf(one, two, low), columns, along, int(s_pixels[own] >> 1));
  int2 slice1 = sliceOf(edgesOf(two, one, high), columns, along, int(s_pixels[own] >> 1));
  // One loop, so that threads with few pixels of a triangle do not wait for others twice.
  int count0 = max(slice0.y - slice0.x + 1, 0);
  int count = count0 + max(slice1.y - slice1.x + 1, 0);
  for (int i = 0; i < count; ++i) {
    uint side = i < count0 ? 0u : 1u;
    int at = i < count0 ? slice0.x + i : slice1.x + i - count0;
    uint2 moved = uint2(columns ? int2(along, at) : int2(at, along));
    addFragment(segment, opacities, record, side, s_first[own] + moved);
  }
}

// A group walks through the tiles of a segment, pixel by pixel.
void rasterLarge(uint record, uint lane) {
  uint4 shape0 = g_binRecords[kRecordWords * record + 1u];
  uint4 shape1 = g_binRecords[kRecordWords * record + kRecordWords + 1u];
  StrandSegment segment = segmentAt(record, shape0, shape1, g_binReversedDepth != 0u);
  float2 opacities = opacitiesOf(record);
  SegmentHull hull = hullOf(record, shape0, shape1);
  int2 tileRows = tilesBetween(hull.rows.x, hull.rows.y, g_binHeight);
  for (int row = tileRows.x; row <= tileRows.y; ++row) {
    int2 columns = tileColumnsOf(hull, row, g_binWidth);
    int end = 64 * (columns.y + 1);
    for (int i = 64 * columns.x + int(lane); i < end; i += 128) {
      uint2 pixel =
          uint2(uint(i >> 6) * kTileEdge + uint(i & 7), uint(row) * kTileEdge + uint((i >> 3) & 7));
      if (pixel.x >= g_binWidth || pixel.y >= g_binHeight) continue;
      SegmentView seen = viewSegment(segment.low, segment.high, segment.w, float2(pixel) + 0.5);
      for (uint side = 0u; side < 2u; ++side) {
        if (isCovered(seen, side, segment.w)) addFragment(segment, opacities, record, side, pixel);
      }
    }
  }
}

// Slices of the lanes up to this one. All lanes call it.
void sumSlices(uint lane) {
  for (uint range = 1u; range < 128u; range *= 2u) {
    uint others = 0u;
    if (lane >= range) others = s_slices[lane - range];
    GroupMemoryBarrierWithGroupSync();
    s_slices[lane] += others;
    GroupMemoryBarrierWithGroupSync();
  }
}

void prepareSmall(StrandSegment segment, uint lane, float2 low, float2 high) {
  int2 first = int2(ceil(max(low - 0.5, 0.0)));
  int2 last = int2(floor(min(high - 0.5, float2(float(g_binWidth), float(g_binHeight)) - 1.0)));
  if (first.x > last.x || first.y > last.y) return;
  float2 center = float2(first) + 0.5;
  s_low[lane] = int4(gridPoint(segment.low.xy, center), gridPoint(segment.low.zw, center));
  s_high[lane] = int4(gridPoint(segment.high.xy, center), gridPoint(segment.high.zw, center));
  s_first[lane] = uint2(first);
  s_nearest[lane] = segment.keys.x;
  uint2 size = uint2(last - first) + 1u;
  bool columns = size.x > size.y;
  s_slices[lane] = columns ? size.x : size.y;
  s_pixels[lane] = columns ? 2u * size.y + 1u : 2u * size.x;
}

[numthreads(128, 1, 1)]
void raster_strands(uint3 group : SV_GroupID, uint lane : SV_GroupIndex) {
  uint begin = group.y * kRecordDispatchRow + group.x * 128u;
  uint index = begin + lane;
#if FILL
  if (index == 0u) g_binSums[binBlocks()].x = 0u;
#endif
  if (lane == 0u) s_largeCount = 0u;
  s_slices[lane] = 0u;
  GroupMemoryBarrierWithGroupSync();
  if (index + 1u < g_binRecordCount) {
    uint4 shape0 = g_binRecords[kRecordWords * index + 1u];
    uint4 shape1 = g_binRecords[kRecordWords * index + kRecordWords + 1u];
    if (isSegment(shape0, shape1)) {
      StrandSegment segment = segmentAt(index, shape0, shape1, g_binReversedDepth != 0u);
      float2 low = min(min(segment.low.xy, segment.low.zw), min(segment.high.xy, segment.high.zw));
      float2 high = max(max(segment.low.xy, segment.low.zw), max(segment.high.xy, segment.high.zw));
      float2 extent = high - low;
      float2 farthest = max(-low, high);
      // Minima and maxima pass over what is not a number; the sum does not.
      float sum = dot(segment.low + segment.high, float4(1.0, 1.0, 1.0, 1.0));
      bool small =
          isInDepth(shape0) && isInDepth(shape1) && max(extent.x, extent.y) < kSmallExtent &&
          max(farthest.x, farthest.y) < kSmallCoordinate && abs(sum) <= 8.0 * kSmallCoordinate;
      if (small) {
        prepareSmall(segment, lane, low, high);
      } else {
        uint slot;
        InterlockedAdd(s_largeCount, 1u, slot);
        s_large[slot] = index;
      }
    }
  }
  GroupMemoryBarrierWithGroupSync();
  sumSlices(lane);
  for (uint i = lane; i < s_slices[127]; i += 128u) {
    // The first lane whose slices end behind this one.
    uint own = 0u;
    [unroll] for (uint step = 64u; step > 0u; step /= 2u) {
      if (s_slices[own + step - 1u] <= i) own += step;
    }
    uint before = 0u;
    if (own > 0u) before = s_slices[own - 1u];
    rasterSlice(begin + own, own, int(i - before));
  }
  uint count = s_largeCount;
  for (uint k = 0u; k < count; ++k) rasterLarge(s_large[k], lane);
}
