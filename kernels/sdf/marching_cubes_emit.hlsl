// Writes the vertices and triangles of an iso surface.
//
// Threads: one a node, in groups of 64 a row; dispatch nx x ny x nz.
// Reads:   g_marchingFields, g_marchingKeys, g_isoRows, g_isoNodes
// Writes:  g_isoVertices, g_isoIndices
//
// Marching cubes, see marching_cubes_cell.hlsli. Vertices are where the level is 0 between two nodes,
// linearly; normals are the differences of distances between neighbours, interpolated the same way.
// Neighbours that the build did not reach have no distance: differences leave them out.
//
// What has no room is not written; a triangle with such a vertex is one of index 0 alone.
//
// Invariant (tests/kernel): every edge of a surface that does not leave the grid has exactly two
// triangles, in opposite directions; normals point to where the distance grows; nothing is written
// past the capacities.
#include "marching_cubes.hlsli"

// Slope of the distance at a node along an axis, from the neighbours that have one.
float slopeAlong(SdfField field, uint3 node, uint axis) {
  uint3 direction = stepAlong(axis);
  uint3 places = direction * node;
  uint3 sizes = direction * field.nodes.xyz;
  uint place = places.x + places.y + places.z;
  uint size = sizes.x + sizes.y + sizes.z;
  uint key = keyOf(field, node);
  uint next = kSdfUnset;
  uint last = kSdfUnset;
  if (place + 1u < size) next = keyOf(field, node + direction);
  if (place > 0u) last = keyOf(field, node - direction);
  bool hasNext = sdfIsSet(next) || !sdfIsSet(key);
  bool hasLast = sdfIsSet(last) || !sdfIsSet(key);
  precise float high = levelOf(field, hasNext ? next : key);
  precise float low = levelOf(field, hasLast ? last : key);
  precise float slope = high - low;
  if (hasNext && hasLast) slope = slope * 0.5;
  return slope;
}

float3 slopeAt(SdfField field, uint3 node) {
  return float3(slopeAlong(field, node, 0u), slopeAlong(field, node, 1u),
                slopeAlong(field, node, 2u));
}

IsoVertex vertexOn(SdfField field, uint3 node, uint axis) {
  uint3 direction = stepAlong(axis);
  precise float from = levelOf(field, keyOf(field, node));
  precise float to = levelOf(field, keyOf(field, node + direction));
  // One is below 0 and the other is not, so they differ.
  precise float share = min(max(from / (from - to), 0.0), 1.0);
  precise float3 place = float3(node) + float3(direction) * share;
  precise float3 position = field.origin.xyz + place * field.origin.w;
  float3 slope = slopeAt(field, node);
  precise float3 mixed = slope + (slopeAt(field, node + direction) - slope) * share;
  IsoVertex vertex;
  vertex.position = float4(position, 1.0);
  vertex.normal = float4(directionOr(mixed, float3(direction) * (from < to ? 1.0 : -1.0)), 0.0);
  return vertex;
}

void writeVertices(SdfField field, uint3 node, uint word) {
  for (uint axis = 0; axis < 3; ++axis) {
    if ((axesOf(word) & (1u << axis)) == 0u) continue;
    uint number = vertexNumber(field, node, axis);
    if (number < g_vertexCapacity) g_isoVertices[number] = vertexOn(field, node, axis);
  }
}

// Number of the vertex on an edge of a cell.
uint vertexOnEdge(SdfField field, uint3 node, uint edge) {
  return vertexNumber(field, node + startOfEdge(edge), edge >> 2);
}

void writeTriangles(SdfField field, uint3 node, uint word) {
  // The next cell of the row says whether this one has any.
  uint next = g_isoNodes[indexOf(field, node) + 1u];
  if (trianglesBefore(next) == trianglesBefore(word)) return;
  uint corners = 0u;
  for (uint corner = 0; corner < 8; ++corner) {
    uint3 side = uint3(corner & 1u, (corner >> 1) & 1u, corner >> 2);
    if (isBelow(field, node + side)) corners |= 1u << corner;
  }
  uint crossed = crossedEdges(corners);
  uint number = g_isoRows[rowOf(field, node)].y + trianglesBefore(word);
  while (crossed != 0u) {
    CellLoop cell = loopOf(crossed, corners);
    crossed &= ~edgesOfLoop(cell);
    uint apex = apexOfLoop(cell);
    uint a = vertexOnEdge(field, node, edgeOfLoop(cell, apex));
    uint b = vertexOnEdge(field, node, edgeOfLoop(cell, apex + 1u));
    for (uint i = 2; i < cell.count; ++i) {
      uint c = vertexOnEdge(field, node, edgeOfLoop(cell, apex + i));
      bool whole = max(a, max(b, c)) < g_vertexCapacity;
      if (number < g_triangleCapacity) {
        // Loops run counter-clockwise as seen from outside.
        g_isoIndices[3u * number] = whole ? a : 0u;
        g_isoIndices[3u * number + 1u] = whole ? b : 0u;
        g_isoIndices[3u * number + 2u] = whole ? c : 0u;
      }
      number += 1u;
      b = c;
    }
  }
}

[numthreads(64, 1, 1)]
void marching_cubes_emit(uint3 node : SV_DispatchThreadID) {
  SdfField field = marchingField();
  uint3 nodes = field.nodes.xyz;
  if (node.x >= nodes.x || node.y >= nodes.y || node.z >= nodes.z) return;
  if (!fitsMarching(field) || !hasSurface(field)) return;
  uint word = g_isoNodes[indexOf(field, node)];
  writeVertices(field, node, word);
  if (node.x + 1u < nodes.x && node.y + 1u < nodes.y && node.z + 1u < nodes.z)
    writeTriangles(field, node, word);
}
