// Finds the visible fragments of pixels: those that light still comes through to. The optical depth
// in front of a fragment is the sum of those of all nearer ones in its pixel.
//
// Threads: groups of 128 for the pixels that groupPixels() says, per tile that has hair; dispatched
//          indirectly.
// Reads:   g_weighRecords, g_weighPixels, g_weighTiles, g_weighFragments
// Writes:  g_weighSums, g_weighVisible, g_weighPicture
//
// A group takes as many of its pixels at a time as group memory has room for. A pixel with more than
// kUnsorted fragments is taken alone, and they are sorted: to compare each with each would take longer.
// Where there are many fragments, a histogram of optical depths over the range of depths says behind
// which depth nothing is visible; those behind it take no room. A pixel that has no room alone is
// walked from front to back, in ranges of depths that have.
//
// Fragments of one depth are ordered by their segments, so the order in which they came changes no bit
// of the picture; more of one depth than there is room for, by the index of the segment alone.
#include "../layouts/strand_tiles_weigh.hlsli"
#include "../../shading/strand_record.hlsli"
#include "../fragment_packing.hlsli"
#include "../pixel_tiles.hlsli"
#include "strand_tile_counters.hlsli"
#include "strand_tile_fragment.hlsli"
#include "strand_tile_pixel.hlsli"

static const uint kLanes = 128u;
static const uint kRoom = 768u;      // fragments
static const uint kUnsorted = 160u;  // of a pixel that is not alone
// Sums of bins have 32 bits for this many.
static const uint kMostBinned = 65536u;
static const uint kBins = 32u;  // of a pixel
static const uint kHidden = 0xffffffffu;
static const uint kNoKey = 0xffffffffu;

groupshared uint2 s_fragments[kRoom];  // depth key, optical depth
groupshared uint s_segments[kRoom];    // see TileFragment
groupshared uint s_fronts[kRoom];      // optical depth in front, or kHidden
// The fragments of a pixel are those from its edge to the next one.
groupshared uint s_edges[kMostPixels + 1u];  // in the list of the round
groupshared uint s_ends[kMostPixels + 1u];   // of those that may be visible
groupshared uint s_last[kMostPixels];        // depth keys behind it are hidden
groupshared uint s_nearest[kMostPixels];
groupshared uint s_farthest[kMostPixels];
groupshared uint s_counts[kMostPixels];
groupshared uint s_shown[kMostPixels];   // visible ones
groupshared uint s_placed[kMostPixels];  // of these, those that are written
groupshared uint s_before[kMostPixels];  // visible ones of the pixels before
// Also prefix sums, of lanes.
groupshared uint s_bins[kMostPixels * kBins];
groupshared uint s_begin;  // of the visible fragments
groupshared uint s_taken;  // fragments in group memory
groupshared uint s_depth;  // in front of a range of depths

TileFragment fragmentAt(uint index) {
  return unpackTileFragment(g_weighFragments[index], g_weighSegmentBits);
}

uint depthOf(TileFragment fragment) {
  uint depth = 0u;
  if (fragment.root > 0u) depth = opticalDepthOf(squared(fragment.root, kTileRoots));
  return depth;
}

void take(uint place, TileFragment fragment) {
  s_fragments[place] = uint2(fragment.key, depthOf(fragment));
  s_segments[place] = fragment.segment;
}

// Whether a segment is in front of another one that has the same depth: by their looks, shapes and
// corners, then by index. These are integers: what is computed twice may differ in its last bit.
bool isBefore(uint one, uint two) {
  bool before = one < two;
  bool same = true;
  for (uint i = 0u; i < 2u * kRecordWords && same; ++i) {
    uint word = kRecordWords - 1u - i / 2u + (i & 1u) * kRecordWords;
    uint4 first = g_weighRecords[kRecordWords * (one >> 1) + word];
    uint4 second = g_weighRecords[kRecordWords * (two >> 1) + word];
    [unroll] for (uint k = 0u; k < 4u; ++k) {
      if (same && first[k] != second[k]) {
        before = first[k] < second[k];
        same = false;
      }
    }
  }
  return before;
}

// \param corner the first pixel of the group.
uint2 pixelAt(uint2 corner, uint own) { return corner + uint2(own & 7u, own >> kTileShift); }

uint placeOf(uint2 at) { return at.y * g_weighWidth + at.x; }

