// Turns the counts of the rows into prefix sums, and writes the size of the mesh.
//
// Threads: one group of 128, each thread a run of rows.
// Reads:   g_marchingSdfs, g_isoRows
// Writes:  g_isoRows, g_isoCounts
//
// Invariant (tests/sdf): g_isoCounts has the sizes of the whole mesh, and a bit for each
// exceeded capacity.
#include "marching_cubes.hlsli"

static const uint kLanes = 128;

groupshared uint2 s_sums[kLanes];

[numthreads(128, 1, 1)]
void marching_cubes_offsets(uint lane : SV_GroupIndex) {
  Sdf sdf = marchingSdf();
  bool fits = fitsMarching(sdf);
  uint rows = 0;
  if (fits) rows = sdf.nodes.y * sdf.nodes.z;
  uint share = (rows + kLanes - 1u) / kLanes;
  uint begin = min(lane * share, rows);
  uint end = min(begin + share, rows);

  uint2 own = uint2(0u, 0u);
  for (uint i = begin; i < end; ++i) own += g_isoRows[i];
  s_sums[lane] = own;
  GroupMemoryBarrierWithGroupSync();
  for (uint range = 1; range < kLanes; range *= 2) {
    uint2 others = uint2(0u, 0u);
    if (lane >= range) others = s_sums[lane - range];
    GroupMemoryBarrierWithGroupSync();
    s_sums[lane] += others;
    GroupMemoryBarrierWithGroupSync();
  }

  uint2 before = s_sums[lane] - own;
  for (uint row = begin; row < end; ++row) {
    uint2 counts = g_isoRows[row];
    g_isoRows[row] = before;
    before += counts;
  }
  if (lane == 0u) {
    uint2 all = s_sums[kLanes - 1];
    MarchingCounts counts;
    counts.vertices = all.x;
    counts.triangles = all.y;
    counts.overflow = 0u;
    if (all.x > g_vertexCapacity) counts.overflow |= kTooManyVertices;
    if (all.y > g_triangleCapacity) counts.overflow |= kTooManyTriangles;
    if (!fits) counts.overflow |= kTooLarge;
    counts.pad0 = 0u;
    g_isoCounts[0] = counts;
  }
}
