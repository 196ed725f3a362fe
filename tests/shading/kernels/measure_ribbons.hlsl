// Both kinds of ribbon at vertices of strands. One thread a sample; groups of 64.
#include "ribbon_samples.hlsli"

[numthreads(64, 1, 1)]
void measure_ribbons(uint3 id : SV_DispatchThreadID) {
  if (id.x >= g_ribbonCount) return;
  RibbonSample s = g_ribbonSamples[id.x];
  StrandView view;
  view.clipX = g_ribbonClip[0];
  view.clipY = g_ribbonClip[1];
  view.clipZ = g_ribbonClip[2];
  view.clipW = g_ribbonClip[3];
  view.eye = g_ribbonEye.xyz;
  view.viewportSize = g_ribbonViewport.zw;
  StrandRibbon ribbon =
      expandStrandRibbon(view, s.position.xyz, s.tangent.xyz, s.position.w, s.tangent.w);
  StrandCorner corner =
      expandStrandVertex(view, s.position.xyz, s.tangent.xyz, s.position.w, s.tangent.w);
  RibbonResult result;
  result.smoothClip = ribbon.clip;
  result.clip = corner.clip;
  result.values = float4(ribbon.distance, ribbon.halfWidth, corner.coverage, 0.0);
  g_ribbonResults[id.x] = result;
}
