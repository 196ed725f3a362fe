// A vertex of a surface from marching cubes, for a mesh pass.
#ifndef PELAGE_SDF_LAYOUTS_ISO_VERTEX_HLSLI
#define PELAGE_SDF_LAYOUTS_ISO_VERTEX_HLSLI

struct IsoVertex {
  float4 position;  // xyz in the space of the field [m]; w = 1
  float4 normal;    // xyz unit vector to where the distance grows; w = 0
};

#endif
