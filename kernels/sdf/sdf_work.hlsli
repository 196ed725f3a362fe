// The words of g_sdfWork, and the layout of dispatches.
#ifndef PELAGE_SDF_SDF_WORK_HLSLI
#define PELAGE_SDF_SDF_WORK_HLSLI

#include "../base/dispatch.hlsli"
#include "layouts/generate_sdf.hlsli"

bool isIncremental() { return (g_buildFlags & kSdfIncremental) != 0u; }
bool hasThreeAxes() { return (g_buildFlags & kSdfThreeAxes) != 0u; }
// Only bricks cleared by this build get keys.
bool isOfBricks() { return isIncremental() && !hasThreeAxes(); }

// Groups of indirect dispatches, three words each and a spare one. The host writes the words up to
// kWorkKept before every build: groups in x are 0, in y the layout of the dispatch.
static const uint kWorkBig = 0;       // scatter_big_triangles
static const uint kWorkInterior = 4;  // fill_interior
static const uint kWorkMoved = 8;     // find_moved_triangles, scatter_triangles
static const uint kWorkSurface = 12;  // update_surface
static const uint kWorkRows = 16;     // finalize_sdf
static const uint kWorkClear = 20;    // clear_sdf
static const uint kWorkColumns = 24;  // count_sdf_columns
// Counters.
static const uint kWorkBigCount = 32;
static const uint kWorkInteriorCount = 33;
static const uint kWorkMovedPoints = 34;
static const uint kWorkMovedTriangles = 35;
static const uint kWorkBricks = 36;
static const uint kWorkKept = 40;
// Stamp of the last build in which a point moved.
static const uint kWorkLastMotion = 40;
// Triangles that scatter_triangles leaves to scatter_big_triangles.
static const uint kWorkBigList = 44;

// Elements of a group: of scatter_triangles and find_moved_triangles, of update_surface, and of
// count_sdf_columns.
static const uint kScatterLanes = 16;
static const uint kScatteredTriangles = 64 / kScatterLanes;
static const uint kSurfaceTriangles = 16;
static const uint kSummedColumns = 16;

// Groups in x and y that share the big triangles: each group in y takes its part of a triangle.
static const uint kBigGroups = 4096;
static const uint kMostShares = 64;
// Minimum bricks of 4^3 nodes per group.
static const uint kBricksAShare = 8;

#endif
