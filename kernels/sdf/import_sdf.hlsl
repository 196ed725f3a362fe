// Converts an engine's grid of distances to keys.
//
// Threads: one per node, in rows of 2^20.
// Reads:   g_importDistances
// Writes:  g_importKeys
// Run it in frames in which the engine has written distances and hair is in range.
//
// A key has a distance and no triangle: queries interpolate distances between the eight nodes
// around a point (sdf_query.hlsli).
//
// Invariant (tests/sdf): within the band the distance of a key is that of the engine, up to 2^-24
// of the band; a distance that is not usable counts as outside, at least the band away.
#include "layouts/import_sdf.hlsli"
#include "sdf_key.hlsli"
#include "../base/dispatch.hlsli"
#include "../base/quaternion.hlsli"

[numthreads(64, 1, 1)]
void import_sdf(uint3 thread : SV_DispatchThreadID) {
  uint node = indexOfThread(thread);
  if (node >= g_importNodeCount) return;
  float distance = g_importDistances[g_importFirst + node];
  uint key = kSdfUnset;
  if (isUsable(float3(distance, 0.0, 0.0))) {
    precise float cells = abs(distance) * g_importCellsAMeter;
    if (cells < g_importBand)
      key = sdfNearKey(cells, 0u, g_importBand, kImportTriangleBits);
    else
      key = sdfFarKey(cells, 0u, g_importBand, g_importFarRange, kImportTriangleBits);
    if (distance < 0.0) key = key | kSdfInside;
  }
  g_importKeys[g_importFirstKey + node] = key;
}
