// The closest point of a triangle of an SDF's surface, the side of the surface on which a point is,
// and the motion of the surface there. The including file defines SDF_SURFACE. Units are cells.
//
// Closest points are found by the planes through the edges. Deciding by barycentric coordinates
// loses up to 4e-4 cell on slivers. A face that is thinner than 3e-5 of its length has no normal to
// trust: its edges stand for it.
#ifndef PELAGE_SDF_SDF_CLOSEST_HLSLI
#define PELAGE_SDF_SDF_CLOSEST_HLSLI

#include "../base/octahedral.hlsli"
#include "layouts/sdf.hlsli"

// Features of a triangle: the face, edge kSdfEdge + k from vertex k to the next one, and vertex
// kSdfVertex + k.
static const uint kSdfFace = 0;
static const uint kSdfEdge = 1;
static const uint kSdfVertex = 4;

// k of an edge or a vertex.
uint sdfPart(uint feature) {
  return feature >= kSdfVertex ? feature - kSdfVertex : feature - kSdfEdge;
}

struct SdfCorner3 {
  float3 a;
  float3 b;
  float3 c;
};

struct SdfClosest {
  float squared;   // distance^2 [cell^2]
  float3 offset;   // from there to the point
  float2 weights;  // of vertices 1 and 2 there
  uint index;      // triangle; kSdfNone: there is none
  uint feature;
};

SdfClosest noTriangle() {
  SdfClosest closest;
  closest.squared = 1e30;
  closest.offset = float3(0.0, 0.0, 0.0);
  closest.weights = float2(0.0, 0.0);
  closest.index = kSdfNone;
  closest.feature = kSdfFace;
  return closest;
}

uint sdfRecord(Sdf sdf, uint index) { return sdf.surface + index * sdf.surfaceStride; }

SdfCorner3 loadSdfCorners(Sdf sdf, uint index) {
  uint row = sdfRecord(sdf, index);
  SdfCorner3 corners;
  corners.a = asfloat(SDF_SURFACE[row].xyz);
  corners.b = asfloat(SDF_SURFACE[row + 1].xyz);
  corners.c = asfloat(SDF_SURFACE[row + 2].xyz);
  return corners;
}

// Triangles across its edges; kSdfNone if there is none.
uint3 sdfNeighbors(Sdf sdf, uint index) { return SDF_SURFACE[sdfRecord(sdf, index) + 3].xyz; }

float3 sdfFaceNormal(SdfCorner3 corners) {
  precise float3 n = cross3(corners.b - corners.a, corners.c - corners.a);
  return n;
}

// Closest point of the edge e to the point that is q away from the start of e.
struct SdfEdgePoint {
  float3 offset;
  float squared;
  float share;
};

SdfEdgePoint closestOnEdge(float3 q, float3 e) {
  precise float squaredLength = dot3(e, e);
  precise float along = dot3(q, e);
  precise float share = squaredLength > 0.0 ? along / squaredLength : 0.0;
  share = min(max(share, 0.0), 1.0);
  precise float3 offset = q - e * share;
  SdfEdgePoint found;
  found.offset = offset;
  found.squared = dot3(offset, offset);
  found.share = share;
  return found;
}