// Optical depth in front of a fragment in group memory, at least cut if it is hidden.
// \param begin, end of the pixel.
uint frontOf(uint own, uint begin, uint end, uint cut) {
  uint key = s_fragments[own].x;
  uint front = 0u;
  uint ties = 0u;
  uint i = begin;
  for (; i + 4u <= end && front < cut; i += 4u) {
    [unroll] for (uint k = 0u; k < 4u; ++k) {
      uint2 other = s_fragments[i + k];
      front += other.x < key ? other.y : 0u;
      ties += other.x == key ? 1u : 0u;
    }
  }
  for (; i < end && front < cut; ++i) {
    uint2 other = s_fragments[i];
    front += other.x < key ? other.y : 0u;
    ties += other.x == key ? 1u : 0u;
  }
  if (ties > 1u) {
    for (uint j = begin; j < end && front < cut; ++j) {
      if (s_fragments[j].x != key || s_fragments[j].y == 0u || j == own) continue;
      if (isBefore(s_segments[j], s_segments[own])) front += s_fragments[j].y;
    }
  }
  return front;
}

// The last pixel from first on, before last, that begins at or before a fragment in group memory.
uint pixelOf(uint fragment, uint first, uint last) {
  uint own = first;
  [unroll] for (uint step = kMostPixels / 2u; step > 0u; step /= 2u) {
    if (own + step < last && s_ends[own + step] - s_ends[first] <= fragment) own += step;
  }
  return own;
}

// Whether a fragment in group memory is in front of another one.
bool isNearer(uint one, uint two) {
  uint first = s_fragments[one].x;
  uint second = s_fragments[two].x;
  bool nearer = first < second;
  if (first == second) nearer = isBefore(s_segments[one], s_segments[two]);
  return nearer;
}

// Orders two places; those from count on are behind all others.
void order(uint one, uint two, uint count) {
  if (two >= count || !isNearer(two, one)) return;
  uint2 fragment = s_fragments[one];
  uint segment = s_segments[one];
  s_fragments[one] = s_fragments[two];
  s_segments[one] = s_segments[two];
  s_fragments[two] = fragment;
  s_segments[two] = segment;
}

// Sorts fragments from front to back (Batcher, "Sorting networks and their applications", 1968; the
// bitonic one, whose first step of each stage compares with the mirrored place).
void sortTaken(uint lane, uint count) {
  for (uint size = 2u; size < 2u * count; size *= 2u) {
    for (uint step = size / 2u; step > 0u; step /= 2u) {
      bool mirrors = 2u * step == size;
      for (uint pair = lane; 2u * pair < size * ((count + size - 1u) / size); pair += kLanes) {
        uint one = 2u * pair - (pair & (step - 1u));
        order(one, mirrors ? one ^ (size - 1u) : one + step, count);
      }
      GroupMemoryBarrierWithGroupSync();
    }
  }
}

// Weighs the fragments of a pixel in group memory, which it sorts.
// \param base optical depth in front of all of these.
void weighSorted(uint lane, uint own, uint count, uint base) {
  uint cut = opticalCut(g_weighEpsilon);
  sortTaken(lane, count);
  uint most = (count + kLanes - 1u) / kLanes;
  uint begin = min(lane * most, count);
  uint end = min(begin + most, count);
  // A sum that is as large as the cut stays there: 128 times the cut is below 2^32.
  uint sum = 0u;
  for (uint i = begin; i < end; ++i) sum = min(sum + min(s_fragments[i].y, cut), cut);
  s_bins[lane] = sum;
  for (uint range = 1u; range < kLanes; range *= 2u) {
    GroupMemoryBarrierWithGroupSync();
    uint others = lane >= range ? s_bins[lane - range] : 0u;
    GroupMemoryBarrierWithGroupSync();
    s_bins[lane] = min(s_bins[lane] + others, cut);
  }
  GroupMemoryBarrierWithGroupSync();
  uint front = base + (lane > 0u ? s_bins[lane - 1u] : 0u);
  uint shown = 0u;
  for (uint j = begin; j < end; ++j) {
    uint depth = s_fragments[j].y;
    bool visible = depth != 0u && front < cut;
    s_fronts[j] = visible ? front : kHidden;
    shown += visible ? 1u : 0u;
    front = min(front + min(depth, cut), cut);
  }
  InterlockedAdd(s_shown[own], shown);
  GroupMemoryBarrierWithGroupSync();
}

