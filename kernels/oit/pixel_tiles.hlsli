// Tiles of the screen that have hair or not.
#ifndef PELAGE_OIT_PIXEL_TILES_HLSLI
#define PELAGE_OIT_PIXEL_TILES_HLSLI

// Pixels along an edge, a power of two.
static const int kTileShift = 3;
static const uint kTileEdge = 1u << kTileShift;

#endif
