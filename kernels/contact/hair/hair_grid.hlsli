// Position of a vertex in the grid, and its weights.
#ifndef PELAGE_CONTACT_HAIR_HAIR_GRID_HLSLI
#define PELAGE_CONTACT_HAIR_HAIR_GRID_HLSLI

#include "../../base/dispatch.hlsli"
#include "../../base/quaternion.hlsli"
#include "../layouts/hair_grid.hlsli"

// Words per node, as a power of two.
uint channelShift() { return g_gridFriction != 0u ? 2u : 0u; }

struct GridVertex {
  bool inside;      // of the grid, with a mass and with finite positions
  float mass;       // [m]
  float3 velocity;  // relative to g_gridVelocity, limited [m/s]
  uint3 base;       // the lowest of the eight nodes around it
  float3 share;     // of the distance to the next node, 0..1
};

// A vertex at its predicted position at the end of the step, with constant velocity.
GridVertex gridVertex(uint index) {
  GridVertex vertex;
  vertex.inside = false;
  vertex.mass = 0.0;
  vertex.velocity = float3(0.0, 0.0, 0.0);
  vertex.base = uint3(0, 0, 0);
  vertex.share = float3(0.0, 0.0, 0.0);
  if (g_gridSize < 2 || g_gridSize > kMaxGridSize) return vertex;

  float4 before = g_gridBefore[index];
  precise float3 position = g_gridPositions[index].xyz;
  if (!(before.w > 0.0) || !isUsable(before) || !isUsable(position)) return vertex;
  vertex.mass = before.w;
  if (g_inverseStep > 0.0) {
    float limit = g_gridVelocity.w;
    precise float3 velocity = (position - before.xyz) * g_inverseStep - g_gridVelocity.xyz;
    precise float3 limited = min(max(velocity, -limit), limit);
    vertex.velocity = limited;
    position = position + (limited + g_gridVelocity.xyz) * g_lookAhead;
  }
  precise float3 cellPosition = (position - g_gridOrigin.xyz) / g_gridOrigin.w;
  precise float3 lowest = floor(cellPosition);
  // Also rejects what is too large for an integer.
  float last = float(g_gridSize - 2);
  if (min(lowest.x, min(lowest.y, lowest.z)) < 0.0) return vertex;
  if (max(lowest.x, max(lowest.y, lowest.z)) > last) return vertex;
  precise float3 share = cellPosition - lowest;
  vertex.inside = true;
  vertex.base = uint3(lowest);
  vertex.share = share;
  return vertex;
}

// Corner 0..7: bit 0 is x.
uint3 cornerOf(uint corner) { return uint3(corner & 1u, (corner >> 1) & 1u, corner >> 2); }

uint nodeOf(GridVertex vertex, uint corner) {
  uint3 node = vertex.base + cornerOf(corner);
  return (node.z * g_gridSize + node.y) * g_gridSize + node.x;
}

// Factors of the trilinear weight along the axes.
float3 weightsOf(GridVertex vertex, uint corner) {
  uint3 side = cornerOf(corner);
  precise float3 low = float3(1.0, 1.0, 1.0) - vertex.share;
  precise float3 high = vertex.share;
  return float3(side.x > 0u ? high.x : low.x, side.y > 0u ? high.y : low.y,
                side.z > 0u ? high.z : low.z);
}

#endif
