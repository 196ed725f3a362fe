// Adds a fragment of hair to the list of its pixel.
//
// Reads:   RenderConstants, StrandViewConstants, PPLLBuildConstants
// Writes:  g_listHeads, g_listNodes, g_listCounters, g_listTiles; with TAIL g_listTail
//
// A fragment without a node goes to the pixel's tail, averaged and not lit, or is dropped without a
// tail; the counter of nodes counts these fragments, too. A node is linked only after its index is
// known to be in bounds (K35).
//
// With STRAND_UV, which pelage_add_engine_lights() defines for lights that read it, the UV of
// the root is behind the nodes, four in an element.
//
// Invariant (tests/oit): every fragment of alpha > 0 is in exactly one list or tail, whatever
// the capacity.
#include "layouts/ppll_build.hlsli"
#include "../shading/layouts/render.hlsli"
#include "../shading/strand_alpha.hlsli"
#include "../shading/uv_packing.hlsli"
#include "fragment_packing.hlsli"
#include "pixel_tiles.hlsli"
#include "ppll_counters.hlsli"
#include "spill_tail.hlsli"

[earlydepthstencil]
void ppll_build(StrandPixel strand) {
  float alpha = strandAlpha(strand);
  uint shape = packShape(strand.tangent, alpha);
  if (!(alphaOfShape(shape) > 0.0)) return;
  // The pixel's position in the target, whatever part of it the viewport is.
  int2 at = int2(strand.clip.xy) - int2(g_viewport.xy);
  if (at.x < 0 || at.y < 0 || uint(at.x) >= g_listWidth || uint(at.y) >= g_listHeight) return;
  uint pixel = uint(at.y) * g_listWidth + uint(at.x);

  uint tile = (uint(at.y) >> kTileShift) * g_listTileColumns + (uint(at.x) >> kTileShift);
  if (g_listTiles[tile] == 0u) {
    uint before;
    InterlockedExchange(g_listTiles[tile], 1u, before);
    if (before == 0u) {
      uint index;
      InterlockedAdd(g_listCounters[kCounterTiles], 1u, index);
      uint tiles = g_listTileColumns * ((g_listHeight + (kTileEdge - 1u)) >> kTileShift);
      g_listTiles[tiles + index] = tile;
    }
  }

  uint node;
  InterlockedAdd(g_listCounters[kCounterNodes], 1u, node);
  if (node < g_nodeCapacity) {
    uint next;
    InterlockedExchange(g_listHeads[pixel], node + 1u, next);
    g_listNodes[node] =
        uint4(packLink(next, g_materialIndex), depthKey(strand.clip.z, g_reversedDepth != 0u),
              shape, packColor(strand.color.rgb));
#if STRAND_UV
    g_listNodes[g_nodeCapacity + (node >> 2)][node & 3u] = packUv(strand.uv);
#endif
    return;
  }
#if TAIL
  uint4 tail = tailOf(strand.color.rgb, alphaOfShape(shape));
  InterlockedAdd(g_listTail[4u * pixel], tail.x);
  InterlockedAdd(g_listTail[4u * pixel + 1u], tail.y);
  InterlockedAdd(g_listTail[4u * pixel + 2u], tail.z);
  InterlockedAdd(g_listTail[4u * pixel + 3u], tail.w);
#endif
}
