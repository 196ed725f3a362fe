// Resources of drawing an iso surface. Group "renderMesh", all in space0.
#ifndef PELAGE_SHADING_LAYOUTS_RENDER_MESH_HLSLI
#define PELAGE_SHADING_LAYOUTS_RENDER_MESH_HLSLI

cbuffer RenderMeshConstants : register(b0, space0) {
  float4 g_meshToClip[4];       // rows; clip = rows * (p, 1), p in world space, depth 0..1, y up
  float4 g_sdfToWorld[3];       // rows of a rotation and a translation
  float4 g_meshEye;             // xyz position of the camera [m]
  float4 g_meshLightDirection;  // xyz unit vector towards the light
  float4 g_meshLightColor;      // linear rgb
  float4 g_meshAmbientColor;    // linear rgb
  float4 g_meshColor;           // linear rgb; a = opacity 0..1
};

struct MeshVaryings {
  float4 clip : SV_Position;
  float3 position : TEXCOORD0;  // world [m]
  float3 normal : TEXCOORD1;
};

#endif
