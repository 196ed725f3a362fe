// Distances of a collider's SDF, found through HairBuffers::sdfs. The including file defines
// FIELD_SLOTS, that buffer as uint4; FIELD_KEYS, Scene::sdfKeys(); and FIELD_SLOT_COUNT.
#ifndef VIEWER_FIELD_HLSLI
#define VIEWER_FIELD_HLSLI

#define SDF_KEYS FIELD_KEYS
// Not read: the trilinear distance needs no triangles.
#define SDF_SURFACE FIELD_SLOTS
#define SDF_CLOSEST_FEATURE 0
#include "sdf/sdf_query.hlsli"

static const uint kFieldElements = 5;  // uint4 of an Sdf
static const float kOriginError = 1e-3;

// SDFs that hair can reach, then capsules: the SDF of a grid is the slot with its counts and cell
// size, whose origin is whole meters from the grid's.
bool isFieldOf(uint4 origin, uint4 nodes, float4 gridOrigin, uint4 gridNodes) {
  if (nodes.x != gridNodes.x || nodes.y != gridNodes.y || nodes.z != gridNodes.z) return false;
  if (origin.w != asuint(gridOrigin.w)) return false;
  float3 apart = gridOrigin.xyz - asfloat(origin.xyz);
  float3 left = abs(apart - floor(apart + 0.5));
  return max(left.x, max(left.y, left.z)) < kOriginError;
}

// \param gridOrigin xyz of node 0 in world space [m], w cell size. \return whether hair can reach it.
bool findField(float4 gridOrigin, uint4 gridNodes, out Sdf sdf) {
  sdf = (Sdf)0;
  for (uint slot = 0; slot < FIELD_SLOT_COUNT; ++slot) {
    uint element = kFieldElements * slot;
    uint4 nodes = FIELD_SLOTS[element + 1u];
    if (!isFieldOf(FIELD_SLOTS[element], nodes, gridOrigin, gridNodes)) continue;
    uint4 counts = FIELD_SLOTS[element + 2u];
    float4 ranges = asfloat(FIELD_SLOTS[element + 3u]);
    sdf.origin = gridOrigin;
    sdf.nodes = nodes;
    sdf.triangleCount = counts.x;
    sdf.triangleBits = counts.y;
    sdf.band = ranges.x;
    sdf.farRange = ranges.y;
    return true;
  }
  return false;
}

// Signed distance of a point of world space [m], < 0 inside; 1e18 outside of the grid. Outside, no
// distance is larger than the band; deeper inside than the band it is that of the coarse nodes, which
// alone know more.
float fieldDistance(Sdf sdf, float3 world) {
  float3 p = (world - sdf.origin.xyz) / sdf.origin.w;
  SdfLocation location = sdfLocationOf(sdf, p, 0u);
  if (!location.inside) return 1e18;
  SdfCell cell = sdfCellOf(sdf, location, SDF_KEYS[location.node]);
  float distance = sdfTrilinear(cell.corners, location).distance;
  float4 least = min(cell.corners.low, cell.corners.high);
  if (min(min(least.x, least.y), min(least.z, least.w)) > -0.999 * sdf.band)
    return distance * sdf.origin.w;
  location = sdfLocationOf(sdf, p, sdfCoarseShift(sdf.band));
  cell = sdfCellOf(sdf, location, SDF_KEYS[location.node]);
  float coarse = sdfTrilinear(cell.corners, location).distance;
  return min(max(distance, -sdf.band), coarse) * sdf.origin.w;
}

#endif
