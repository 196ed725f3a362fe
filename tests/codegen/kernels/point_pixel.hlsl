#include "draw.hlsli"

float4 point_pixel(PointOutput input) : SV_Target0 { return input.color * g_color.a; }
