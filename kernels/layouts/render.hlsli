// Resources of the strand drawing kernels. Group "render":
//   space0 RenderPosTan  what the simulation wrote
//   space1 Render        view, light and material
#ifndef PELAGE_LAYOUTS_RENDER_HLSLI
#define PELAGE_LAYOUTS_RENDER_HLSLI

#include "follow.hlsli"

// [strand][vertex]: world position [m]; w = inverse mass. With the followStrands permutation only
// the g_renderGuideCount guides are there.
StructuredBuffer<float4> g_renderPositions : register(t0, space0);
// [strand][vertex], as many: unit tangent.
StructuredBuffer<float4> g_renderTangents : register(t1, space0);

cbuffer RenderConstants : register(b0, space1) {
  float4 g_worldToClip[4];   // rows; clip = rows * (p, 1), depth 0..1, y up
  float4 g_eye;              // xyz position of the camera [m]
  float4 g_viewport;         // xy offset, zw size [pixels]
  float4 g_lightDirection;   // xyz unit vector towards the light
  float4 g_lightColor;       // linear rgb
  float4 g_ambientColor;     // linear rgb
  float4 g_rootColor;        // linear rgb; a = opacity 0..1
  float4 g_tipColor;         // linear rgb
  float4 g_specular;         // primary strength and exponent, secondary strength and exponent
  float4 g_specularShift;    // x primary, y secondary shift of the tangent; zw unused
  uint g_renderVertexCount;  // vertices a strand
  uint g_renderStrandCount;
  uint g_sampleCount;           // samples a pixel of the target
  uint g_seed;                  // of the coverage dither
  float g_fiberRadius;          // at the root [m]
  float g_tipRadiusRatio;       // radius at the tip over that at the root, 0..1
  uint g_renderGuideCount;      // the strands from here on are follow strands
  float g_renderTipSeparation;  // factor on the follow offsets at the tip
};

// [strand]: factor on the fibre radius; only with the strandThickness permutation.
StructuredBuffer<float> g_strandThickness : register(t0, space1);
// [strand - g_renderGuideCount]; only with the followStrands permutation.
StructuredBuffer<FollowStrand> g_renderFollowStrands : register(t1, space1);
// [2][g_renderGuideCount]: root frames of this frame and the last one; only with the followStrands
// permutation.
StructuredBuffer<RootTransform> g_renderRoots : register(t2, space1);

#endif
