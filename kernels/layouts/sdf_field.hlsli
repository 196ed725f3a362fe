// A signed distance field, as those who write it and those who read it share it.
//
// All fields of a scene lie in one buffer of keys and one of surface records.
#ifndef PELAGE_LAYOUTS_SDF_FIELD_HLSLI
#define PELAGE_LAYOUTS_SDF_FIELD_HLSLI

struct SdfField {
  float4 origin;  // xyz of node 0 in the space of the queries [m]; w = cell size [m]
  uint4 nodes;    // xyz counts along the axes, x a multiple of 4; w = first element of the keys
  uint triangleCount;
  uint triangleBits;  // of a key, see sdf_key.hlsli; 2^triangleBits > triangleCount
  uint surface;       // first element of the surface records
  uint surfaceStride;  // elements a record: 4, or 7 with motion
  float band;          // [cell] nodes up to here from the surface have their distance, on both sides
  float farRange;      // [cell] depth that the keys of the interior reach beyond the band
  float margin;        // [m] what touches the surface is kept this far outside, >= 0
  float friction;      // Coulomb's coefficient, >= 0
  float motionScale;   // 1 when the motion of the records is that of this frame, else 0
  uint pad0;
  uint pad1;
  uint pad2;
};

// A surface record, one a triangle, of 4 or 7 uint4:
//   0 - 2  xyz  vertex 0 - 2 [cell], from node 0 (bits of floats)
//          w    its angle-weighted normal, octahedral, 16 bits a component
//   3      xyz  triangles across the edges 01, 12, 20; kSdfNone where there is none
//          w    0
//   4 - 6  xyz  way of vertex 0 - 2 in the last frame [cell] (bits of floats); w = 0
// A triangle that is not finite or has no area has all its vertices at kSdfNowhere and is in no key.
static const uint kSdfNone = 0xffffffffu;
static const float kSdfNowhere = 1e18;

#endif
