// Words of the counters of a per-pixel linked list.
#ifndef PELAGE_OIT_PPLL_COUNTERS_HLSLI
#define PELAGE_OIT_PPLL_COUNTERS_HLSLI

// The first four are the arguments of the indirect draw of tiles: vertices, instances, 0, 0.
static const uint kCounterTiles = 1u;
// Number of nodes that fragments requested; may exceed the capacity.
static const uint kCounterNodes = 4u;
static const uint kCounterWords = 8u;

#endif
