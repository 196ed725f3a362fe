// The words of g_sdfWork, and how dispatches are laid out.
#ifndef PELAGE_SDF_SDF_WORK_HLSLI
#define PELAGE_SDF_SDF_WORK_HLSLI

#include "../layouts/generate_sdf.hlsli"

bool isIncremental() { return (g_buildFlags & kSdfIncremental) != 0u; }
bool hasThreeAxes() { return (g_buildFlags & kSdfThreeAxes) != 0u; }
// Only bricks that this build has cleared get keys.
bool isOfBricks() { return isIncremental() && !hasThreeAxes(); }

// Groups of indirect dispatches, three words each and a spare one. The host writes those up to
// kWorkKept before every build: groups in x are 0, in y as the dispatch is laid out.
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
static const uint kWorkMovedPlaces = 34;
static const uint kWorkMovedTriangles = 35;
static const uint kWorkBricks = 36;
static const uint kWorkKept = 40;
// Stamp of the last build in which a place moved.
static const uint kWorkLastMotion = 40;
// Triangles that scatter_triangles leaves to scatter_big_triangles.
static const uint kWorkBigList = 44;

// Dispatches of one group a work item have rows of this many groups.
static const uint kGroupsARow = 32768;
uint indexOfGroup(uint3 group) { return group.y * kGroupsARow + group.x; }

// Groups in x and y that share out the big triangles: each group in y takes its share of a
// triangle.
static const uint kBigGroups = 4096;
static const uint kMostShares = 64;
// Bricks of 4^3 nodes that a group should have at least.
static const uint kBricksAShare = 8;

#endif
