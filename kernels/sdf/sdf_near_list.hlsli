// The words of g_sdfNear. The host writes the first kNearList before find_near_vertices: 0, 1, 1, 0.
#ifndef PELAGE_SDF_SDF_NEAR_LIST_HLSLI
#define PELAGE_SDF_SDF_NEAR_LIST_HLSLI

// Groups in x, y and z of collide_vertices with LISTED.
static const uint kNearArguments = 0;
static const uint kNearCount = 3;
static const uint kNearList = 4;
// Groups in x that share out the list.
static const uint kNearGroups = 32768;

#endif
