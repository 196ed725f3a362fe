// Resources of drawing strands by a value, and of counting their fragments: groups "drawValues"
// and, with space1, "overdraw" and "tileCounts".
#ifndef VIEWER_DRAW_VALUES_HLSLI
#define VIEWER_DRAW_VALUES_HLSLI

static const uint kRampColors = 5;

cbuffer DrawValuesConstants : register(b0, space0) {
  float4 g_valuesToClip[4];  // rows; clip = rows * (p, 1), p in world space, depth 0..1, y up
  float4 g_valueRamp[5];     // linear rgb of values from g_valueLow to g_valueHigh, evenly
  float4 g_valueArea;        // xy first pixel of the viewport, zw its size [pixels]
  float g_valueLow;
  float g_valueHigh;        // > g_valueLow
  uint g_valueVertexCount;  // vertices a strand
  float g_valueAbove;       // only values above it are drawn
  float g_valueWidth;       // least width of a strand [pixels]
  float g_valueRadius;      // at the root [m]; 0: strands have the least width
  float g_valueTipRatio;    // radius at the tip over that at the root
  float g_valueFocal;       // pixels of a meter at a distance of 1 m
};

struct ValueVaryings {
  float4 clip : SV_Position;
  float value : TEXCOORD0;
};

struct CoveringVaryings {
  float4 clip : SV_Position;
};

// The color of a value; beyond the ends it is that of the end.
float3 colorOfValue(float value) {
  float share = saturate((value - g_valueLow) / (g_valueHigh - g_valueLow));
  float at = share * float(kRampColors - 1u);
  uint low = min(uint(at), kRampColors - 2u);
  return lerp(g_valueRamp[low].rgb, g_valueRamp[low + 1u].rgb, at - float(low));
}

#endif
