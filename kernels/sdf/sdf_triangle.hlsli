// The triangles of a field that is built, and how far they are.
#ifndef PELAGE_SDF_SDF_TRIANGLE_HLSLI
#define PELAGE_SDF_SDF_TRIANGLE_HLSLI

#include "../common/quaternion.hlsli"
#include "sdf_key.hlsli"
#include "sdf_work.hlsli"

struct PlacedTriangle {
  float3 a;
  float3 b;
  float3 c;
  bool usable;  // all corners are finite
};

uint slotNow() { return g_placeSlot & 1u; }
uint slotBefore() { return slotNow() ^ 1u; }

PlacedTriangle loadTriangle(uint index, uint slot) {
  PlacedTriangle t;
  t.a = float3(0.0, 0.0, 0.0);
  t.b = t.a;
  t.c = t.a;
  t.usable = false;
  uint i = g_sdfIndices[3 * index];
  uint j = g_sdfIndices[3 * index + 1];
  uint k = g_sdfIndices[3 * index + 2];
  if (max(i, max(j, k)) >= g_placeCount) return t;
  uint first = slot * g_placeCount;
  float4 a = g_sdfPlaces[first + i];
  float4 b = g_sdfPlaces[first + j];
  float4 c = g_sdfPlaces[first + k];
  t.a = a.xyz;
  t.b = b.xyz;
  t.c = c.xyz;
  t.usable = a.w > 0.0 && b.w > 0.0 && c.w > 0.0;
  return t;
}

// What distances to a triangle need. The planes stand on the edges, at right angles to the face.
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

// Height over the longest edge, squared. A face below kThinnest has no normal that could be
// trusted; its edges are never more than half its height from it.
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
  return uint(node.x) + g_fieldNodes.x * (uint(node.y) + g_fieldNodes.y * uint(node.z));
}

// Nodes that the band of a triangle can reach; none where low > high.
struct NodeRange {
  int3 low;
  int3 high;
};

NodeRange rangeOf(PlacedTriangle t) {
  NodeRange range;
  precise float3 lowest = min(t.a, min(t.b, t.c)) - g_fieldBand;
  precise float3 highest = max(t.a, max(t.b, t.c)) + g_fieldBand;
  range.low = max(int3(ceil(lowest)), int3(0, 0, 0));
  range.high = min(int3(floor(highest)), int3(g_fieldNodes.xyz) - 1);
  return range;
}

bool isEmpty(NodeRange range) {
  return range.low.x > range.high.x || range.low.y > range.high.y || range.low.z > range.high.z;
}

// Of that many things; exact below 2^20 of them.
float shareOf(int count) {
  precise float r = 1.0 / float(count);
  return r;
}

// Whole part of index / count.
int quotient(int index, float share) {
  precise float r = (float(index) + 0.5) * share;
  return int(r);
}

// Puts the triangle into a node's key when it is within the band.
void scatterNode(int3 node, uint index, TriangleShape shape) {
  float squared = squaredDistance(float3(node), shape);
  precise float limit = g_fieldBand * g_fieldBand;
  if (squared > limit) return;
  uint key = sdfNearKey(squareRoot(squared), index, g_fieldBand, g_fieldTriangleBits);
  InterlockedMin(g_sdfKeys[g_fieldNodes.w + nodeIndex(node)], key);
}

#endif
