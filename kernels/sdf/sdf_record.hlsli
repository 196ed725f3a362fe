// The surface records of the field that is built, as queries read them.
#ifndef PELAGE_SDF_SDF_RECORD_HLSLI
#define PELAGE_SDF_SDF_RECORD_HLSLI

#include "sdf_triangle.hlsli"

#define SDF_SURFACE g_sdfSurface
#include "sdf_closest.hlsli"

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

int3 nodeOfIndex(uint index) {
  uint row = index / g_fieldNodes.x;
  uint layer = row / g_fieldNodes.y;
  return int3(uint3(index - row * g_fieldNodes.x, row - layer * g_fieldNodes.y, layer));
}

bool isInGrid(int3 node) {
  return min(node.x, min(node.y, node.z)) >= 0 && node.x < int(g_fieldNodes.x) &&
         node.y < int(g_fieldNodes.y) && node.z < int(g_fieldNodes.z);
}

#endif
