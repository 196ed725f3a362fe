// Composites the list of a pixel from front to back, exactly, in windows of the nearest WINDOW
// fragments: it walks the list for the nearest ones behind the last one that it composited, shades
// them, and walks again while light still comes through.
//
// Reads:   g_readHeads, g_readNodes, StrandViewConstants, PPLLReadConstants; with TAIL g_readTail
// Writes:  SV_Target0 premultiplied colour, alpha = 1 - transmittance
//
// Fragments are ordered by depth, then by what they are, then by their place: those that tie to the
// last are equal, so the order of arrival changes no bit of the picture (K36). Slots that hold
// nothing are not shaded (K38). A list is walked no further than it can be long. Lists of more than
// 512 fragments that let light through as far as that are averaged behind what kMaxVisits visits of
// nodes had time for; so the time that a pixel takes does not grow with the square of its layers.
//
// Invariant (tests/kernel): the composite of all fragments in order, but for what lies behind a
// transmittance of g_readEpsilon.
#include "../layouts/oit_tiles.hlsli"
#include "../layouts/ppll_read.hlsli"
#include "fragment_packing.hlsli"
#include "oit_tile_interface.hlsli"
#include "spill_tail.hlsli"
#define SHADOW_WORDS g_readShadowWords
#include "../shading/light_strand.hlsli"
#include "composite_fragment.hlsli"

// Key and place of a node; a free slot has kNoPlace and the farthest key.
struct WindowSlot {
  uint key;
  uint place;
};

static const uint kNoPlace = 0xffffffffu;
// Visits of nodes that a pixel has for its exact composite.
static const uint kMaxVisits = 32768u;

// Whether node a comes before node b, of the same key.
bool tiesBefore(uint a, uint b) {
  if (a == kNoPlace || b == kNoPlace) return b == kNoPlace && a != kNoPlace;
  uint4 na = g_readNodes[a];
  uint4 nb = g_readNodes[b];
  if (na.z != nb.z) return na.z < nb.z;
  if (na.w != nb.w) return na.w < nb.w;
  if (materialOf(na.x) != materialOf(nb.x)) return materialOf(na.x) < materialOf(nb.x);
  return a < b;
}

bool isBefore(WindowSlot a, WindowSlot b) {
  bool result = a.key < b.key;
  if (a.key == b.key) result = tiesBefore(a.place, b.place);
  return result;
}

void addNode(inout Composite sum, uint place, float2 pixel) {
  uint4 node = g_readNodes[place];
  addFragment(sum, readShading(materialOf(node.x)), pixel - g_viewport.xy, node.y, node.z, node.w);
}

// All that lies behind a node, as in spill_tail.hlsli.
uint4 averagedBehind(WindowSlot last, uint head, float2 pixel) {
  uint4 sum = uint4(0u, 0u, 0u, 0u);
  uint next = head;
  for (uint step = 0u; step < g_readNodeCapacity; ++step) {
    if (next == 0u || next > g_readNodeCapacity) break;
    WindowSlot slot;
    slot.place = next - 1u;
    uint4 node = g_readNodes[slot.place];
    slot.key = node.y;
    next = nextOf(node.x);
    if (isBefore(last, slot))
      sum += tailOf(lightStrand(readShading(materialOf(node.x)),
                                surfaceOfFragment(pixel - g_viewport.xy, node.y, node.z, node.w)),
                    alphaOfShape(node.z));
  }
  return sum;
}

struct ResolvedPixel {
  float4 color : SV_Target0;
};

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
  WindowSlot last;
  last.key = 0u;
  last.place = kNoPlace;
  bool more = true;
  uint visits = 0u;
  while (more && visits < kMaxVisits) {
    WindowSlot window[WINDOW];
    [unroll] for (uint i = 0u; i < uint(WINDOW); ++i) {
      window[i].key = 0xffffffffu;
      window[i].place = kNoPlace;
    }
    more = false;
    uint next = head;
    for (uint step = 0u; step < g_readNodeCapacity; ++step) {
      if (next == 0u || next > g_readNodeCapacity) break;
      ++visits;
      WindowSlot slot;
      slot.place = next - 1u;
      uint4 node = g_readNodes[slot.place];
      slot.key = node.y;
      next = nextOf(node.x);
      if (last.place != kNoPlace && !isBefore(last, slot)) continue;
      [unroll] for (uint j = 0u; j < uint(WINDOW); ++j) {
        if (isBefore(slot, window[j])) {
          WindowSlot moved = window[j];
          window[j] = slot;
          slot = moved;
        }
      }
      // The one that fell out comes in a later walk.
      more = more || slot.place != kNoPlace;
    }
    [unroll] for (uint k = 0u; k < uint(WINDOW); ++k) {
      if (window[k].place != kNoPlace && sum.transmittance > g_readEpsilon) {
        addNode(sum, window[k].place, tile.clip.xy);
        last = window[k];
      }
    }
    more = more && sum.transmittance > g_readEpsilon;
  }
  uint4 rest = uint4(0u, 0u, 0u, 0u);
  if (more) rest = averagedBehind(last, head, tile.clip.xy);
#if TAIL
  rest += spilled;
#endif
  if (rest.w > 0u) {
    float4 tail = tailLight(rest);
    sum.light += tail.rgb * sum.transmittance;
    sum.transmittance *= tail.a;
  }
  result.color = float4(sum.light, 1.0 - sum.transmittance);
  return result;
}
