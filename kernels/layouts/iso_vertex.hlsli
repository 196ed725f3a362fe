// A vertex of a surface that marching cubes made and a mesh pass draws.
#ifndef PELAGE_LAYOUTS_ISO_VERTEX_HLSLI
#define PELAGE_LAYOUTS_ISO_VERTEX_HLSLI

struct IsoVertex {
  float4 position;  // xyz in the space of the field [m]; w = 1
  float4 normal;    // xyz unit vector to where the distance grows; w = 0
};

#endif
