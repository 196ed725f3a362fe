// An SDF, shared by the kernels that write it and those that read it.
//
// All SDFs of a scene share one buffer of keys and one of surface records.
#ifndef PELAGE_SDF_LAYOUTS_SDF_HLSLI
#define PELAGE_SDF_LAYOUTS_SDF_HLSLI

struct Sdf {
  float4 origin;  // xyz of node 0 in the space of the queries [m]; w = cell size [m]
  uint4 nodes;    // xyz counts along the axes, x a multiple of 4; w = first element of the keys
  uint triangleCount;
  uint triangleBits;   // of a key, see sdf_key.hlsli; 2^triangleBits > triangleCount
  uint surface;        // first element of the surface records
  uint surfaceStride;  // elements per record: 4, or 7 with motion
  // [cell] nodes within this distance of the surface have exact distances, on both sides
  float band;
  float farRange;     // [cell] depth beyond the band that keys of the interior can store
  float margin;       // [m] distance that contacts keep from the surface, >= 0
  float friction;     // Coulomb coefficient, >= 0
  float motionScale;  // 1 when the motion of the records is that of this frame, else 0
  uint pad0;
  uint pad1;
  uint pad2;
};
static const uint kSdfElements = 5;  // uint4 of an Sdf

// A surface record, one per triangle, of 4 or 7 uint4:
//   0 - 2  xyz  vertex 0 - 2 [cell], from node 0 (bits of floats)
//          w    its angle-weighted normal, octahedral, 16 bits a component
//   3      xyz  triangles across the edges 01, 12, 20; kSdfNone where there is none
//          w    0
//   4 - 6  xyz  displacement of vertex 0 - 2 in the last frame [cell] (bits of floats); w = 0
// A triangle that is not finite or has no area has all its vertices at kSdfNowhere and is in no
// key.
static const uint kSdfStillRecord = 4;
static const uint kSdfMovingRecord = 7;
static const uint kSdfNeighbors = 3;  // element of a record
static const uint kSdfNone = 0xffffffffu;
static const float kSdfNowhere = 1e18;

#endif
