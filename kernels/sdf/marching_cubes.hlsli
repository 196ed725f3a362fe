// The numbering of vertices and triangles of an iso surface by nodes.
//
// A vertex lies on an edge between two nodes, and belongs to the lower one: a node has at most
// three. A cell belongs to its lowest corner. Both are numbered along x, row after row, so that the
// mesh is the same whatever the order of the threads.
//
// A node's word: bits 0 - 2 the axes on which it has a vertex; 3 - 16 the row's vertices before it;
// 17 - 31 the row's triangles before its cell.
#ifndef PELAGE_SDF_MARCHING_CUBES_HLSLI
#define PELAGE_SDF_MARCHING_CUBES_HLSLI

#include "../base/quaternion.hlsli"
#include "layouts/sdf_marching_cubes.hlsli"
#include "marching_cubes_cell.hlsli"
#include "sdf_key.hlsli"

// Nodes in a row, so that the counts above fit: 3 vertices a node, 5 triangles a cell.
static const uint kMaxMarchingRow = 5460;
// Nodes along the other axes, which are thread groups.
static const uint kMaxMarchingAxis = 0xffffu;
// Nodes of an SDF, so that 15 indices a cell fit a uint.
static const uint kMaxMarchingNodes = 0x10000000u;

static const uint kTooManyVertices = 1u;
static const uint kTooManyTriangles = 2u;
static const uint kTooLarge = 4u;

// The current SDF; one without nodes if there is none.
Sdf marchingSdf() {
  Sdf sdf = (Sdf)0;
  if (g_marchingSdf < g_sdfCapacity) sdf = g_marchingSdfs[g_marchingSdf];
  return sdf;
}

bool fitsMarching(Sdf sdf) {
  uint3 nodes = sdf.nodes.xyz;
  if (nodes.x > kMaxMarchingRow || nodes.y > kMaxMarchingAxis || nodes.z > kMaxMarchingAxis)
    return false;
  uint rows = nodes.y * nodes.z;
  if (rows > g_rowCapacity || rows > kMaxMarchingNodes / max(nodes.x, 1u)) return false;
  uint count = nodes.x * rows;
  return count <= g_nodeCapacity && sdf.nodes.w <= g_keyCapacity &&
         count <= g_keyCapacity - sdf.nodes.w;
}

// An SDF without cells has no surface, and neither has a level outside the band.
bool hasSurface(Sdf sdf) {
  uint3 nodes = sdf.nodes.xyz;
  return min(nodes.x, min(nodes.y, nodes.z)) >= 2u && abs(g_isoLevel) < sdf.band;
}

uint rowOf(Sdf sdf, uint3 node) { return node.z * sdf.nodes.y + node.y; }

// Index of a node among the nodes of its SDF.
uint indexOf(Sdf sdf, uint3 node) { return rowOf(sdf, node) * sdf.nodes.x + node.x; }

uint keyOf(Sdf sdf, uint3 node) { return g_marchingKeys[sdf.nodes.w + indexOf(sdf, node)]; }

// Distance over the iso level [cell]. Nodes that the build did not reach are the band away, on
// their side, so that the edge of the band is no surface.
float levelOf(Sdf sdf, uint key) {
  precise float level = sdfDistance(key, sdf.band, sdf.farRange, sdf.triangleBits) - g_isoLevel;
  return level;
}

bool isBelow(Sdf sdf, uint3 node) { return levelOf(sdf, keyOf(sdf, node)) < 0.0; }

uint3 stepAlong(uint axis) {
  return uint3(axis == 0u ? 1u : 0u, axis == 1u ? 1u : 0u, axis == 2u ? 1u : 0u);
}

uint packNode(uint axes, uint vertices, uint triangles) {
  return axes | (vertices << 3) | (triangles << 17);
}
uint axesOf(uint word) { return word & 7u; }
uint verticesBefore(uint word) { return (word >> 3) & 0x3fffu; }
uint trianglesBefore(uint word) { return word >> 17; }

// Index of a vertex among those of the mesh.
uint vertexNumber(Sdf sdf, uint3 node, uint axis) {
  uint word = g_isoNodes[indexOf(sdf, node)];
  uint lower = axesOf(word) & ((1u << axis) - 1u);
  return g_isoRows[rowOf(sdf, node)].x + verticesBefore(word) + (lower & 1u) + (lower >> 1);
}

#endif
