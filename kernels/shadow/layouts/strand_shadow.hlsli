// Resources of the kernels that draw strands into shadow maps. Group "strandShadow", all in space0.
#ifndef PELAGE_SHADOW_LAYOUTS_STRAND_SHADOW_HLSLI
#define PELAGE_SHADOW_LAYOUTS_STRAND_SHADOW_HLSLI

#include "../../simulation/layouts/follow.hlsli"
#include "../../shading/layouts/strand_shadow_view.hlsli"

cbuffer StrandShadowConstants : register(b0, space0) {
  uint g_shadowView;         // element of g_shadowViews
  uint g_shadowVertexCount;  // vertices per strand
  uint g_shadowStrandCount;
  uint g_shadowGuideCount;      // the strands from here on are follow hairs, computed here
  float g_shadowTipSeparation;  // factor on the follow offsets at the tip
  float g_shadowFiberRadius;    // at the root [m]
  float g_shadowTipRatio;       // radius at the tip over that at the root, 0..1
  float g_shadowOpacity;        // of a fiber, 0..1
  float g_shadowFade;           // factor on the radius of the last strands
  uint g_shadowFadingCount;     // how many those are
  uint g_shadowHasThickness;    // 0 or 1
  uint g_shadowPad0;
};

// [strand][vertex]: world position [m]; w unused. Only of the first g_shadowGuideCount strands.
StructuredBuffer<float4> g_shadowPositions : register(t0, space0);
// [map]
StructuredBuffer<StrandShadowView> g_shadowViews : register(t1, space0);
// [strand]: factor on the fiber radius; only read with g_shadowHasThickness.
StructuredBuffer<float> g_shadowThickness : register(t2, space0);
// [strand - g_shadowGuideCount]
StructuredBuffer<FollowHairRecord> g_shadowFollowHairRecords : register(t3, space0);
// [2][g_shadowGuideCount]: root frames of this frame and the last one; only read if follow hairs
// are computed here.
StructuredBuffer<RootTransform> g_shadowRoots : register(t4, space0);
// All maps, see strand_shadow_view.hlsli.
RWStructuredBuffer<uint> g_shadowWords : register(u0, space0);

#endif
