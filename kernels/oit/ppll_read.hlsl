// Composites the list of a pixel from front to back, exactly, in windows of the nearest kWindow
// fragments: it walks the list for the nearest ones behind the last one that it composited, shades
// them, and walks again while light still comes through.
//
// Reads:   g_readHeads, g_readNodes, StrandViewConstants, PPLLReadConstants; with TAIL g_readTail
// Writes:  SV_Target0 premultiplied color, alpha = 1 - transmittance
//
// Fragments are ordered by depth, then by contents, then by index: fragments that tie in all are
// equal, so the order of arrival changes no bit of the picture (K36). Empty slots are not shaded
// (K38). A walk over a list is bounded by the list's maximum length. If a list has more than 512
// fragments and light still comes through, the fragments behind the first kMaxVisits visits of
// nodes are averaged; so the time of a pixel does not grow with the square of its layers.
//
// Invariant (tests/oit): the composite of all fragments in order, except for those behind a
// transmittance of g_readEpsilon.
#include "../base/random_hash.hlsli"
#include "layouts/oit_tiles.hlsli"
#include "layouts/ppll_read.hlsli"
#include "fragment_packing.hlsli"
#include "spill_tail.hlsli"
#define SHADOW_WORDS g_readShadowWords
#include "../shading/light_strand.hlsli"
#include "../shading/uv_packing.hlsli"
#include "composite_fragment.hlsli"

// A node of the window: its sort keys and its index. A free slot has kNoSlot and is the farthest.
struct WindowSlot {
  uint key;
  uint tie;  // orders nodes of one depth by their contents
  uint position;
};

// 16 take as long on an H200, with twice the registers.
static const uint kWindow = 8u;
static const uint kNoSlot = 0xffffffffu;
// Maximum visits of nodes for the exact composite of a pixel.
static const uint kMaxVisits = 32768u;

WindowSlot freeSlot() {
  WindowSlot slot;
  slot.key = 0xffffffffu;
  slot.tie = 0xffffffffu;
  slot.position = kNoSlot;
  return slot;
}

// The word of a node's UV; 0 without STRAND_UV.
uint uvWordOf(uint position) {
  uint word = 0u;
#if STRAND_UV
  word = g_readNodes[g_readNodeCapacity + (position >> 2)][position & 3u];
#endif
  return word;
}

// Nodes of one depth whose hashes are equal are equal themselves, but for one pair in 2^32.
WindowSlot slotOf(uint4 node, uint position) {
  WindowSlot slot;
  slot.key = node.y;
  slot.tie = hashUint(node.z ^ hashUint(node.w ^ materialOf(node.x)));
#if STRAND_UV
  slot.tie = hashUint(slot.tie ^ uvWordOf(position));
#endif
  slot.position = position;
  return slot;
}

bool isBefore(WindowSlot a, WindowSlot b) {
  bool tie = a.tie < b.tie || (a.tie == b.tie && a.position < b.position);
  return a.key < b.key || (a.key == b.key && tie);
}

void addNode(inout Composite sum, uint position, float2 pixel) {
  uint4 node = g_readNodes[position];
  addFragment(sum, readShading(materialOf(node.x)), pixel - g_viewport.xy, node.y, node.z, node.w,
              unpackUv(uvWordOf(position)));
}

// Base colors of all that lies behind a node, as in spill_tail.hlsli.
uint4 averagedBehind(WindowSlot last, uint head) {
  uint4 sum = uint4(0u, 0u, 0u, 0u);
  uint next = head;
  for (uint step = 0u; step < g_readNodeCapacity; ++step) {
    if (next == 0u || next > g_readNodeCapacity) break;
    uint4 node = g_readNodes[next - 1u];
    WindowSlot slot = slotOf(node, next - 1u);
    next = nextOf(node.x);
    if (isBefore(last, slot)) sum += tailOf(colorOf(node.w), alphaOfShape(node.z));
  }
  return sum;
}

ResolvedPixel ppll_read(OitTilePixel tile) {
  ResolvedPixel result;
  result.color = float4(0.0, 0.0, 0.0, 0.0);
  int2 at = int2(tile.clip.xy) - int2(g_viewport.xy);
  bool inside = at.x >= 0 && at.y >= 0 && uint(at.x) < g_readWidth && uint(at.y) < g_readHeight;
  uint pixel = inside ? uint(at.y) * g_readWidth + uint(at.x) : 0u;
  uint head = inside ? g_readHeads[pixel] : 0u;
#if TAIL
  uint4 spilled = uint4(0u, 0u, 0u, 0u);
  if (inside) spilled = g_readTail[pixel];
  if (head == 0u && spilled.w == 0u) discard;
#else
  if (head == 0u) discard;
#endif

  Composite sum = emptyComposite();
  WindowSlot last = freeSlot();
  bool more = true;
  uint visits = 0u;
  while (more && visits < kMaxVisits) {
    WindowSlot window[kWindow];
    [unroll] for (uint i = 0u; i < kWindow; ++i) window[i] = freeSlot();
    more = false;
    uint next = head;
    for (uint step = 0u; step < g_readNodeCapacity; ++step) {
      if (next == 0u || next > g_readNodeCapacity) break;
      ++visits;
      uint4 node = g_readNodes[next - 1u];
      WindowSlot slot = slotOf(node, next - 1u);
      next = nextOf(node.x);
      if (last.position != kNoSlot && !isBefore(last, slot)) continue;
      // One of the nodes comes in a later walk: this one, or the one that it displaces.
      more = more || window[kWindow - 1u].position != kNoSlot;
      if (!isBefore(slot, window[kWindow - 1u])) continue;
      [unroll] for (uint j = 0u; j < kWindow; ++j) {
        if (isBefore(slot, window[j])) {
          WindowSlot moved = window[j];
          window[j] = slot;
          slot = moved;
        }
      }
    }
    // The nearest one leaves the window each time, so that the lighting is in the code once, and
    // the window is in registers.
    for (uint k = 0u; k < kWindow; ++k) {
      WindowSlot nearest = window[0];
      [unroll] for (uint m = 0u; m + 1u < kWindow; ++m) window[m] = window[m + 1u];
      window[kWindow - 1u] = freeSlot();
      if (nearest.position == kNoSlot || !(sum.transmittance > g_readEpsilon)) break;
      addNode(sum, nearest.position, tile.clip.xy);
      last = nearest;
    }
    more = more && sum.transmittance > g_readEpsilon;
  }
  uint4 rest = uint4(0u, 0u, 0u, 0u);
  if (more) rest = averagedBehind(last, head);
#if TAIL
  rest += spilled;
#endif
  if (rest.w > 0u) {
    // The mean fiber, lit where the last one was; at the eye if no fragment has a node.
    uint4 node = uint4(0u, 0u, 0u, 0u);
    float3 position = g_eye.xyz;
    if (last.position != kNoSlot) {
      node = g_readNodes[last.position];
      position =
          fragmentPosition(tile.clip.xy - g_viewport.xy, depthOfKey(node.y, g_reversedDepth != 0u));
    }
    float3 color = float3(rest.xyz) / float(rest.w);
    StrandSurface surface = strandSurface(position, tangentOfShape(node.z), color);
    if (last.position != kNoSlot) surface.uv = unpackUv(uvWordOf(last.position));
    float3 light = lightStrand(readShading(materialOf(node.x)), surface);
    float transmittance = transmittanceOf(rest.w);
    sum.light += light * ((1.0 - transmittance) * sum.transmittance);
    sum.transmittance *= transmittance;
  }
  result.color = float4(sum.light, 1.0 - sum.transmittance);
  return result;
}
