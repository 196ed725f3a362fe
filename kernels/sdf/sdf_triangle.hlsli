// The triangles of an SDF that is being built, and distances to them.
#ifndef PELAGE_SDF_SDF_TRIANGLE_HLSLI
#define PELAGE_SDF_SDF_TRIANGLE_HLSLI

#include "../base/quaternion.hlsli"
#include "sdf_key.hlsli"
#include "sdf_work.hlsli"

struct PointTriangle {
  float3 a;
  float3 b;
  float3 c;
  bool usable;  // all corners are finite
};

uint slotNow() { return g_pointSlot & 1u; }
uint slotBefore() { return slotNow() ^ 1u; }

PointTriangle loadTriangle(uint index, uint slot) {
  PointTriangle t;
  t.a = float3(0.0, 0.0, 0.0);
  t.b = t.a;
  t.c = t.a;
  t.usable = false;
  uint i = g_sdfIndices[3 * index];
  uint j = g_sdfIndices[3 * index + 1];
  uint k = g_sdfIndices[3 * index + 2];
  if (max(i, max(j, k)) >= g_pointCount) return t;
  uint first = slot * g_pointCount;
  float4 a = g_sdfPoints[first + i];
  float4 b = g_sdfPoints[first + j];
  float4 c = g_sdfPoints[first + k];
  t.a = a.xyz;
  t.b = b.xyz;
  t.c = c.xyz;
  t.usable = a.w > 0.0 && b.w > 0.0 && c.w > 0.0;
  return t;
}

// Data for distances to a triangle. The planes stand on the edges, at right angles to the face.
struct TriangleShape {
  float3 a;
  float3 b;
  float3 c;
  float3 ab;
  float3 bc;
  float3 ca;
  float3 normal;  // of any length
  float3 planeAb;
  float3 planeBc;
  float3 planeCa;
  float inverseNormal;  // 1 / normal^2; 0: too thin for a face, its edges stand for it
  float inverseAb;      // 1 / ab^2, or 0
  float inverseBc;
  float inverseCa;
  bool hasArea;  // false: at one point or on a line, but for rounding
};

// Height over the longest edge, squared. A face below kThinnest has no reliable normal; its edges
// are never more than half its height from it.
static const float kThinnest = 1e-9;
static const float kNoArea = 1e-14;

float inverseOrZero(float x) {
  precise float r = x > 1e-30 ? 1.0 / x : 0.0;
  return r;
}

TriangleShape shapeOf(float3 a, float3 b, float3 c) {
  TriangleShape shape;
  precise float3 ab = b - a;
  precise float3 bc = c - b;
  precise float3 ca = a - c;
  precise float3 normal = cross3(ab, -ca);
  precise float squared = dot3(normal, normal);
  precise float ab2 = dot3(ab, ab);
  precise float bc2 = dot3(bc, bc);
  precise float ca2 = dot3(ca, ca);
  precise float longest = max(ab2, max(bc2, ca2));
  precise float limit = longest * longest;
  precise float thin = limit * kThinnest;
  precise float none = limit * kNoArea;
  shape.a = a;
  shape.b = b;
  shape.c = c;
  shape.ab = ab;
  shape.bc = bc;
  shape.ca = ca;
  shape.normal = normal;
  shape.planeAb = cross3(normal, ab);
  shape.planeBc = cross3(normal, bc);
  shape.planeCa = cross3(normal, ca);
  shape.inverseNormal = squared > thin ? inverseOrZero(squared) : 0.0;
  shape.inverseAb = inverseOrZero(ab2);
  shape.inverseBc = inverseOrZero(bc2);
  shape.inverseCa = inverseOrZero(ca2);
  shape.hasArea = squared > none && squared > 1e-30;
  return shape;
}

float squaredToEdge(float3 fromStart, float3 edge, float inverse) {
  precise float along = min(max(dot3(fromStart, edge) * inverse, 0.0), 1.0);
  precise float3 rest = fromStart - edge * along;
  return dot3(rest, rest);
}

// By the planes on the edges: unlike barycentric coordinates they do not cancel near an edge.
float squaredDistance(float3 p, TriangleShape shape) {
  precise float3 pa = p - shape.a;
  precise float3 pb = p - shape.b;
  precise float3 pc = p - shape.c;
  if (shape.inverseNormal > 0.0 && dot3(shape.planeAb, pa) >= 0.0 &&
      dot3(shape.planeBc, pb) >= 0.0 && dot3(shape.planeCa, pc) >= 0.0) {
    precise float height = dot3(pa, shape.normal);
    precise float r = height * height * shape.inverseNormal;
    return r;
  }
  return min(squaredToEdge(pa, shape.ab, shape.inverseAb),
             min(squaredToEdge(pb, shape.bc, shape.inverseBc),
                 squaredToEdge(pc, shape.ca, shape.inverseCa)));
}

uint nodeIndex(int3 node) {
  return uint(node.x) + g_sdfNodes.x * (uint(node.y) + g_sdfNodes.y * uint(node.z));
}

// Range of nodes in the band of a triangle; empty if low > high.
struct NodeRange {
  int3 low;
  int3 high;
};

NodeRange rangeOf(PointTriangle t) {
  NodeRange range;
  precise float3 lowest = min(t.a, min(t.b, t.c)) - g_sdfBand;
  precise float3 highest = max(t.a, max(t.b, t.c)) + g_sdfBand;
  range.low = max(int3(ceil(lowest)), int3(0, 0, 0));
  range.high = min(int3(floor(highest)), int3(g_sdfNodes.xyz) - 1);
  return range;
}

bool isEmpty(NodeRange range) {
  return range.low.x > range.high.x || range.low.y > range.high.y || range.low.z > range.high.z;
}

// For this many elements; exact below 2^20.
float shareOf(int count) {
  precise float r = 1.0 / float(count);
  return r;
}

// Whole part of index / count.
int quotient(int index, float share) {
  precise float r = (float(index) + 0.5) * share;
  return int(r);
}

// Writes the triangle into a node's key if it is within the band.
void scatterNode(int3 node, uint index, TriangleShape shape) {
  float squared = squaredDistance(float3(node), shape);
  precise float limit = g_sdfBand * g_sdfBand;
  if (squared > limit) return;
  uint key = sdfNearKey(squareRoot(squared), index, g_sdfBand, g_sdfTriangleBits);
  InterlockedMin(g_sdfKeys[g_sdfNodes.w + nodeIndex(node)], key);
}

#endif
