// Adds a fragment of hair to the list of its pixel; see classic_list_layout.hlsli.
#include "../../kernels/shading/layouts/render.hlsli"
#include "../../kernels/shading/strand_alpha.hlsli"
#include "classic_list_layout.hlsli"
#include "classic_list_packing.hlsli"

static const float kLeastAlpha = 1.0 / 255.0;

[earlydepthstencil]
void classic_list_build(StrandPixel strand) {
  float alpha = strandAlpha(strand);
  if (!(alpha >= kLeastAlpha)) return;
  int2 at = int2(strand.clip.xy) - int2(g_viewport.xy);
  if (at.x < 0 || at.y < 0 || uint(at.x) >= g_classicWidth || uint(at.y) >= g_classicHeight) return;
  uint node;
  InterlockedAdd(g_classicCounter[0], 1u, node);
  bool fits = node < g_classicCapacity;
  uint next;
  InterlockedExchange(g_classicHeads[uint(at.y) * g_classicWidth + uint(at.x)],
                      fits ? node + 1u : 0u, next);
  if (!fits) return;
  g_classicNodes[node] = uint4(next, asuint(strand.clip.z),
                               packBytes(float4(normalize(strand.tangent) * 0.5 + 0.5, alpha)),
                               packBytes(float4(strand.color.rgb, 1.0)));
}
