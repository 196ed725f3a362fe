// Made by marching_cubes_table.py, which says how.
#ifndef PELAGE_SDF_MARCHING_CUBES_TABLE_HLSLI
#define PELAGE_SDF_MARCHING_CUBES_TABLE_HLSLI

// [2 e + s], s = 1 when the start of edge e is inside and its end is not, 0 the other way
// around: what follows on the face on which e leads inside. Bits 0 - 11 the three edges,
// 12 - 17 the two corners between them.
static const uint kAfterEdge[24] = {0x25829u, 0x1a514u, 0x01405u, 0x3eb3au, 0x37637u, 0x08908u,
                                    0x13a1bu, 0x2c726u, 0x0b051u, 0x34a68u, 0x2f97bu, 0x10140u,
                                    0x0284au, 0x3d372u, 0x26263u, 0x19b59u, 0x164a6u, 0x29290u,
                                    0x04082u, 0x3b7b5u, 0x1f1b3u, 0x20684u, 0x0d597u, 0x323a1u};

#endif
