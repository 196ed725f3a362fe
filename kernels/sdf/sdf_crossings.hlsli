// Signed crossings of the grid's lines with a triangle. A line along an axis through nodes enters
// the solid where the triangle faces against the axis: +1, and leaves it where it faces along the
// axis: -1. The sum of the crossings before a node is the number of solids that contain it.
//
// Every line must cross a closed surface as often from one side as from the other. Corners are
// snapped to 2^-14 cell across the line; then integers decide exactly on which side of an edge a
// line is, and the top-left rule of rasterizers gives a line through an edge to one of its two
// triangles. This displaces the surface by at most 2^-14 / sqrt 2 = 4.3e-5 cell.
#ifndef PELAGE_SDF_SDF_CROSSINGS_HLSLI
#define PELAGE_SDF_SDF_CROSSINGS_HLSLI

#include "sdf_triangle.hlsli"

static const int kSnapBits = 14;
static const float kSnap = 16384.0;
// Maximum extent [2^-14 cell] of a triangle whose edge functions fit 32 bits: 46340^2 < 2^31.
static const int kSmallExtent = 46340;

// 64 bits, two's complement.
struct Wide {
  uint low;
  uint high;
};

Wide product(int x, int y) {
  // A negative factor, as an unsigned number, is 2^32 too large.
  uint a = uint(x), b = uint(y);
  uint a0 = a & 0xffffu, a1 = a >> 16, b0 = b & 0xffffu, b1 = b >> 16;
  uint low = a0 * b0;
  uint middle = a1 * b0 + (low >> 16);
  uint other = a0 * b1 + (middle & 0xffffu);
  Wide r;
  r.low = (other << 16) | (low & 0xffffu);
  r.high = a1 * b1 + (middle >> 16) + (other >> 16);
  if (x < 0) r.high = r.high - b;
  if (y < 0) r.high = r.high - a;
  return r;
}

Wide difference(Wide a, Wide b) {
  Wide r;
  r.low = a.low - b.low;
  r.high = a.high - b.high - (a.low < b.low ? 1u : 0u);
  return r;
}

// Returns the side of the edge from `from` along `edge` on which a point is: > 0 to its left.
struct Side {
  float weight;  // twice the area between them
  int sign;
};

Side sideOf(int2 from, int2 edge, int2 p, bool small) {
  Side side;
  int2 arm = p - from;
  if (small) {
    int area = edge.x * arm.y - edge.y * arm.x;
    side.sign = sign(area);
    side.weight = float(area);
  } else {
    Wide area = difference(product(edge.x, arm.y), product(edge.y, arm.x));
    bool zero = (area.low | area.high) == 0u;
    side.sign = zero ? 0 : ((area.high & 0x80000000u) != 0u ? -1 : 1);
    precise float weight = float(int(area.high)) * 4294967296.0 + float(area.low);
    side.weight = weight;
  }
  return side;
}

// A line on the edge belongs to the triangle on one side of it.
bool isInside(Side side, int2 edge) {
  return side.sign > 0 || (side.sign == 0 && (edge.y < 0 || (edge.y == 0 && edge.x > 0)));
}

// The lines along x, whatever axis of the grid x is.
struct GridLines {
  int3 nodes;     // along x, y, z
  uint3 strides;  // of g_sdfKeys, likewise
  uint words;     // first element of the axis in g_sdfCounts
};

// Adds `weight` for each crossing of the triangle a, b, c with the lines. Lanes share the lines.
void addCrossingsAlong(GridLines grid, float3 a, float3 b, float3 c, int weight, uint lane,
                       uint lanes) {
  precise float2 fa = floor(a.yz * kSnap + 0.5);
  precise float2 fb = floor(b.yz * kSnap + 0.5);
  precise float2 fc = floor(c.yz * kSnap + 0.5);
  int2 sa = int2(fa), sb = int2(fb), sc = int2(fc);
  int2 lowest = min(sa, min(sb, sc));
  int2 highest = max(sa, max(sb, sc));
  int2 low = max((lowest + ((1 << kSnapBits) - 1)) >> kSnapBits, int2(0, 0));
  int2 high = min(highest >> kSnapBits, grid.nodes.yz - 1);
  if (low.x > high.x || low.y > high.y) return;

  int2 extent = highest - lowest;
  bool small = max(extent.x, extent.y) <= kSmallExtent;
  int facing = sideOf(sa, sb - sa, sc, small).sign;
  if (facing == 0) return;
  // Counter-clockwise.
  bool turned = facing < 0;
  int2 s1 = turned ? sc : sb;
  int2 s2 = turned ? sb : sc;
  precise float x1 = (turned ? c.x : b.x) - a.x;
  precise float x2 = (turned ? b.x : c.x) - a.x;
  int2 e0 = s1 - sa, e1 = s2 - s1, e2 = sa - s2;
  uint amount = asuint(-facing * weight);

  uint across = uint(high.x - low.x + 1);
  uint lines = across * uint(high.y - low.y + 1);
  for (uint i = lane; i < lines; i += lanes) {
    uint row = i / across;
    int2 node = low + int2(int(i - row * across), int(row));
    int2 p = int2(node.x << kSnapBits, node.y << kSnapBits);
    Side f0 = sideOf(sa, e0, p, small);
    Side f1 = sideOf(s1, e1, p, small);
    Side f2 = sideOf(s2, e2, p, small);
    if (!isInside(f0, e0) || !isInside(f1, e1) || !isInside(f2, e2)) continue;
    // Barycentric: never beyond the corners, however thin the triangle is.
    precise float area = f0.weight + f1.weight + f2.weight;
    precise float x = a.x + (f2.weight * x1 + f0.weight * x2) / area;
    int at = max(int(ceil(x)), 0);
    if (at >= grid.nodes.x) continue;
    uint3 strides = grid.strides;
    uint index = uint(at) * strides.x + uint(node.x) * strides.y + uint(node.y) * strides.z;
    InterlockedAdd(g_sdfCounts[grid.words + index / 4], amount << (8u * (index % 4u)));
  }
}

void addCrossings(PointTriangle t, int weight, uint lane, uint lanes) {
  GridLines x;
  x.nodes = int3(g_sdfNodes.xyz);
  x.strides = uint3(1u, g_sdfNodes.x, g_sdfNodes.x * g_sdfNodes.y);
  x.words = 0u;
  addCrossingsAlong(x, t.a, t.b, t.c, weight, lane, lanes);
  if (!hasThreeAxes()) return;
  GridLines y;
  y.nodes = x.nodes.yzx;
  y.strides = x.strides.yzx;
  y.words = x.strides.z * g_sdfNodes.z / 4;
  addCrossingsAlong(y, t.a.yzx, t.b.yzx, t.c.yzx, weight, lane, lanes);
  GridLines z;
  z.nodes = x.nodes.zxy;
  z.strides = x.strides.zxy;
  z.words = 2u * y.words;
  addCrossingsAlong(z, t.a.zxy, t.b.zxy, t.c.zxy, weight, lane, lanes);
}

#endif
