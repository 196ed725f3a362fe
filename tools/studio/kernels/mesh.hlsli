// Resources of the sample's mesh kernels, group "mesh".
#ifndef SAMPLE_MESH_HLSLI
#define SAMPLE_MESH_HLSLI

#include "shading/layouts/strand_shadow_view.hlsli"

// Vertex inputs: many devices have no storage buffers in the vertex stage.
struct MeshVertex {
  [[vk::location(0)]] float4 position : ATTRIBUTE0;  // xyz in bind space [m]; w = share of the
                                                     // scalp's color, 0..1
  [[vk::location(1)]] float4 normal : ATTRIBUTE1;    // xyz unit vector in bind space; w = share of
                                                     // the coat's color, 0..1
  [[vk::location(2)]] uint4 bones : ATTRIBUTE2;      // index g_meshBones, in bones
  [[vk::location(3)]] float4 weights : ATTRIBUTE3;   // sum to 1
};

cbuffer MeshConstants : register(b0, space0) {
  float4 g_worldToClip[4];  // rows; clip = rows * (p, 1), depth 0..1, y up
  float4 g_eye;             // xyz position of the camera [m]
  float4 g_lightDirection;  // xyz unit vector towards the light
  float4 g_lightColor;      // linear rgb
  float4 g_ambientColor;    // linear rgb, from above; half of it comes from below
  float4 g_skinColor;       // linear rgb
  float4 g_scalpColor;      // linear rgb, where the hair grows
  float4 g_coatColor;       // linear rgb, under fur
  uint g_meshBoneCount;
  uint g_meshPad0;
  uint g_meshPad1;
  uint g_meshPad2;
  float4 g_meshBones[768];  // three rows a bone: bind space to world
};

// Shadow maps of hair, the first one that of the light: Scene::shadowWords() and shadowViews().
// Bound with the shadowed permutation alone.
StructuredBuffer<uint> g_meshShadowWords : register(t0, space0);
StructuredBuffer<StrandShadowView> g_meshShadowViews : register(t1, space0);

struct MeshVaryings {
  float4 clip : SV_Position;
  float3 world : TEXCOORD0;
  float3 normal : TEXCOORD1;
  float2 covered : TEXCOORD2;  // shares of the scalp's and the coat's color
};

#endif
