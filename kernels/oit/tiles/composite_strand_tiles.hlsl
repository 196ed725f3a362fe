// Composites the strands of a tile from front to back, exactly, in windows of the nearest WINDOW
// fragments, as ppll_read does from lists: it searches all segments for the nearest fragments
// behind the last one that was composited, shades those, and repeats while light still comes
// through.
//
// Threads: a group of 64 per tile that has hair, one thread per pixel; dispatched indirectly.
// Reads:   g_tileRecords, g_tileBins, g_tileReferences, g_tileCounters, StrandViewConstants,
//          StrandTilesCompositeConstants; with OCCLUDED g_tileDepth
// Writes:  g_tilePicture
//
// Fragments are ordered by depth, then by contents, then by index, so the order in which segments
// came into the tile changes no bit of the picture. The group skips segments that are nearer than
// everything its pixels need, or farther.
//
// Invariant (tests/oit): the picture of ppll_build and ppll_read, within 1/255.
#include "../layouts/strand_tiles_composite.hlsli"
#define SHADOW_WORDS g_tileShadowWords
#include "../../shading/light_strand.hlsli"
#include "../composite_fragment.hlsli"
#include "../pixel_tiles.hlsli"
#include "strand_tile_counters.hlsli"
#include "strand_tile_segment.hlsli"

// Words as in a node of a list; a free slot is all ones, which no fragment has.
struct TileSlot {
  uint key;
  uint shape;
  uint color;
  uint index;  // the segment's record, times 2, plus the index of the triangle
};

static const uint kNoSlot = 0xffffffffu;

groupshared uint s_looking;  // pixels that need more
groupshared uint s_nearest;  // range of depth keys that they need
groupshared uint s_farthest;
groupshared uint s_staged;

TileSlot freeSlot() {
  TileSlot slot;
  slot.key = kNoSlot;
  slot.shape = kNoSlot;
  slot.color = kNoSlot;
  slot.index = kNoSlot;
  return slot;
}

uint materialOfStrand(uint index) {
  return g_tileRecords[kRecordWords * (index >> 1) + 1u].w & kRecordMaterial;
}

// Returns the UV of the root; 0 without STRAND_UV.
float2 uvOfStrand(uint index) {
  float2 uv = float2(0.0, 0.0);
#if STRAND_UV
  uv = unpackUv(g_tileRecords[kRecordWords * (index >> 1) + 2u].w);
#endif
  return uv;
}

bool tiesBefore(TileSlot a, TileSlot b) {
  if (a.shape != b.shape) return a.shape < b.shape;
  if (a.color != b.color) return a.color < b.color;
  if (a.index == kNoSlot || b.index == kNoSlot) return a.index < b.index;
  uint first = materialOfStrand(a.index);
  uint second = materialOfStrand(b.index);
  if (first != second) return first < second;
  return a.index < b.index;
}

bool isBefore(TileSlot a, TileSlot b) {
  bool result = a.key < b.key;
  if (a.key == b.key) result = tiesBefore(a, b);
  return result;
}

