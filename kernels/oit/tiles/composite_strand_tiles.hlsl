// Composites the strands of a tile from front to back, exactly, in windows of the nearest WINDOW
// fragments, as ppll_read does from lists: all segments are looked through for the nearest
// fragments behind the last one that was composited, those are shaded, and again while light still
// comes through.
//
// Threads: a group of 64 a tile that has hair, a thread a pixel; dispatched indirectly.
// Reads:   g_tileRecords, g_tileBins, g_tileReferences, g_tileCounters, StrandViewConstants,
//          StrandTilesCompositeConstants; with OCCLUDED g_tileDepth
// Writes:  g_tilePicture
//
// Fragments are ordered by depth, then by what they are, then by their place, so that the order in
// which segments came into the tile changes no bit of the picture. The group leaves out segments
// that are nearer than all that its pixels look for, or farther.
//
// Invariant (tests/oit): the picture of ppll_build and ppll_read, within 1/255.
#include "../../layouts/strand_tiles_composite.hlsli"
#define SHADOW_WORDS g_tileShadowWords
#include "../../shading/light_strand.hlsli"
#include "../composite_fragment.hlsli"
#include "strand_tile_counters.hlsli"
#include "strand_tile_segment.hlsli"

// Words as a list's node has them; a free slot is all ones, which no fragment is.
struct TileSlot {
  uint key;
  uint shape;
  uint color;
  uint place;  // the segment's record, times 2, and which triangle
};

static const uint kNoSlot = 0xffffffffu;

groupshared uint s_looking;   // pixels that look for more
groupshared uint s_nearest;   // depth keys between which they look
groupshared uint s_farthest;
groupshared uint s_staged;

TileSlot freeSlot() {
  TileSlot slot;
  slot.key = kNoSlot;
  slot.shape = kNoSlot;
  slot.color = kNoSlot;
  slot.place = kNoSlot;
  return slot;
}

uint materialOfPlace(uint place) {
  return g_tileRecords[kRecordWords * (place >> 1) + 1u].w & kRecordMaterial;
}

bool tiesBefore(TileSlot a, TileSlot b) {
  if (a.shape != b.shape) return a.shape < b.shape;
  if (a.color != b.color) return a.color < b.color;
  if (a.place == kNoSlot || b.place == kNoSlot) return a.place < b.place;
  uint first = materialOfPlace(a.place);
  uint second = materialOfPlace(b.place);
  if (first != second) return first < second;
  return a.place < b.place;
}

bool isBefore(TileSlot a, TileSlot b) {
  bool result = a.key < b.key;
  if (a.key == b.key) result = tiesBefore(a, b);
  return result;
}

[numthreads(64, 1, 1)]
void composite_strand_tiles(uint3 group : SV_GroupID, uint lane : SV_GroupIndex) {
  uint listed = group.y * kTileDispatchRow + group.x;
  // The last row of groups may have more of them than there are tiles: they look at none.
  bool known = listed < g_tileCounters[kTileInstancesWord];
  uint tile = 0u;
  uint count = 0u;
  uint begin = 0u;
  if (known) {
    tile = g_tileBins[2u * g_tileTotal + listed];
    count = g_tileBins[tile];
    begin = g_tileBins[g_tileTotal + tile] - count;
  }
  uint2 place = uint2(lane & 7u, lane >> 3);
  uint2 pixel = uint2(tile % g_tileRowSize, tile / g_tileRowSize) * 8u + place;
  float2 corner = float2(pixel - place);
  uint lines = (1u << place.y) | (256u << place.x);
  bool inside = known && pixel.x < g_tileWidth && pixel.y < g_tileHeight;
  float2 at = float2(pixel) + 0.5;

  Composite sum = emptyComposite();
  TileSlot last = freeSlot();
  bool started = false;
  bool looking = inside;
  // From this depth key on nothing is seen, as in a target that was cleared.
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
        if ((s_places[s].w & lines) != lines) continue;
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
          slot.place = s_places[s].z * 2u + side;
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
    [unroll] for (uint k = 0u; k < uint(WINDOW); ++k) {
      if (window[k].place != kNoSlot && sum.transmittance > g_tileEpsilon) {
        addFragment(sum, tileShading(materialOfPlace(window[k].place)), at, window[k].key,
                    window[k].shape, window[k].color);
        last = window[k];
        started = true;
      }
    }
    // Only a full window has left something out.
    looking = looking && window[WINDOW - 1].place != kNoSlot && sum.transmittance > g_tileEpsilon;
  }
  if (inside)
    g_tilePicture[pixel.y * g_tileWidth + pixel.x] =
        uint2(packHalves(sum.light.rg), packHalves(float2(sum.light.b, 1.0 - sum.transmittance)));
}
