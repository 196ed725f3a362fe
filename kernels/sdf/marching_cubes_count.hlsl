// Counts the vertices and triangles that begin in each row of nodes, and numbers them in the row.
//
// Threads: a group of 64 per row, which it walks in steps of 64 nodes; dispatch 64 x ny x nz.
// Reads:   g_marchingSdfs, g_marchingKeys
// Writes:  g_isoRows, g_isoNodes
//
// Invariant (tests/sdf): the counts are those of marching cubes with a table in double precision,
// and do not depend on the order of the threads.
#include "marching_cubes.hlsli"

static const uint kLanes = 64;

// Vertices in the lower half, triangles in the upper one, summed up to each lane.
groupshared uint s_sums[kLanes];

// The columns of s_below, and one after the last.
groupshared uint s_below[kLanes + 1];

uint countAxes(uint axes) { return (axes & 1u) + ((axes >> 1) & 1u) + (axes >> 2); }

// Bit 2 j is set when node + (0, j & 1, j >> 1) is below the level; nodes outside are not.
uint columnAt(Sdf sdf, uint3 node) {
  uint column = 0;
  for (uint j = 0; j < 4; ++j) {
    uint3 index = node + uint3(0u, j & 1u, j >> 1);
    if (index.x < sdf.nodes.x && index.y < sdf.nodes.y && index.z < sdf.nodes.z &&
        isBelow(sdf, index))
      column |= 1u << (2u * j);
  }
  return column;
}

[numthreads(64, 1, 1)]
void marching_cubes_count(uint3 group : SV_GroupID, uint lane : SV_GroupIndex) {
  Sdf sdf = marchingSdf();
  uint3 nodes = sdf.nodes.xyz;
  // The same for the whole group, as its barriers need.
  if (!fitsMarching(sdf) || group.y >= nodes.y || group.z >= nodes.z) return;
  bool surface = hasSurface(sdf);

  uint row = 0;  // vertices and triangles of the row so far, as in s_sums
  for (uint begin = 0; begin < nodes.x; begin += kLanes) {
    uint3 node = uint3(begin + lane, group.y, group.z);
    if (surface) {
      s_below[lane] = columnAt(sdf, node);
      if (lane == kLanes - 1) s_below[kLanes] = columnAt(sdf, node + uint3(1u, 0u, 0u));
    }
    GroupMemoryBarrierWithGroupSync();
    uint axes = 0;
    uint triangles = 0;
    if (surface && node.x < nodes.x) {
      uint corners = s_below[lane] | (s_below[lane + 1] << 1);
      uint others = (corners & 1u) * 255u ^ corners;  // on the other side than the node
      bool3 inner = bool3(node.x + 1u < nodes.x, node.y + 1u < nodes.y, node.z + 1u < nodes.z);
      if (inner.x && isInside(others, 1u)) axes |= 1u;
      if (inner.y && isInside(others, 2u)) axes |= 2u;
      if (inner.z && isInside(others, 4u)) axes |= 4u;
      if (inner.x && inner.y && inner.z) triangles = trianglesOfCell(corners);
    }
    uint counts = countAxes(axes) | (triangles << 16);
    s_sums[lane] = counts;
    GroupMemoryBarrierWithGroupSync();
    for (uint range = 1; range < kLanes; range *= 2) {
      uint others = 0;
      if (lane >= range) others = s_sums[lane - range];
      GroupMemoryBarrierWithGroupSync();
      s_sums[lane] += others;
      GroupMemoryBarrierWithGroupSync();
    }
    uint before = row + s_sums[lane] - counts;
    if (node.x < nodes.x)
      g_isoNodes[indexOf(sdf, node)] = packNode(axes, before & 0xffffu, before >> 16);
    row += s_sums[kLanes - 1];
    GroupMemoryBarrierWithGroupSync();
  }
  if (lane == 0u) g_isoRows[group.z * nodes.y + group.y] = uint2(row & 0xffffu, row >> 16);
}
