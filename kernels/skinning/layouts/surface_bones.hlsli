// Resources of bones that follow a deformed mesh. Group "surfaceBones", all in space0.
#ifndef PELAGE_SKINNING_LAYOUTS_SURFACE_BONES_HLSLI
#define PELAGE_SKINNING_LAYOUTS_SURFACE_BONES_HLSLI

// A root on a triangle, as the mesh was when the hair was bound to it. The triangle's frame has x
// along the edge from corner 0 to 1, z along the normal and y = z cross x. Corner 1 is at (edge, 0)
// and corner 2 at (shear, height) in its plane.
struct SurfaceBone {
  uint4 corners;   // x, y, z: vertices of the triangle; w: bone that is written
  float4 frameX;   // xyz of the bind frame's x axis; w = edge [m], > 0
  float4 frameY;   // xyz of its y axis; w = height [m], > 0
  float4 root;     // xyz bind position of the root [m]; w = shear [m]
  float4 offset;   // xyz of the root from its surface point, in the frame [m]; w = 0
  float4 weights;  // x, y: barycentric weights of corners 1 and 2; zw = 0
};

cbuffer SurfaceBonesConstants : register(b0, space0) {
  uint g_surfaceFirst;         // first element of g_surfaceBones; first: decision 0008
  uint g_surfaceCount;         // elements
  uint g_surfaceStride;        // floats from vertex to vertex in g_surfaceVertices, >= 3
  uint g_surfaceOffset;        // floats before the first position
  float4 g_surfaceOrigin;      // xyz of the origin that bones are relative to, in world space [m]
  float4 g_surfaceOriginRest;  // xyz what rounding has left of it; 0 for whole meters
  uint g_surfaceToDual;        // 1: g_surfaceTransforms has dual quaternions; 0: matrices
  uint g_surfacePad0;
  uint g_surfacePad1;
  uint g_surfacePad2;
};

StructuredBuffer<SurfaceBone> g_surfaceBones : register(t0, space0);
// Positions in world space [m], written by the engine.
StructuredBuffer<float> g_surfaceVertices : register(t1, space0);
// Bind space to the origin's: 3 rows of [M | t] a bone, or 2 quaternions (skinning/bones.hlsli).
RWStructuredBuffer<float4> g_surfaceTransforms : register(u0, space0);

#endif