SdfClosest closestOnCorners(SdfCorner3 corners, float3 p, uint index) {
  precise float3 ab = corners.b - corners.a;
  precise float3 bc = corners.c - corners.b;
  precise float3 ca = corners.a - corners.c;
  precise float3 pa = p - corners.a;
  precise float3 pb = p - corners.b;
  precise float3 pc = p - corners.c;
  float3 n = sdfFaceNormal(corners);
  precise float size = dot3(n, n);
  precise float longest = max(dot3(ab, ab), max(dot3(bc, bc), dot3(ca, ca)));
  precise float thinnest = longest * longest * 1e-9;
  // Over each edge: the weight of the vertex across from it at the point's foot, times the size.
  precise float overAb = dot3(cross3(n, ab), pa);
  precise float overBc = dot3(cross3(n, bc), pb);
  precise float overCa = dot3(cross3(n, ca), pc);
  SdfClosest closest;
  closest.index = index;
  if (size > thinnest && min(overAb, min(overBc, overCa)) >= 0.0) {
    precise float height = dot3(pa, n) / size;
    precise float3 offset = n * height;
    precise float2 weights = float2(overCa, overAb) / size;
    closest.offset = offset;
    closest.squared = dot3(offset, offset);
    closest.weights = weights;
    closest.feature = kSdfFace;
    return closest;
  }
  SdfEdgePoint onAb = closestOnEdge(pa, ab);
  SdfEdgePoint onBc = closestOnEdge(pb, bc);
  SdfEdgePoint onCa = closestOnEdge(pc, ca);
  SdfEdgePoint best = onAb;
  uint k = 0;
  if (onBc.squared < best.squared) {
    best = onBc;
    k = 1;
  }
  if (onCa.squared < best.squared) {
    best = onCa;
    k = 2;
  }
  precise float rest = 1.0 - best.share;
  closest.offset = best.offset;
  closest.squared = best.squared;
  closest.weights = float2(k == 0u ? best.share : (k == 1u ? rest : 0.0),
                           k == 0u ? 0.0 : (k == 1u ? best.share : rest));
  closest.feature = kSdfEdge + k;
  if (!(best.share > 0.0)) closest.feature = kSdfVertex + k;
  if (best.share >= 1.0) closest.feature = kSdfVertex + (k == 2u ? 0u : k + 1u);
  return closest;
}

struct SdfSide {
  float distance;  // negative inside
  float3 normal;   // outwards
};

// The sign is that of the offset along the pseudonormal of the feature (Baerentzen, Aanaes: "Signed
// distance computation using the angle weighted pseudonormal", IEEE TVCG 11(3), 2005): a face's
// normal, the sum of those beside an edge, the angle-weighted one of a vertex. The border of an
// open mesh has no sides: there the SDF's own sign decides.
//
// \param sdfInside  the sign of the SDF there
SdfSide sdfSideOf(Sdf sdf, SdfClosest closest, bool sdfInside) {
  SdfCorner3 corners = loadSdfCorners(sdf, closest.index);
  float3 none = float3(0.0, 0.0, 0.0);
  float3 face = directionOr(sdfFaceNormal(corners), none);
  float distance = squareRoot(closest.squared);
  precise float3 pseudonormal = face;
  bool border = false;
  if (closest.feature >= kSdfVertex) {
    uint row = sdfRecord(sdf, closest.index) + sdfPart(closest.feature);
    pseudonormal = unpackDirection(SDF_SURFACE[row].w);
  } else if (closest.feature != kSdfFace) {
    uint3 beside = sdfNeighbors(sdf, closest.index);
    uint k = sdfPart(closest.feature);
    uint other = k == 0u ? beside.x : (k == 1u ? beside.y : beside.z);
    border = other >= sdf.triangleCount;
    if (!border)
      pseudonormal = pseudonormal + directionOr(sdfFaceNormal(loadSdfCorners(sdf, other)), none);
  }
  bool inside = dot3(closest.offset, pseudonormal) < 0.0;
  if (border) inside = sdfInside;
  SdfSide side;
  side.distance = inside ? -distance : distance;
  side.normal = face;
  // A face's own normal has all digits, and on the surface the offset has none.
  if (closest.feature != kSdfFace && distance > 1e-4) {
    precise float3 outward = closest.offset * ((inside ? -1.0 : 1.0) / distance);
    side.normal = outward;
  }
  return side;
}

// Displacement of the surface in the frame [cell]; 0 for a surface that does not move.
// \param weights  of vertices 1 and 2
float3 sdfMotionAt(Sdf sdf, uint index, float2 weights) {
  precise float3 motion = float3(0.0, 0.0, 0.0);
  if (sdf.surfaceStride >= 7u && sdf.motionScale > 0.0) {
    uint row = sdfRecord(sdf, index) + 4u;
    precise float rest = 1.0 - weights.x - weights.y;
    precise float3 mixed = asfloat(SDF_SURFACE[row].xyz) * rest +
                           asfloat(SDF_SURFACE[row + 1].xyz) * weights.x +
                           asfloat(SDF_SURFACE[row + 2].xyz) * weights.y;
    precise float3 scaled = mixed * sdf.motionScale;
    if (isUsable(scaled)) motion = scaled;
  }
  return motion;
}

#endif
