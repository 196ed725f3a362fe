// One colour.
//
// One thread a fragment.
// Reads nothing but constants.
// Invariant: a covered pixel has exactly this colour.
#include "runtime_draw.hlsli"

float4 fill_pixel() : SV_Target0 { return g_color; }
