// Resources of counting fragments a pixel, group "overdraw" (space1 after DrawValues).
#ifndef VIEWER_OVERDRAW_HLSLI
#define VIEWER_OVERDRAW_HLSLI

#include "draw_values.hlsli"

RWStructuredBuffer<uint> g_overdraw : register(u0, space1);         // [y][x] of the viewport
RWStructuredBuffer<uint> g_overdrawSummary : register(u1, space1);  // kOverdrawWords

static const uint kOverdrawMost = 0;    // fragments of the fullest pixel
static const uint kOverdrawPixels = 1;  // pixels with hair
static const uint kOverdrawTotal = 2;   // fragments
static const uint kOverdrawWords = 4;

uint overdrawPixels() { return uint(g_valueArea.z) * uint(g_valueArea.w); }

#endif
