// Distances of a collider's SDF, found through HairBuffers::sdfs. The including file defines
// FIELD_SLOTS, that buffer as uint4; FIELD_KEYS, Scene::sdfKeys(); and FIELD_SLOT_COUNT.
#ifndef VIEWER_FIELD_HLSLI
#define VIEWER_FIELD_HLSLI

#define SDF_KEYS FIELD_KEYS
// Not read: the trilinear distance needs no triangles.
#define SDF_SURFACE FIELD_SLOTS
#define SDF_CLOSEST_FEATURE 0
#define SDF_ELEMENTS FIELD_SLOTS
#include "sdf/load_sdf.hlsli"
#include "sdf/sdf_query.hlsli"

static const float kOriginError = 1e-3;

// Returns true if a slot has the SDF of a grid: with its counts and cell size, and an origin that
// is whole meters from the grid's.
bool isFieldOf(Sdf slot, float4 gridOrigin, uint4 gridNodes) {
  if (any(slot.nodes.xyz != gridNodes.xyz)) return false;
  if (asuint(slot.origin.w) != asuint(gridOrigin.w)) return false;
  float3 apart = gridOrigin.xyz - slot.origin.xyz;
  float3 left = abs(apart - floor(apart + 0.5));
  return max(left.x, max(left.y, left.z)) < kOriginError;
}

// Finds the SDF of a grid among those that hair can reach; behind them, the slots have capsules.
// \param gridOrigin xyz of node 0 in world space [m], w cell size. \return whether hair can reach
// it.
bool findField(float4 gridOrigin, uint4 gridNodes, out Sdf sdf) {
  sdf = (Sdf)0;
  for (uint slot = 0; slot < FIELD_SLOT_COUNT; ++slot) {
    sdf = loadSdf(slot);
    if (!isFieldOf(sdf, gridOrigin, gridNodes)) continue;
    sdf.origin = gridOrigin;
    return true;
  }
  return false;
}

// Returns the signed distance of a point in world space from the surface [m], < 0 inside; 1e18
// outside of the grid. Outside the surface it is the band at most; deeper inside than the band it
// is that of the coarse nodes, because the others store nothing deeper.
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
