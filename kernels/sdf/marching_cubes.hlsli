// Which nodes have which vertices and triangles of an iso surface.
//
// A vertex lies on an edge between two nodes, and belongs to the lower one: a node has at most
// three. A cell belongs to its lowest corner. Both are numbered along x, row after row, so that the
// mesh is the same whatever the order of the threads.
//
// A node's word: bits 0 - 2 the axes on which it has a vertex; 3 - 16 the row's vertices before it;
// 17 - 31 the row's triangles before its cell.
#ifndef PELAGE_SDF_MARCHING_CUBES_HLSLI
#define PELAGE_SDF_MARCHING_CUBES_HLSLI

#include "../common/quaternion.hlsli"
#include "../layouts/sdf_marching_cubes.hlsli"
#include "marching_cubes_cell.hlsli"
#include "sdf_key.hlsli"

// Nodes in a row, so that the counts above fit: 3 vertices a node, 5 triangles a cell.
static const uint kMaxMarchingRow = 5460;
// Nodes of a field, so that 15 indices a cell fit a uint.
static const uint kMaxMarchingNodes = 0x10000000u;

static const uint kTooManyVertices = 1u;
static const uint kTooManyTriangles = 2u;
static const uint kTooLarge = 4u;

// The field at hand; one without nodes when there is none.
SdfField marchingField() {
  SdfField field = (SdfField)0;
  if (g_marchingField < g_fieldCapacity) field = g_marchingFields[g_marchingField];
  return field;
}

bool fitsMarching(SdfField field) {
  uint3 nodes = field.nodes.xyz;
  if (nodes.x > kMaxMarchingRow || nodes.y > 0xffffu || nodes.z > 0xffffu) return false;
  uint rows = nodes.y * nodes.z;
  if (rows > g_rowCapacity || rows > kMaxMarchingNodes / max(nodes.x, 1u)) return false;
  uint count = nodes.x * rows;
  return count <= g_nodeCapacity && field.nodes.w <= g_keyCapacity &&
         count <= g_keyCapacity - field.nodes.w;
}

// A field without cells, or a level that the band does not reach, has no surface.
bool hasSurface(SdfField field) {
  uint3 nodes = field.nodes.xyz;
  return min(nodes.x, min(nodes.y, nodes.z)) >= 2u && abs(g_isoLevel) < field.band;
}

uint rowOf(SdfField field, uint3 node) { return node.z * field.nodes.y + node.y; }

// Of a node among the nodes of its field.
uint indexOf(SdfField field, uint3 node) { return rowOf(field, node) * field.nodes.x + node.x; }

uint keyOf(SdfField field, uint3 node) {
  return g_marchingKeys[field.nodes.w + indexOf(field, node)];
}

// Distance over the iso level [cell]. Nodes that the build did not reach are the band away, on the
// side that they are on, so that the edge of the band is no surface.
float levelOf(SdfField field, uint key) {
  precise float level = sdfDistance(key, field.band, field.farRange, field.triangleBits) - g_isoLevel;
  return level;
}

bool isBelow(SdfField field, uint3 node) { return levelOf(field, keyOf(field, node)) < 0.0; }

uint3 stepAlong(uint axis) {
  return uint3(axis == 0u ? 1u : 0u, axis == 1u ? 1u : 0u, axis == 2u ? 1u : 0u);
}

uint packNode(uint axes, uint vertices, uint triangles) {
  return axes | (vertices << 3) | (triangles << 17);
}
uint axesOf(uint word) { return word & 7u; }
uint verticesBefore(uint word) { return (word >> 3) & 0x3fffu; }
uint trianglesBefore(uint word) { return word >> 17; }

// Number of a vertex among those of the mesh.
uint vertexNumber(SdfField field, uint3 node, uint axis) {
  uint word = g_isoNodes[indexOf(field, node)];
  uint lower = axesOf(word) & ((1u << axis) - 1u);
  return g_isoRows[rowOf(field, node)].x + verticesBefore(word) + (lower & 1u) + (lower >> 1);
}

#endif
