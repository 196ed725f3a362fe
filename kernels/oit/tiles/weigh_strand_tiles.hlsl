// Finds the visible fragments of pixels: those that light still comes through to. The optical depth
// in front of a fragment is the sum of those of all nearer ones in its pixel, so nothing is sorted.
//
// Threads: four groups of 128 per tile that has hair, 8 threads per pixel; dispatched indirectly.
// Reads:   g_weighRecords, g_weighPixels, g_weighTiles, g_weighFragments, g_weighSegments
// Writes:  g_weighSums, g_weighVisible, g_weighPicture
//
// Of pixels with more than kKept fragments, a histogram of optical depths over the range of depths
// says behind which depth nothing is visible; those before it usually have room in group memory.
//
// Fragments of one depth are ordered by contents, then by index, so the order in which they came
// changes no bit of the picture.
#include "../layouts/strand_tiles_weigh.hlsli"
#include "../pixel_tiles.hlsli"
#define SEGMENT_RECORDS g_weighRecords
#include "strand_tile_counters.hlsli"
#include "strand_tile_fragment.hlsli"
#include "strand_tile_segment.hlsli"
#include "strand_tile_pixel.hlsli"

static const uint kPixels = 16u;  // of a group
static const uint kLanes = 8u;    // of a pixel
static const uint kKept = 48u;
static const uint kKeptRow = kKept + 1u;  // pixels side by side have banks of their own
static const uint kBins = 32u;

groupshared uint s_keys[kPixels * kKeptRow];
groupshared uint s_depths[kPixels * kKeptRow];
groupshared uint s_indices[kPixels * kKeptRow];
// Optical depth in front of visible fragments: 26 bits; above it the place in the tables.
groupshared uint s_visible[kPixels * kKeptRow];
groupshared uint s_bins[kPixels * kBins];
groupshared uint s_nearest[kPixels];
groupshared uint s_farthest[kPixels];
groupshared uint s_counts[kPixels];  // of fragments that may be visible
groupshared uint s_shown[kPixels];   // of those that are
groupshared uint s_begins[kPixels];
groupshared uint s_deep;  // some pixel has more than kKept

// Whether a fragment that ties with another one in depth is in front of it.
bool tiesBefore(uint a, uint b, float2 at) {
  bool reversed = g_weighReversedDepth != 0u;
  uint2 segments = uint2(g_weighSegments[a], g_weighSegments[b]);
  uint2 shapes;
  uint2 colors;
  uint2 materials;
  [unroll] for (uint i = 0u; i < 2u; ++i) {
    uint record = segments[i] >> 1;
    uint4 shape0 = g_weighRecords[kRecordWords * record + 1u];
    uint4 shape1 = g_weighRecords[kRecordWords * record + kRecordWords + 1u];
    StrandSegment segment = segmentAt(record, shape0, shape1, reversed);
    FragmentWords words = wordsAt(record, pointAt(segment, segments[i] & 1u, at, reversed));
    shapes[i] = words.shape;
    colors[i] = words.color;
    materials[i] = shape0.w & kRecordMaterial;
  }
  bool before = segments.x < segments.y;
  if (materials.x != materials.y) before = materials.x < materials.y;
  if (colors.x != colors.y) before = colors.x < colors.y;
  if (shapes.x != shapes.y) before = shapes.x < shapes.y;
  return before;
}

uint saturated(uint front) { return min(front, 1u << 30); }

// Optical depth in front of a fragment, of those in group memory. \param row of the pixel.
uint frontInGroup(uint row, uint count, uint own, float2 at) {
  uint key = s_keys[row + own];
  uint front = 0u;
  uint ties = 0u;
  for (uint i = 0u; i < count; ++i) {
    uint other = s_keys[row + i];
    if (other < key) front += s_depths[row + i];
    ties += other == key ? 1u : 0u;
  }
  if (ties > 1u) {
    for (uint j = 0u; j < count; ++j) {
      if (s_keys[row + j] != key || j == own) continue;
      if (tiesBefore(s_indices[row + j], s_indices[row + own], at)) front += s_depths[row + j];
    }
  }
  return front;
}

// The same of a list. \param begin, end of it.
uint frontInList(uint begin, uint end, uint own, float2 at) {
  uint key = g_weighFragments[own].x;
  uint front = 0u;
  uint ties = 0u;
  for (uint i = begin; i < end; ++i) {
    uint2 other = g_weighFragments[i];
    if (other.x < key) front = saturated(front + other.y);
    ties += other.x == key && other.y != 0u ? 1u : 0u;
  }
  if (ties > 1u) {
    for (uint j = begin; j < end; ++j) {
      uint2 other = g_weighFragments[j];
      if (other.x != key || other.y == 0u || j == own) continue;
      if (tiesBefore(j, own, at)) front = saturated(front + other.y);
    }
  }
  return front;
}

// Bits by which keys of a range are shifted to be bins.
uint shiftOf(uint range) {
  uint top = range > 0u ? firstbithigh(range) : 0u;
  return top > 4u ? top - 4u : 0u;
}

