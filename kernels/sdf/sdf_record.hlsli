// The surface records of the SDF that is being built, as queries read them.
#ifndef PELAGE_SDF_SDF_RECORD_HLSLI
#define PELAGE_SDF_SDF_RECORD_HLSLI

#include "sdf_triangle.hlsli"

#define SDF_SURFACE g_sdfSurface
#include "sdf_closest.hlsli"

Sdf sdfOfBuild() {
  Sdf sdf = (Sdf)0;
  sdf.nodes = g_sdfNodes;
  sdf.triangleCount = g_sdfTriangleCount;
  sdf.triangleBits = g_sdfTriangleBits;
  sdf.surface = g_contactSdfSurface;
  sdf.surfaceStride = g_sdfSurfaceStride;
  return sdf;
}

SdfClosest closestOf(float3 p, uint index) {
  return closestOnCorners(loadSdfCorners(sdfOfBuild(), index), p, index);
}

int3 nodeOfIndex(uint index) {
  uint row = index / g_sdfNodes.x;
  uint layer = row / g_sdfNodes.y;
  return int3(uint3(index - row * g_sdfNodes.x, row - layer * g_sdfNodes.y, layer));
}

bool isInGrid(int3 node) {
  return min(node.x, min(node.y, node.z)) >= 0 && node.x < int(g_sdfNodes.x) &&
         node.y < int(g_sdfNodes.y) && node.z < int(g_sdfNodes.z);
}

#endif
