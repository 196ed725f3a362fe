// Resources of the viewer's picture, group "picture".
#ifndef VIEWER_PICTURE_HLSLI
#define VIEWER_PICTURE_HLSLI

cbuffer PictureConstants : register(b0, space0) {
  float4 g_backdropTop;     // linear rgb; w = relative brightening in the middle, >= 0
  float4 g_backdropBottom;  // linear rgb
  uint g_pictureWidth;      // [pixels]
  uint g_pictureHeight;
  uint g_flipsRows;   // 1: row 0 of the target is the bottom one
  uint g_coarseness;  // edge of a pixel of the scene [pixels of the picture], >= 1
};

Texture2DArray<float4> g_sceneColor : register(t0, space0);  // [0] linear, premultiplied alpha

struct PictureVaryings {
  float4 clip : SV_Position;
};

#endif
