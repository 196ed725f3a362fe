// Bricks of 4^3 nodes, which an incremental build clears if something moved there.
#ifndef PELAGE_SDF_SDF_BRICKS_HLSLI
#define PELAGE_SDF_SDF_BRICKS_HLSLI

#include "sdf_triangle.hlsli"

uint3 bricksOfGrid() { return (g_sdfNodes.xyz + 3u) / 4u; }

uint brickIndex(uint3 brick) {
  uint3 bricks = bricksOfGrid();
  return brick.x + bricks.x * (brick.y + bricks.y * brick.z);
}

// First element of the points' marks.
uint pointMarks() {
  uint3 bricks = bricksOfGrid();
  return bricks.x * bricks.y * bricks.z;
}

bool isMarkedNode(int3 node) { return g_sdfMarks[brickIndex(uint3(node) / 4u)] == g_buildStamp; }

// Bricks with nodes of a range that is not empty.
struct BrickRange {
  uint3 first;
  uint3 extent;
};

BrickRange bricksOf(NodeRange range) {
  BrickRange bricks;
  bricks.first = uint3(range.low) / 4u;
  bricks.extent = uint3(range.high) / 4u - bricks.first + 1u;
  return bricks;
}

uint3 brickOf(BrickRange bricks, uint i) {
  uint row = i / bricks.extent.x;
  uint layer = row / bricks.extent.y;
  return bricks.first + uint3(i - row * bricks.extent.x, row - layer * bricks.extent.y, layer);
}

// Returns true if this build cleared one of the lane's bricks.
bool touchesMarkedBricks(NodeRange range, uint lane, uint lanes) {
  BrickRange bricks = bricksOf(range);
  uint count = bricks.extent.x * bricks.extent.y * bricks.extent.z;
  bool overlaps = false;
  for (uint i = lane; i < count && !overlaps; i += lanes)
    overlaps = g_sdfMarks[brickIndex(brickOf(bricks, i))] == g_buildStamp;
  return overlaps;
}

// Half the diagonal of a brick's nodes, sqrt(27) / 2, and a little more.
static const float kBrickRadius = 2.6;

// Returns false if no node of the brick is within the band of the triangle's plane.
//
// \param inverseLength  of the normal
bool isNearPlane(uint3 brick, TriangleShape shape, float inverseLength) {
  if (!(shape.inverseNormal > 0.0)) return true;
  precise float3 arm = float3(brick * 4u) + 1.5 - shape.a;
  precise float height = abs(dot3(arm, shape.normal)) * inverseLength;
  // The normal of a giant triangle is off by its rounding.
  precise float furthest = abs(arm.x) + abs(arm.y) + abs(arm.z);
  precise float limit = g_sdfBand + kBrickRadius + 1e-3 * furthest;
  return height <= limit;
}

#endif
