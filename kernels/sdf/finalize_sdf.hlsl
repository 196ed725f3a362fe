// Sums the crossings along rows and marks the nodes that are inside.
//
// Threads: one a word of 4 nodes, in rows of kRowGroups groups of 64; a group takes as many rows
//          of the grid as fit, or walks along one.
// Reads:   g_sdfCounts; with THREE_AXES g_sdfVotes, g_sdfSurface
// Writes:  g_sdfKeys
//
// A node is inside if more surfaces were entered than left before it. With THREE_AXES two of the
// three axes must agree: a hole or an overlap only affects the axis on which it lies. A key that an
// earlier build made far is unset again. With THREE_AXES parts of the mesh may overlap, and a
// triangle inside another part does not lead out. The path from a node to its nearest triangle
// crosses no other triangle; behind the triangle there is one solid less if the node is at the
// triangle's back, or one more. So the triangle is on the outer surface if the node is in one solid
// and at its back; otherwise the key keeps the distance, which is at most that of the outer
// surface, without a triangle.
//
// Invariant (tests/sdf): no wrong sign further than 1e-4 cell from a closed surface; three axes
// give the same keys as one within the band of a closed surface.
#include "sdf_counts.hlsli"
#include "sdf_record.hlsli"

#if THREE_AXES
// On the surface itself the sign is arbitrary.
static const float kClearlyFront = 1e-3;

// Returns true if a node sees the front of its nearest triangle.
//
// \param node  index without g_sdfNodes.w
bool isAtFront(uint node, uint key) {
  uint index = sdfTriangle(key, g_sdfTriangleBits);
  if (index >= g_sdfTriangleCount) return false;
  SdfClosest closest = closestOf(float3(nodeOfIndex(node)), index);
  return sdfSideOf(sdfOfBuild(), closest, true).distance > kClearlyFront;
}
#endif

groupshared int s_sums[64];

// Inclusive sum over the threads `column` before this one.
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
  uint wordsARow = g_sdfNodes.x / 4u;
  uint rows = g_sdfNodes.y * g_sdfNodes.z;
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
    // For a row longer than the group: the start value of the next part.
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
    for (uint n = 0; n < 4 && active; ++n) {
      uint element = g_sdfNodes.w + 4u * word + n;
      uint before = g_sdfKeys[element];
      uint key = (before & kSdfFar) != 0u ? kSdfUnset : before & kSdfUnset;
      if (inside[n] > 0) {
#if THREE_AXES
        if (key != kSdfUnset && (overlap[n] || isAtFront(4u * word + n, key)))
          key = key | ((1u << g_sdfTriangleBits) - 1u);
#endif
        key = key | kSdfInside;
      }
      if (key != before) g_sdfKeys[element] = key;
    }
    // Waits before the next part writes s_sums.
    GroupMemoryBarrierWithGroupSync();
  }
}
