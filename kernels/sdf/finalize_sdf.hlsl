// Sums the crossings along rows and marks the nodes that are inside.
//
// Threads: one a word of 4 nodes, in rows of kGroupsARow groups of 64; a group has as many rows of
//          the grid as fit it, or one, which it goes along.
// Reads:   g_sdfCounts; with THREE_AXES g_sdfVotes, g_sdfSurface
// Writes:  g_sdfKeys, g_sdfFlood, g_sdfWork
//
// A node is inside when more surfaces were entered than left before it. With THREE_AXES two of the
// three axes have to say so: a hole or an overlap deceives the one axis on which it lies.
// Inside nodes that the band did not reach are listed for the flood. A key that an earlier build
// made far is unset first.
// With THREE_AXES parts of the mesh may overlap, and a triangle that another part swallows is no way
// out. On the way to its nearest triangle a node crosses no other one: behind it there is one solid
// less, when the node is at the triangle's back, or one more. So the triangle is on the outer
// surface when the node is in one solid and at its back; else the node is listed, too.
//
// Invariant (tests/kernel): no wrong sign further than 1e-4 cell from a closed surface; three axes
// give the same keys as one within the band of a closed surface.
#include "sdf_counts.hlsli"
#include "sdf_flood.hlsli"
#if THREE_AXES
#include "sdf_way_out.hlsli"
#endif

groupshared int s_sums[64];

// Inclusive, of the threads `column` before this one.
int sumOfRow(int value, uint column, uint lane, uint columns) {
  s_sums[lane] = value;
  GroupMemoryBarrierWithGroupSync();
  for (uint step = 1; step < columns; step <<= 1) {
    int before = 0;
    if (column >= step) before = s_sums[lane - step];
    GroupMemoryBarrierWithGroupSync();
    value += before;
    s_sums[lane] = value;
    GroupMemoryBarrierWithGroupSync();
  }
  return value;
}

[numthreads(64, 1, 1)]
void finalize_sdf(uint3 group : SV_GroupID, uint lane : SV_GroupIndex) {
  uint wordsARow = g_fieldNodes.x / 4u;
  uint rows = g_fieldNodes.y * g_fieldNodes.z;
  uint columns = min(wordsARow, 64u);
  uint rowsAGroup = 64u / columns;
  uint local = lane / columns;
  uint column = lane - local * columns;
  uint row = indexOfGroup(group) * rowsAGroup + local;
  bool counts = local < rowsAGroup && row < rows;
#if THREE_AXES
  uint words = wordsARow * rows;
#endif
  int carry = 0;
  for (uint start = 0; start < wordsARow; start += 64u) {
    uint x = start + column;
    bool active = counts && x < wordsARow;
    uint word = row * wordsARow + x;
    int4 inside = int4(0, 0, 0, 0);
    if (active) inside = crossingsOf(g_sdfCounts[word]);
    inside.y += inside.x;
    inside.z += inside.y;
    inside.w += inside.z;
    int sum = carry + sumOfRow(inside.w, column, lane, columns);
    inside += sum - inside.w;
    // Of a row longer than the group, what the next part starts with.
    carry += s_sums[63];
#if THREE_AXES
    bool4 overlap = bool4(false, false, false, false);
    if (active) {
      uint votes = g_sdfVotes[word] + g_sdfVotes[words + word];
      for (uint i = 0; i < 4; ++i) {
        uint all = voteOf(inside[i]) + ((votes >> (8u * i)) & 15u);
        inside[i] = isVotedInside(all) ? 1 : 0;
        overlap[i] = isVotedOverlap(all);
      }
    }
#endif
    uint4 keys = uint4(0u, 0u, 0u, 0u);
    uint4 before = keys;
    uint listed = 0u;
    if (active) {
      for (uint i = 0; i < 4; ++i) {
        uint key = g_sdfKeys[g_fieldNodes.w + 4u * word + i];
        before[i] = key;
        key = (key & kSdfFar) != 0u ? kSdfUnset : key & kSdfUnset;
        if (inside[i] > 0) {
          bool lists = key == kSdfUnset;
#if THREE_AXES
          if (!lists) lists = overlap[i] || isAtFront(4u * word + i, key);
          if (lists) key = kEntryKey | (key & kSdfUnset);
#endif
          if (lists) listed += 1u;
          key = key | kSdfInside;
        }
        keys[i] = key;
      }
    }
    uint entry = reserveEntries(listed, lane);
    if (active) {
      for (uint i = 0; i < 4; ++i) {
        uint key = keys[i];
        // Keys of the band have no kSdfFar.
        if (isEntryKey(key)) {
#if THREE_AXES
          uint own = sdfTriangle(key, g_fieldTriangleBits);
          if (entry < g_floodCapacity) g_sdfFlood[floodElement(0u, entry)] = own;
#endif
          key = listNode(4u * word + i, entry);
          entry += 1u;
        }
        if (key != before[i]) g_sdfKeys[g_fieldNodes.w + 4u * word + i] = key;
      }
    }
  }
}