// Weighs the fragments of pixels in group memory.
void weighTaken(uint lane, uint first, uint last, uint count) {
  uint cut = opticalCut(g_weighEpsilon);
  for (uint i = lane; i < count; i += kLanes) {
    uint front = kHidden;
    if (s_fragments[i].y != 0u) {
      uint own = pixelOf(i, first, last);
      front = frontOf(i, s_ends[own] - s_ends[first], s_ends[own + 1u] - s_ends[first], cut);
      if (front < cut)
        InterlockedAdd(s_shown[own], 1u);
      else
        front = kHidden;
    }
    s_fronts[i] = front;
  }
  GroupMemoryBarrierWithGroupSync();
}

// Makes room for the visible fragments of pixels.
void makeRoom(uint lane) {
  if (lane < kMostPixels) {
    uint before = 0u;
    uint all = 0u;
    [unroll] for (uint k = 0u; k < kMostPixels; ++k) {
      before += k < lane ? s_shown[k] : 0u;
      all += s_shown[k];
    }
    s_before[lane] = before;
    uint begin = 0u;
    if (lane == 0u) {
      if (all > 0u) InterlockedAdd(g_weighSums[weighSumsEnd()], all, begin);
      s_begin = begin;
    }
  }
  GroupMemoryBarrierWithGroupSync();
}

void writeVisible(uint2 corner, uint own, uint segment, uint front, uint depth) {
  uint slot;
  InterlockedAdd(s_placed[own], 1u, slot);
  g_weighVisible[s_begin + s_before[own] + slot] =
      uint4(segment, placeOf(pixelAt(corner, own)), front, depth);
}

void writeTaken(uint2 corner, uint lane, uint first, uint last, uint count) {
  for (uint i = lane; i < count; i += kLanes) {
    if (s_fronts[i] != kHidden)
      writeVisible(corner, pixelOf(i, first, last), s_segments[i], s_fronts[i], s_fragments[i].y);
  }
  GroupMemoryBarrierWithGroupSync();
}

void takeAll(uint lane, uint begin, uint count) {
  for (uint i = lane; i < count; i += kLanes) take(i, fragmentAt(begin + i));
}

// Takes those that may be visible.
// \param lanes of a pixel.
void takeSome(uint lane, uint lanes, uint first, uint last) {
  uint own = pixelOfLane(lane, lanes);
  if (own < first || own >= last) return;
  uint begin = s_ends[own] - s_ends[first];
  for (uint i = s_edges[own] + (lane & (lanes - 1u)); i < s_edges[own + 1u]; i += lanes) {
    TileFragment fragment = fragmentAt(i);
    if (fragment.root == 0u || fragment.key > s_last[own]) continue;
    uint slot;
    InterlockedAdd(s_counts[own], 1u, slot);
    take(begin + slot, fragment);
  }
}

// Bits by which the keys of a range are shifted to be bins.
uint shiftOf(uint range) {
  uint bits = range > 0u ? firstbithigh(range) + 1u : 0u;
  return bits > 5u ? bits - 5u : 0u;
}

// Finds the depths behind which nothing is visible, and counts what is in front of them.
// \param lanes of a pixel.
void findLast(uint lane, uint lanes) {
  uint cut = opticalCut(g_weighEpsilon);
  uint own = pixelOfLane(lane, lanes);
  uint sub = lane & (lanes - 1u);
  uint begin = s_edges[own] + sub;
  uint end = s_edges[own + 1u];
  for (uint bin = sub; bin < kBins; bin += lanes) s_bins[own * kBins + bin] = 0u;
  if (sub == 0u) {
    s_nearest[own] = 0xffffffffu;
    s_farthest[own] = 0u;
    s_last[own] = 0xffffffffu;
    s_counts[own] = 0u;
  }
  GroupMemoryBarrierWithGroupSync();
  uint nearest = 0xffffffffu;
  uint farthest = 0u;
  for (uint i = begin; i < end; i += lanes) {
    TileFragment fragment = fragmentAt(i);
    if (fragment.root == 0u) continue;
    nearest = min(nearest, fragment.key);
    farthest = max(farthest, fragment.key);
  }
  InterlockedMin(s_nearest[own], nearest);
  InterlockedMax(s_farthest[own], farthest);
  GroupMemoryBarrierWithGroupSync();
  nearest = s_nearest[own];
  farthest = s_farthest[own];
  bool some = nearest <= farthest && s_edges[own + 1u] - s_edges[own] <= kMostBinned;
  uint shift = some ? shiftOf(farthest - nearest) : 0u;
  if (some) {
    for (uint j = begin; j < end; j += lanes) {
      TileFragment fragment = fragmentAt(j);
      // Rounded down, so that the sums are not too large.
      if (fragment.root != 0u)
        InterlockedAdd(s_bins[own * kBins + ((fragment.key - nearest) >> shift)],
                       min(depthOf(fragment), cut) >> 10);
    }
  }
  GroupMemoryBarrierWithGroupSync();
  if (some && sub == 0u) {
    uint sum = 0u;
    for (uint k = 0u; k < kBins && sum <= cut >> 10; ++k) {
      sum += s_bins[own * kBins + k];
      if (sum > cut >> 10) s_last[own] = min(farthest, nearest + (((k + 1u) << shift) - 1u));
    }
  }
  GroupMemoryBarrierWithGroupSync();
  uint counted = 0u;
  for (uint m = begin; m < end; m += lanes) {
    TileFragment fragment = fragmentAt(m);
    counted += fragment.root != 0u && fragment.key <= s_last[own] ? 1u : 0u;
  }
  InterlockedAdd(s_counts[own], counted);
  GroupMemoryBarrierWithGroupSync();
  if (lane <= kMostPixels) {
    uint sum = 0u;
    [unroll] for (uint k = 0u; k < kMostPixels; ++k) sum += k < lane ? s_counts[k] : 0u;
    s_ends[lane] = sum;
  }
  GroupMemoryBarrierWithGroupSync();
  if (lane < kMostPixels) s_counts[lane] = 0u;
  GroupMemoryBarrierWithGroupSync();
}

