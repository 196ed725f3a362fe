// Counts the fragments that segments of strands have in each pixel. With FILL, writes those of the
// round.
//
// Threads: one per vertex, in rows of kRecordDispatchRow; a segment is that of its first vertex.
// Reads:   g_binRecords; with OCCLUDED g_binDepth; with FILL g_binTiles
// Writes:  g_binPixels; with FILL g_binFragments, g_binSegments, g_binSums
//
// The pixels of a segment are those of the triangles 0 1 2 and 2 1 3. Of most segments, a thread
// marks the pixels of a block of 8 x 8 in two masks, and then walks through the bits: the threads of
// a group do the costly part together. Those that are large, or that a plane cuts, are shared by the
// whole group, which looks into the tiles that they touch.
//
// Invariant (tests/oit): the fragments of a rasterizer.
#include "../layouts/strand_tiles.hlsli"
#include "../pixel_tiles.hlsli"
#define SEGMENT_RECORDS g_binRecords
#include "strand_tile_fragment.hlsli"
#include "strand_tile_segment.hlsli"
#include "strand_tile_span.hlsli"

// Larger segments [pixels] are not small: their areas have no 32 bits in units of 1/256 squared.
static const float kSmallExtent = 100.0;
// Coordinates up to this are on the grid.
static const float kSmallCoordinate = 16384.0;

// Segments that are not small.
groupshared uint s_largeCount;
groupshared uint s_large[128];

void addFragment(StrandSegment segment, uint record, uint side, uint2 pixel) {
  bool reversed = g_binReversedDepth != 0u;
  // Nothing is visible from this depth key on, as in a cleared target.
  uint behind = depthKey(reversed ? 0.0 : 1.0, reversed);
#if OCCLUDED
  behind = depthKey(g_binDepth[pixel.y * g_binWidth + pixel.x], reversed);
#endif
  if (segment.keys.x >= behind) return;
  uint tile = (pixel.y >> kTileShift) * g_binTileColumns + (pixel.x >> kTileShift);
  uint word = 64u * tile + ((pixel.y & 7u) << kTileShift) + (pixel.x & 7u);
#if FILL
  if (g_binTiles[g_binTileCount + tile] - g_binRoundBegin >= g_binRoundSpan) return;
  uint end;
  InterlockedAdd(g_binPixels[word], 1u, end);
  uint slot = end - g_binRoundBegin;
  if (slot >= g_binCapacity) return;
  SegmentPoint found = pointAt(segment, side, float2(pixel) + 0.5, reversed);
  float2 first = unpackHalves(g_binRecords[kRecordWords * record + 2u].z);
  float2 second = unpackHalves(g_binRecords[kRecordWords * record + kRecordWords + 2u].z);
  float opacity = first.y + (second.y - first.y) * found.share;
  uint root = roundedRoot(saturate(opacity * found.coverage), 1023u);
  uint depth = 0u;
  if (found.coverage > 0.0 && found.key < behind && root > 0u)
    depth = opticalDepthOf(squared(root, 1023u));
  g_binFragments[slot] = uint2(found.key, depth);
  g_binSegments[slot] = 2u * record + side;
#else
  InterlockedAdd(g_binPixels[word], 1u);
#endif
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

bool areInside(int3 areas) { return (areas.x | areas.y | areas.z) >= 0; }

int2 gridPoint(float2 corner, float2 center) { return int2((corner - center) * 256.0); }

void rasterSmall(StrandSegment segment, uint record, float2 low, float2 high) {
  int2 first = int2(ceil(max(low - 0.5, 0.0)));
  int2 last = int2(floor(min(high - 0.5, float2(float(g_binWidth), float(g_binHeight)) - 1.0)));
  if (first.x > last.x || first.y > last.y) return;
  float2 center = float2(first) + 0.5;
  int2 one = gridPoint(segment.low.zw, center);
  int2 two = gridPoint(segment.high.xy, center);
  SideEdges left = edgesOf(one, two, gridPoint(segment.low.xy, center));
  SideEdges right = edgesOf(two, one, gridPoint(segment.high.zw, center));
  for (int y = first.y; y <= last.y; y += 8) {
    for (int x = first.x; x <= last.x; x += 8) {
      uint2 leftMask = uint2(0u, 0u);
      uint2 rightMask = uint2(0u, 0u);
      int2 moved = int2(x, y) - first;
      int3 leftRow = left.first + left.column * moved.x + left.row * moved.y;
      int3 rightRow = right.first + right.column * moved.x + right.row * moved.y;
      int rows = min(last.y - y + 1, 8);
      int columns = min(last.x - x + 1, 8);
      for (int j = 0; j < rows; ++j) {
        int3 leftAt = leftRow;
        int3 rightAt = rightRow;
        uint leftBits = 0u;
        uint rightBits = 0u;
        for (int i = 0; i < columns; ++i) {
          if (areInside(leftAt)) leftBits |= 1u << uint(i);
          if (areInside(rightAt)) rightBits |= 1u << uint(i);
          leftAt += left.column;
          rightAt += right.column;
        }
        uint shift = 8u * (uint(j) & 3u);
        if (j < 4) {
          leftMask.x |= leftBits << shift;
          rightMask.x |= rightBits << shift;
        } else {
          leftMask.y |= leftBits << shift;
          rightMask.y |= rightBits << shift;
        }
        leftRow += left.row;
        rightRow += right.row;
      }
      while ((leftMask.x | leftMask.y | rightMask.x | rightMask.y) != 0u) {
        uint side = (leftMask.x | leftMask.y) != 0u ? 0u : 1u;
        uint2 mask = side == 0u ? leftMask : rightMask;
        uint bit = mask.x != 0u ? firstbitlow(mask.x) : 32u + firstbitlow(mask.y);
        if (mask.x != 0u)
          mask.x &= mask.x - 1u;
        else
          mask.y &= mask.y - 1u;
        if (side == 0u)
          leftMask = mask;
        else
          rightMask = mask;
        addFragment(segment, record, side, uint2(int2(x, y)) + uint2(bit & 7u, bit >> 3));
      }
    }
  }
}

// A group walks through the tiles of a segment, pixel by pixel.
void rasterLarge(uint record, uint lane) {
  uint4 shape0 = g_binRecords[kRecordWords * record + 1u];
  uint4 shape1 = g_binRecords[kRecordWords * record + kRecordWords + 1u];
  StrandSegment segment = segmentAt(record, shape0, shape1, g_binReversedDepth != 0u);
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
        if (isCovered(seen, side, segment.w)) addFragment(segment, record, side, pixel);
      }
    }
  }
}

[numthreads(128, 1, 1)]
void raster_strands(uint3 group : SV_GroupID, uint lane : SV_GroupIndex) {
  uint index = group.y * kRecordDispatchRow + group.x * 128u + lane;
#if FILL
  if (index == 0u) g_binSums[binBlocks()].x = 0u;
#endif
  if (lane == 0u) s_largeCount = 0u;
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
        rasterSmall(segment, index, low, high);
      } else {
        uint slot;
        InterlockedAdd(s_largeCount, 1u, slot);
        s_large[slot] = index;
      }
    }
  }
  GroupMemoryBarrierWithGroupSync();
  uint count = s_largeCount;
  for (uint k = 0u; k < count; ++k) rasterLarge(s_large[k], lane);
}
