// Sums the crossings along the axes y and z, of meshes that need the vote of three axes.
//
// Threads: 8 a column of words of 4 nodes, each for a part of its length, 16 columns a group; all
//          of axis y, then all of axis z, in rows of kRowGroups groups.
// Reads:   g_sdfCounts
// Writes:  g_sdfVotes
#include "sdf_counts.hlsli"
#include "sdf_work.hlsli"

static const uint kParts = 8;

groupshared int4 s_parts[kParts * kSummedColumns];

[numthreads(128, 1, 1)]
void count_sdf_columns(uint3 group : SV_GroupID, uint lane : SV_GroupIndex) {
  uint wordsARow = g_sdfNodes.x / 4u;
  uint words = wordsARow * g_sdfNodes.y * g_sdfNodes.z;
  uint groupsOfY = (wordsARow * g_sdfNodes.z + kSummedColumns - 1u) / kSummedColumns;
  uint index = indexOfGroup(group);
  bool alongZ = index >= groupsOfY;
  uint column = (alongZ ? index - groupsOfY : index) * kSummedColumns + lane % kSummedColumns;
  uint part = lane / kSummedColumns;
  uint columns = wordsARow * (alongZ ? g_sdfNodes.y : g_sdfNodes.z);
  uint count = alongZ ? g_sdfNodes.z : g_sdfNodes.y;
  uint stride = alongZ ? wordsARow * g_sdfNodes.y : wordsARow;
  uint layer = column / wordsARow;
  uint first = alongZ ? column : column + layer * wordsARow * (g_sdfNodes.y - 1u);
  uint axis = alongZ ? 1u : 0u;
  uint length = (count + kParts - 1u) / kParts;
  uint begin = min(part * length, count);
  uint end = min(begin + length, count);
  if (column >= columns) end = begin;

  int4 sum = int4(0, 0, 0, 0);
  for (uint i = begin; i < end; ++i)
    sum += crossingsOf(g_sdfCounts[(axis + 1u) * words + first + i * stride]);
  s_parts[lane] = sum;
  GroupMemoryBarrierWithGroupSync();
  int4 inside = int4(0, 0, 0, 0);
  for (uint before = 0; before < part; ++before)
    inside += s_parts[before * kSummedColumns + lane % kSummedColumns];
  for (uint k = begin; k < end; ++k) {
    inside += crossingsOf(g_sdfCounts[(axis + 1u) * words + first + k * stride]);
    uint4 votes = uint4(voteOf(inside.x), voteOf(inside.y), voteOf(inside.z), voteOf(inside.w));
    g_sdfVotes[axis * words + first + k * stride] =
        votes.x | (votes.y << 8) | (votes.z << 16) | (votes.w << 24);
  }
}