// Adds to the optical depth in front of the next range; 128 times the cut is below 2^32.
void addDepth(uint depth) { InterlockedAdd(s_depth, min(depth, opticalCut(g_weighEpsilon))); }

// Finds the nearest and the farthest key of a pixel's fragments from a key on.
void findRange(uint lane, uint own, uint from) {
  if (lane == 0u) {
    s_nearest[own] = 0xffffffffu;
    s_farthest[own] = 0u;
  }
  GroupMemoryBarrierWithGroupSync();
  for (uint i = s_edges[own] + lane; i < s_edges[own + 1u]; i += kLanes) {
    TileFragment fragment = fragmentAt(i);
    if (fragment.root == 0u || fragment.key < from) continue;
    InterlockedMin(s_nearest[own], fragment.key);
    InterlockedMax(s_farthest[own], fragment.key);
  }
  GroupMemoryBarrierWithGroupSync();
}

// \return number of the first bins of a range whose fragments have room
uint fittingBins(uint lane, uint own, uint shift) {
  if (lane < kBins) s_bins[lane] = 0u;
  if (lane == 0u) s_taken = 0u;
  GroupMemoryBarrierWithGroupSync();
  for (uint i = s_edges[own] + lane; i < s_edges[own + 1u]; i += kLanes) {
    TileFragment fragment = fragmentAt(i);
    if (fragment.root == 0u || fragment.key < s_nearest[own] || fragment.key > s_farthest[own])
      continue;
    InterlockedAdd(s_bins[(fragment.key - s_nearest[own]) >> shift], 1u);
  }
  GroupMemoryBarrierWithGroupSync();
  uint fitting = 0u;
  uint taken = 0u;
  for (; fitting < kBins; ++fitting) {
    taken += s_bins[fitting];
    if (taken > kRoom) break;
  }
  GroupMemoryBarrierWithGroupSync();
  return fitting;
}

// Takes the nearest fragments of a pixel from a key on that have room.
// \return the last key, kNoKey if there are none; s_taken is 0 if more have it than there is room for
uint takeRange(uint lane, uint own, uint from) {
  findRange(lane, own, from);
  uint nearest = s_nearest[own];
  uint shift = 0u;
  uint fitting = 0u;
  bool narrow = true;
  while (narrow) {
    shift = shiftOf(s_farthest[own] - nearest);
    fitting = fittingBins(lane, own, shift);
    narrow = fitting == 0u && shift > 0u;
    if (narrow && lane == 0u) s_farthest[own] = nearest + (1u << shift) - 1u;
    GroupMemoryBarrierWithGroupSync();
  }
  uint last = nearest;
  if (fitting > 0u && nearest != kNoKey) {
    last = s_farthest[own];
    if (fitting < kBins) last = min(last, nearest + (fitting << shift) - 1u);
    for (uint i = s_edges[own] + lane; i < s_edges[own + 1u]; i += kLanes) {
      TileFragment fragment = fragmentAt(i);
      if (fragment.root == 0u || fragment.key < nearest || fragment.key > last) continue;
      uint slot;
      InterlockedAdd(s_taken, 1u, slot);
      take(slot, fragment);
    }
  }
  GroupMemoryBarrierWithGroupSync();
  return last;
}

