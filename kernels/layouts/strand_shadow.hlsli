// Resources of the kernels that draw strands into shadow maps. Group "strandShadow", all in space0.
#ifndef PELAGE_LAYOUTS_STRAND_SHADOW_HLSLI
#define PELAGE_LAYOUTS_STRAND_SHADOW_HLSLI

#include "follow.hlsli"
#include "strand_shadow_view.hlsli"

cbuffer StrandShadowConstants : register(b0, space0) {
  uint g_shadowView;         // element of g_shadowViews
  uint g_shadowWordCount;    // words of that map
  uint g_shadowVertexCount;  // vertices a strand
  uint g_shadowStrandCount;
  uint g_shadowGuideCount;      // the strands from here on are follow strands that are placed here
  float g_shadowTipSeparation;  // factor on the follow offsets at the tip
  float g_shadowFiberRadius;    // at the root [m]
  float g_shadowTipRatio;       // radius at the tip over that at the root, 0..1
  float g_shadowOpacity;        // of a fibre, 0..1
  float g_shadowFade;           // factor on the radius of the last strands
  uint g_shadowFadingCount;     // how many those are
  uint g_shadowHasThickness;    // 0 or 1
};

// [strand][vertex]: world position [m]; w unused. Only the first g_shadowGuideCount strands
// are there.
StructuredBuffer<float4> g_shadowPositions : register(t0, space0);
// [map]
StructuredBuffer<StrandShadowView> g_shadowViews : register(t1, space0);
// [strand]: factor on the fibre radius; only read with g_shadowHasThickness.
StructuredBuffer<float> g_shadowThickness : register(t2, space0);
// [strand - g_shadowGuideCount]
StructuredBuffer<FollowStrand> g_shadowFollowStrands : register(t3, space0);
// [2][g_shadowGuideCount]: root frames of this frame and the last one; only read where strands are
// placed.
StructuredBuffer<RootTransform> g_shadowRoots : register(t4, space0);
// All maps, see strand_shadow_view.hlsli.
RWStructuredBuffer<uint> g_shadowWords : register(u0, space0);

#endif
