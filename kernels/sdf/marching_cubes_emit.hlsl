// Writes the vertices and triangles of an iso surface.
//
// Threads: one per node, in groups of 64 per row; dispatch nx x ny x nz.
// Reads:   g_marchingSdfs, g_marchingKeys, g_isoRows, g_isoNodes
// Writes:  g_isoVertices, g_isoIndices
//
// Marching cubes, see marching_cubes_cell.hlsli. Vertices are at the linearly interpolated zero
// between two nodes; normals are the differences of distances between neighbors, interpolated the
// same way. Neighbors that the build did not reach have no distance: differences leave them out.
//
// Vertices and triangles beyond the capacities are not written; a triangle with such a vertex has
// only index 0.
//
// Invariant (tests/sdf): every edge of a surface that does not leave the grid has exactly two
// triangles, in opposite directions; normals point to where the distance grows; nothing is written
// past the capacities.
#include "marching_cubes.hlsli"

// Slope of the distance at a node along an axis, from the neighbors that have one.
float slopeAlong(Sdf sdf, uint3 node, uint axis) {
  uint3 direction = stepAlong(axis);
  uint3 points = direction * node;
  uint3 sizes = direction * sdf.nodes.xyz;
  uint index = points.x + points.y + points.z;
  uint size = sizes.x + sizes.y + sizes.z;
  uint key = keyOf(sdf, node);
  uint next = kSdfUnset;
  uint last = kSdfUnset;
  if (index + 1u < size) next = keyOf(sdf, node + direction);
  if (index > 0u) last = keyOf(sdf, node - direction);
  bool hasNext = sdfIsSet(next) || !sdfIsSet(key);
  bool hasLast = sdfIsSet(last) || !sdfIsSet(key);
  precise float high = levelOf(sdf, hasNext ? next : key);
  precise float low = levelOf(sdf, hasLast ? last : key);
  precise float slope = high - low;
  if (hasNext && hasLast) slope = slope * 0.5;
  return slope;
}

float3 slopeAt(Sdf sdf, uint3 node) {
  return float3(slopeAlong(sdf, node, 0u), slopeAlong(sdf, node, 1u), slopeAlong(sdf, node, 2u));
}

IsoVertex vertexOn(Sdf sdf, uint3 node, uint axis) {
  uint3 direction = stepAlong(axis);
  precise float from = levelOf(sdf, keyOf(sdf, node));
  precise float to = levelOf(sdf, keyOf(sdf, node + direction));
  // One is below 0 and the other is not, so they differ.
  precise float share = min(max(from / (from - to), 0.0), 1.0);
  precise float3 index = float3(node) + float3(direction) * share;
  precise float3 position = sdf.origin.xyz + index * sdf.origin.w;
  float3 slope = slopeAt(sdf, node);
  precise float3 mixed = slope + (slopeAt(sdf, node + direction) - slope) * share;
  IsoVertex vertex;
  vertex.position = float4(position, 1.0);
  vertex.normal = float4(directionOr(mixed, float3(direction) * (from < to ? 1.0 : -1.0)), 0.0);
  return vertex;
}

void writeVertices(Sdf sdf, uint3 node, uint word) {
  for (uint axis = 0; axis < 3; ++axis) {
    if ((axesOf(word) & (1u << axis)) == 0u) continue;
    uint number = vertexNumber(sdf, node, axis);
    if (number < g_vertexCapacity) g_isoVertices[number] = vertexOn(sdf, node, axis);
  }
}

// Index of the vertex on an edge of a cell.
uint vertexOnEdge(Sdf sdf, uint3 node, uint edge) {
  return vertexNumber(sdf, node + startOfEdge(edge), edge >> 2);
}

void writeTriangles(Sdf sdf, uint3 node, uint word) {
  // The next cell of the row determines whether this one has triangles.
  uint next = g_isoNodes[indexOf(sdf, node) + 1u];
  if (trianglesBefore(next) == trianglesBefore(word)) return;
  uint corners = 0u;
  for (uint corner = 0; corner < 8; ++corner) {
    uint3 side = uint3(corner & 1u, (corner >> 1) & 1u, corner >> 2);
    if (isBelow(sdf, node + side)) corners |= 1u << corner;
  }
  uint crossed = crossedEdges(corners);
  uint number = g_isoRows[rowOf(sdf, node)].y + trianglesBefore(word);
  while (crossed != 0u) {
    CellLoop cell = loopOf(crossed, corners);
    crossed &= ~edgesOfLoop(cell);
    uint apex = apexOfLoop(cell);
    uint a = vertexOnEdge(sdf, node, edgeOfLoop(cell, apex));
    uint b = vertexOnEdge(sdf, node, edgeOfLoop(cell, apex + 1u));
    for (uint i = 2; i < cell.count; ++i) {
      uint c = vertexOnEdge(sdf, node, edgeOfLoop(cell, apex + i));
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
  Sdf sdf = marchingSdf();
  uint3 nodes = sdf.nodes.xyz;
  if (node.x >= nodes.x || node.y >= nodes.y || node.z >= nodes.z) return;
  if (!fitsMarching(sdf) || !hasSurface(sdf)) return;
  uint word = g_isoNodes[indexOf(sdf, node)];
  writeVertices(sdf, node, word);
  if (node.x + 1u < nodes.x && node.y + 1u < nodes.y && node.z + 1u < nodes.z)
    writeTriangles(sdf, node, word);
}