[numthreads(128, 1, 1)]
void weigh_strand_tiles(uint3 group : SV_GroupID, uint lane : SV_GroupIndex) {
  uint cut = opticalCut(g_weighEpsilon);
  TilePixel pixel = tilePixelOf(group, lane / kLanes);
  uint sub = lane % kLanes;
  uint own = lane / kLanes;
  uint row = own * kKeptRow;
  float2 at = float2(pixel.at) + 0.5;
  uint begin = 0u;
  uint end = 0u;
  if (pixel.inRound) {
    uint word = 64u * pixel.tile + pixel.index;
    begin =
        pixel.index == 0u ? g_weighTiles[g_weighTileCount + pixel.tile] : g_weighPixels[word - 1u];
    begin -= g_weighRoundBegin;
    end = g_weighPixels[word] - g_weighRoundBegin;
  }
  if (sub == 0u) {
    s_nearest[own] = 0xffffffffu;
    s_farthest[own] = 0u;
    s_counts[own] = 0u;
    s_shown[own] = 0u;
  }
  for (uint bin = sub; bin < kBins; bin += kLanes) s_bins[own * kBins + bin] = 0u;
  if (lane == 0u) s_deep = 0u;
  GroupMemoryBarrierWithGroupSync();
  bool deep = end - begin > kKept;
  if (deep) InterlockedMax(s_deep, 1u);
  GroupMemoryBarrierWithGroupSync();

  // Fragments behind this depth key are hidden.
  uint last = 0xffffffffu;
  if (s_deep != 0u) {
    if (deep) {
      for (uint i = begin + sub; i < end; i += kLanes) {
        uint2 fragment = g_weighFragments[i];
        if (fragment.y == 0u) continue;
        InterlockedMin(s_nearest[own], fragment.x);
        InterlockedMax(s_farthest[own], fragment.x);
      }
    }
    GroupMemoryBarrierWithGroupSync();
    uint nearest = s_nearest[own];
    bool some = deep && nearest <= s_farthest[own];
    uint shift = some ? shiftOf(s_farthest[own] - nearest) : 0u;
    if (some) {
      for (uint j = begin + sub; j < end; j += kLanes) {
        uint2 fragment = g_weighFragments[j];
        // Rounded down, so that the sums are not too large.
        if (fragment.y != 0u)
          InterlockedAdd(s_bins[own * kBins + ((fragment.x - nearest) >> shift)], fragment.y >> 10);
      }
    }
    GroupMemoryBarrierWithGroupSync();
    if (some) {
      uint sum = 0u;
      for (uint k = 0u; k < kBins; ++k) {
        sum = saturated(sum + saturated(s_bins[own * kBins + k]));
        if (sum > cut >> 10) {
          last = nearest + (((k + 1u) << shift) - 1u);
          // Beyond the range of keys.
          if (last < nearest) last = 0xffffffffu;
          break;
        }
      }
    }
  }

  for (uint i = begin + sub; i < end; i += kLanes) {
    uint2 fragment = g_weighFragments[i];
    if (fragment.y == 0u || fragment.x > last) continue;
    uint slot;
    InterlockedAdd(s_counts[own], 1u, slot);
    if (slot >= kKept) continue;
    s_keys[row + slot] = fragment.x;
    s_depths[row + slot] = fragment.y;
    s_indices[row + slot] = i;
  }
  GroupMemoryBarrierWithGroupSync();
  uint count = s_counts[own];
  bool kept = count <= kKept;
  if (kept) {
    for (uint j = sub; j < count; j += kLanes) {
      uint front = frontInGroup(row, count, j, at);
      if (front >= cut) continue;
      uint slot;
      InterlockedAdd(s_shown[own], 1u, slot);
      s_visible[row + slot] = front | (j << 26);
    }
  }
  GroupMemoryBarrierWithGroupSync();
  // Of pixels that are not kept, all get room.
  if (lane == 0u) {
    uint sum = 0u;
    for (uint k = 0u; k < kPixels; ++k) sum += s_counts[k] <= kKept ? s_shown[k] : s_counts[k];
    uint next = 0u;
    if (sum > 0u) InterlockedAdd(g_weighSums[weighSumsEnd()].x, sum, next);
    for (uint m = 0u; m < kPixels; ++m) {
      s_begins[m] = next;
      next += s_counts[m] <= kKept ? s_shown[m] : s_counts[m];
    }
  }
  GroupMemoryBarrierWithGroupSync();
  uint first = s_begins[own];
  uint place = pixel.at.y * g_weighWidth + pixel.at.x;
  if (kept) {
    for (uint j = sub; j < s_shown[own]; j += kLanes) {
      uint entry = row + (s_visible[row + j] >> 26);
      g_weighVisible[first + j] = uint4(g_weighSegments[s_indices[entry]], place,
                                        s_visible[row + j] & 0x3ffffffu, s_depths[entry]);
    }
  } else {
    for (uint j = begin + sub; j < end; j += kLanes) {
      uint2 fragment = g_weighFragments[j];
      if (fragment.y == 0u || fragment.x > last) continue;
      uint front = frontInList(begin, end, j, at);
      if (front >= cut) continue;
      uint slot;
      InterlockedAdd(s_shown[own], 1u, slot);
      g_weighVisible[first + slot] = uint4(g_weighSegments[j], place, front, fragment.y);
    }
  }
  GroupMemoryBarrierWithGroupSync();
  if (!kept) {
    for (uint k = s_shown[own] + sub; k < count; k += kLanes)
      g_weighVisible[first + k] = uint4(0u, 0u, 0u, 0u);
  }
  if (pixel.inRound && pixel.inside && sub == 0u)
    g_weighPicture[place] = uint2(first, s_shown[own]);
}
