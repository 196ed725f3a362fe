// Resources that the lists of classic_list_layout.hlsli are resolved from, of one hair object.
// Group "classicListRead", all in space0.
#ifndef BASELINE_CLASSIC_LIST_READ_LAYOUT_HLSLI
#define BASELINE_CLASSIC_LIST_READ_LAYOUT_HLSLI

#define STRAND_VIEW_REGISTER register(b0, space0)
#include "../../kernels/shading/layouts/strand_view.hlsli"

cbuffer ClassicListReadConstants : register(b1, space0) {
  // Members of StrandShading.
  float4 g_classicBody;
  float4 g_classicPrimary;
  float4 g_classicSecondary;
  float4 g_classicFiber;
  uint g_classicModel;
  uint g_classicReadWidth;   // [pixels]
  uint g_classicReadHeight;  // [pixels]
  uint g_classicReadCapacity;
};

// As in classic_list_layout.hlsli.
StructuredBuffer<uint> g_classicReadHeads : register(t0, space0);
StructuredBuffer<uint4> g_classicReadNodes : register(t1, space0);
// Words of all shadow maps.
StructuredBuffer<uint> g_classicShadowWords : register(t2, space0);

struct ClassicListPixel {
  float4 clip : SV_Position;
};

#endif