[numthreads(64, 1, 1)]
void composite_strand_tiles(uint3 group : SV_GroupID, uint lane : SV_GroupIndex) {
  uint listed = group.y * kTileDispatchRow + group.x;
  // The last row of groups may extend beyond the tiles: these groups do nothing.
  bool known = listed < g_tileCounters[kTileInstancesWord];
  uint tile = 0u;
  uint count = 0u;
  uint begin = 0u;
  if (known) {
    tile = g_tileBins[2u * g_tileTotal + listed];
    count = g_tileBins[tile];
    begin = g_tileBins[g_tileTotal + tile] - count;
  }
  uint2 index = uint2(lane & (kTileEdge - 1u), lane >> kTileShift);
  uint2 pixel = uint2(tile % g_tileRowSize, tile / g_tileRowSize) * kTileEdge + index;
  float2 corner = float2(pixel - index);
  uint lines = (1u << index.y) | (256u << index.x);
  bool inside = known && pixel.x < g_tileWidth && pixel.y < g_tileHeight;
  float2 at = float2(pixel) + 0.5;

  Composite sum = emptyComposite();
  TileSlot last = freeSlot();
  bool started = false;
  bool looking = inside;
  // Nothing is visible from this depth key on, as in a cleared target.
  uint behind = depthKey(g_reversedDepth != 0u ? 0.0 : 1.0, g_reversedDepth != 0u);
#if OCCLUDED
  if (inside)
    behind = depthKey(g_tileDepth[pixel.y * g_tileWidth + pixel.x], g_reversedDepth != 0u);
#endif

  // Each walk composites a full window, or is the last one.
  for (uint walk = 0u; walk <= count; ++walk) {
    GroupMemoryBarrierWithGroupSync();
    if (lane == 0u) {
      s_looking = 0u;
      s_nearest = kNoSlot;
      s_farthest = 0u;
    }
    GroupMemoryBarrierWithGroupSync();
    if (looking) {
      InterlockedMax(s_looking, 1u);
      InterlockedMin(s_nearest, started ? last.key : 0u);
    }
    GroupMemoryBarrierWithGroupSync();
    if (s_looking == 0u) break;

    TileSlot window[WINDOW];
    [unroll] for (uint i = 0u; i < uint(WINDOW); ++i) window[i] = freeSlot();
    for (uint first = 0u; first < count; first += kStagedSegments) {
      GroupMemoryBarrierWithGroupSync();
      if (lane == 0u) {
        s_staged = 0u;
        s_farthest = 0u;
      }
      GroupMemoryBarrierWithGroupSync();
      if (looking) InterlockedMax(s_farthest, min(behind, window[WINDOW - 1].key));
      GroupMemoryBarrierWithGroupSync();
      if (first + lane < count) {
        TileSegment segment = loadSegment(g_tileReferences[begin + first + lane], corner);
        if (segment.lines != 0u && segment.keys.y >= s_nearest) {
          if (segment.keys.x <= s_farthest) {
            uint slot;
            InterlockedAdd(s_staged, 1u, slot);
            stageSegment(slot, segment);
          }
        }
      }
      GroupMemoryBarrierWithGroupSync();
      uint staged = looking ? s_staged : 0u;
      for (uint s = 0u; s < staged; ++s) {
        if ((s_segments[s].w & lines) != lines) continue;
        uint2 keys = s_keys[s].xy;
        if (keys.x >= behind || keys.x > window[WINDOW - 1].key) continue;
        if (started && keys.y < last.key) continue;
        float2 w = float2(s_ends[2u * s].x, s_ends[2u * s + 1u].x);
        SegmentView seen = viewSegment(s_corners[2u * s], s_corners[2u * s + 1u], w, at);
        [unroll] for (uint side = 0u; side < 2u; ++side) {
          if (!isCovered(seen, side, w)) continue;
          SegmentView exact =
              viewSegment(s_exactCorners[2u * s], s_exactCorners[2u * s + 1u], w, at);
          SegmentPoint found = pointAt(s, cornerAreas(exact, side));
          if (!(found.coverage > 0.0) || found.key >= behind) continue;
          if (found.key > window[WINDOW - 1].key || (started && found.key < last.key)) continue;
          FragmentWords words = wordsAt(s, found);
          if (!(alphaOfShape(words.shape) > 0.0)) continue;
          TileSlot slot;
          slot.key = found.key;
          slot.shape = words.shape;
          slot.color = words.color;
          slot.index = s_segments[s].z * 2u + side;
          if (started && !isBefore(last, slot)) continue;
          [unroll] for (uint j = 0u; j < uint(WINDOW); ++j) {
            if (isBefore(slot, window[j])) {
              TileSlot moved = window[j];
              window[j] = slot;
              slot = moved;
            }
          }
        }
      }
    }
    // Only a full window may have left something out.
    looking = looking && window[WINDOW - 1].index != kNoSlot;
    // The nearest one leaves the window each time, so that the lighting is in the code once, and
    // the window is in registers: an engine's lights took 411 ms instead of 20 on OpenGL (H200).
    for (uint k = 0u; k < uint(WINDOW); ++k) {
      TileSlot nearest = window[0];
      [unroll] for (uint m = 0u; m + 1u < uint(WINDOW); ++m) window[m] = window[m + 1u];
      window[WINDOW - 1] = freeSlot();
      if (nearest.index == kNoSlot || !(sum.transmittance > g_tileEpsilon)) break;
      addFragment(sum, tileShading(materialOfStrand(nearest.index)), at, nearest.key, nearest.shape,
                  nearest.color, uvOfStrand(nearest.index));
      last = nearest;
      started = true;
    }
    looking = looking && sum.transmittance > g_tileEpsilon;
  }
  if (inside)
    g_tilePicture[pixel.y * g_tileWidth + pixel.x] =
        uint2(packHalves(sum.light.rg), packHalves(float2(sum.light.b, 1.0 - sum.transmittance)));
}