// More fragments of one depth than there is room for.
void weighTies(uint2 corner, uint lane, uint own, uint key, uint base) {
  uint cut = opticalCut(g_weighEpsilon);
  uint depth = 0u;
  for (uint i = s_edges[own] + lane; i < s_edges[own + 1u]; i += kLanes) {
    TileFragment fragment = fragmentAt(i);
    if (fragment.key != key || fragment.root == 0u) continue;
    depth = min(depth + depthOf(fragment), cut);
    uint front = base;
    for (uint j = s_edges[own]; j < s_edges[own + 1u] && front < cut; ++j) {
      TileFragment other = fragmentAt(j);
      if (other.key == key && other.segment < fragment.segment) front += depthOf(other);
    }
    if (front >= cut) continue;
    InterlockedAdd(s_shown[own], 1u);
    writeVisible(corner, own, fragment.segment, front, depthOf(fragment));
  }
  addDepth(depth);
}

[numthreads(128, 1, 1)]
void weigh_strand_tiles(uint3 group : SV_GroupID, uint lane : SV_GroupIndex) {
  uint cut = opticalCut(g_weighEpsilon);
  uint pixels = groupPixels();
  TilePixel pixel = tilePixelOf(group, pixels, 0u);
  if (!pixel.inRound) return;
  uint2 corner = pixel.at;
  uint lanes = lanesOfPixel(pixels);
  if (lane <= pixels) {
    // A pixel begins where the one before ends.
    uint word = 64u * pixel.tile + group.z * pixels + lane;
    uint edge = g_weighTiles[g_weighTileCount + pixel.tile];
    if (word > 64u * pixel.tile) edge = g_weighPixels[word - 1u];
    s_edges[lane] = edge - g_weighRoundBegin;
    s_ends[lane] = s_edges[lane];
  }
  GroupMemoryBarrierWithGroupSync();
  bool many = s_edges[pixels] - s_edges[0] > kRoom;
  if (many) findLast(lane, lanes);
  uint first = 0u;
  while (first < pixels) {
    uint last = first + 1u;
    bool sorted = s_ends[last] - s_ends[first] > kUnsorted;
    while (!sorted && last < pixels && s_ends[last + 1u] - s_ends[first] <= kRoom &&
           s_ends[last + 1u] - s_ends[last] <= kUnsorted)
      ++last;
    uint count = s_ends[last] - s_ends[first];
    bool walked = count > kRoom;
    if (lane < kMostPixels) {
      s_shown[lane] = 0u;
      s_placed[lane] = 0u;
    }
    if (walked && lane == 0u) {
      // All get room, as their number is not known before.
      uint begin;
      InterlockedAdd(g_weighSums[weighSumsEnd()], s_edges[last] - s_edges[first], begin);
      s_begin = begin;
      s_before[first] = 0u;
      s_depth = 0u;
    }
    uint from = 0u;
    bool more = true;
    while (more) {
      bool ties = false;
      uint base = 0u;
      uint end = 0u;
      if (walked) {
        end = takeRange(lane, first, from);
        count = s_taken;
        base = s_depth;
        ties = count == 0u && end != kNoKey;
      } else if (many) {
        takeSome(lane, lanes, first, last);
      } else {
        takeAll(lane, s_edges[first], count);
      }
      GroupMemoryBarrierWithGroupSync();
      if (sorted)
        weighSorted(lane, first, count, base);
      else
        weighTaken(lane, first, last, count);
      if (!walked) makeRoom(lane);
      writeTaken(corner, lane, first, last, count);
      more = false;
      if (walked) {
        uint depth = 0u;
        for (uint i = lane; i < count; i += kLanes) depth += s_fragments[i].y;
        if (ties)
          weighTies(corner, lane, first, end, base);
        else
          addDepth(depth);
        GroupMemoryBarrierWithGroupSync();
        from = end + 1u;
        more = s_depth < cut && end != kNoKey;
      }
    }
    if (walked) {
      uint room = s_edges[last] - s_edges[first];
      for (uint k = s_placed[first] + lane; k < room; k += kLanes)
        g_weighVisible[s_begin + k] = uint4(0u, 0u, 0u, 0u);
    }
    if (lane >= first && lane < last) {
      uint2 at = pixelAt(corner, lane);
      if (at.x < g_weighWidth && at.y < g_weighHeight)
        g_weighPicture[placeOf(at)] = uint2(s_begin + s_before[lane], s_shown[lane]);
    }
    GroupMemoryBarrierWithGroupSync();
    first = last;
  }
}
