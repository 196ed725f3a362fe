// Which triangles lead out of meshes whose parts overlap.
#ifndef PELAGE_SDF_SDF_WAY_OUT_HLSLI
#define PELAGE_SDF_SDF_WAY_OUT_HLSLI

#define SDF_SURFACE g_sdfSurface

#include "sdf_closest.hlsli"
#include "sdf_flood.hlsli"

SdfField fieldOfBuild() {
  SdfField field = (SdfField)0;
  field.nodes = g_fieldNodes;
  field.triangleCount = g_fieldTriangleCount;
  field.triangleBits = g_fieldTriangleBits;
  field.surface = g_fieldSurface;
  field.surfaceStride = g_fieldSurfaceStride;
  return field;
}

SdfClosest closestOf(float3 p, uint index) {
  return closestOnCorners(loadSdfCorners(fieldOfBuild(), index), p, index);
}

// On the surface itself there is no telling.
static const float kClearlyFront = 1e-3;

// Whether a node sees the front of its nearest triangle.
//
// \param node  index without g_fieldNodes.w
bool isAtFront(uint node, uint key) {
  uint index = sdfTriangle(key, g_fieldTriangleBits);
  if (index >= g_fieldTriangleCount) return false;
  SdfClosest closest = closestOf(float3(nodeOfIndex(node)), index);
  return sdfSideOf(fieldOfBuild(), closest, true).distance > kClearlyFront;
}

bool isOutside(float3 p) {
  int3 node = int3(floor(p + 0.5));
  return !isInGrid(node) || !sdfIsInside(g_sdfKeys[g_fieldNodes.w + nodeIndex(node)]);
}

// Whether it is outside behind the point of the triangle that is closest to an inside node: at the
// node half a cell or one further. Signs do not change while the flood lasts.
bool leadsOut(float3 p, uint index) {
  SdfClosest closest = closestOf(p, index);
  precise float distance = squareRoot(closest.squared);
  precise float3 foot = p - closest.offset;
  precise float3 way = closest.offset * (distance > kClearlyFront ? -1.0 / distance : 0.0);
  return isOutside(foot + way * 0.5) || isOutside(foot + way);
}

// As nearer(), but of triangles that lead out.
Nearest nearerOut(Nearest now, float3 p, uint index) {
  Nearest result = nearer(now, p, index);
  if (result.index != now.index && !leadsOut(p, index)) return now;
  return result;
}

#endif
