// Resources of the strand drawing kernels. Group "render":
//   space0 RenderPosTan  what the simulation wrote
//   space1 Render        view, light and material
#ifndef PELAGE_LAYOUTS_RENDER_HLSLI
#define PELAGE_LAYOUTS_RENDER_HLSLI

// [strand][vertex]: world position [m]; w = inverse mass.
StructuredBuffer<float4> g_renderPositions : register(t0, space0);
// [strand][vertex]: unit tangent.
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
  uint g_sampleCount;        // samples a pixel of the target
  uint g_seed;               // of the coverage dither
  float g_fiberRadius;       // at the root [m]
  float g_tipRadiusRatio;    // radius at the tip over that at the root, 0..1
  float g_renderPad0;
  float g_renderPad1;
};

// [strand]: factor on the fibre radius; only with the strandThickness permutation.
StructuredBuffer<float> g_strandThickness : register(t0, space1);

#endif
