// Resources of the strand drawing kernels. Group "render":
//   space0 RenderPosTan  outputs of the simulation
//   space1 Render        view, light and material
#ifndef PELAGE_SHADING_LAYOUTS_RENDER_HLSLI
#define PELAGE_SHADING_LAYOUTS_RENDER_HLSLI

#include "../../simulation/layouts/follow.hlsli"

#define STRAND_VIEW_REGISTER register(b0, space1)
#include "strand_view.hlsli"

// [strand][vertex]: world position [m]; w = inverse mass. With g_evaluatesFollows it has
// only the g_renderGuideCount guides.
StructuredBuffer<float4> g_renderPositions : register(t0, space0);
// [strand][vertex], of the same size: unit tangent.
StructuredBuffer<float4> g_renderTangents : register(t1, space0);

// Bits of g_strandAttributes: the attributes that the object has.
static const uint kHasThickness = 1u;
static const uint kHasVertexColors = 2u;
static const uint kHasBaseTexture = 4u;
static const uint kHasStrandColors = 8u;  // of an engine's texture, in place of kHasBaseTexture
static const uint kHasStrandUvs = 16u;    // strands are drawn with the UV of their roots

cbuffer RenderConstants : register(b1, space1) {
  float4 g_shadingBody;  // members of StrandShading
  float4 g_shadingPrimary;
  float4 g_shadingSecondary;
  float4 g_shadingFiber;
  float4 g_rootColor;        // linear rgb; a = opacity 0..1
  float4 g_tipColor;         // linear rgb; a = share of the strand that it fades in over, 0..1
  uint g_renderVertexCount;  // vertices per strand
  uint g_renderStrandCount;
  uint g_renderGuideCount;      // the strands from here on are follow hairs
  float g_renderTipSeparation;  // factor on the follow offsets at the tip
  float g_fiberRadius;          // at the root [m]
  float g_tipRadiusRatio;       // radius at the tip over that at the root, 0..1
  float g_strandVariation;      // variation of color between strands, 0..1
  uint g_materialIndex;         // of lists that keep it, 0..63
  float g_drawnStrands;         // strands from here on have no width
  float g_fadingStrands;        // number of strands before them whose width falls to 0
  float g_strandWidening;       // factor on the radius that replaces the strands that are not drawn
  uint g_shadingModel;          // StrandShading.model.x
  uint2 g_textureSize;          // texels; 0: no texture
  uint g_strandAttributes;      // bits: what to read with the attributes permutation
  uint g_evaluatesFollows;      // 0 or 1: follow hairs are computed from their guides
};

// The buffers of attributes are bound only with the attributes permutation; of these, only those in
// g_strandAttributes are read.
StructuredBuffer<float> g_strandThickness : register(t0, space1);
// [strand - g_renderGuideCount]; only read if there are follow hairs.
StructuredBuffer<FollowHairRecord> g_renderFollowHairRecords : register(t1, space1);
// [2][g_renderGuideCount]: root frames of this frame and the last one; only read with
// g_evaluatesFollows.
StructuredBuffer<RootTransform> g_renderRoots : register(t2, space1);
// [guide][vertex]: linear rgba as four halves; an attribute. A follow hair has the colors of its
// first guide.
StructuredBuffer<uint2> g_vertexColors : register(t3, space1);
// Color and UV at the roots of strands; an attribute. UV are the bits of two floats, 0..1 and
// repeated beyond; colors are linear rgba as two words of two 16-bit unorms.
// With kHasBaseTexture: [y][x] colors; then [guide]: UV.
// Else: [guide][2]: UV, then with kHasStrandColors a color.
StructuredBuffer<uint2> g_baseTexture : register(t4, space1);
// Words of all shadow maps.
StructuredBuffer<uint> g_shadowWords : register(t5, space1);

StrandShading renderShading() {
  return shadingFrom(g_shadingModel, g_shadingBody, g_shadingPrimary, g_shadingSecondary,
                     g_shadingFiber);
}

#endif
