// The signed bytes of g_sdfCounts.
#ifndef PELAGE_SDF_SDF_COUNTS_HLSLI
#define PELAGE_SDF_SDF_COUNTS_HLSLI

// The four crossings of a word. A negative byte has borrowed one from the byte above it;
// subtracting it returns the borrow.
int4 crossingsOf(uint word) {
  int4 crossings;
  crossings.x = int(word << 24) >> 24;
  word = (word - asuint(crossings.x)) >> 8;
  crossings.y = int(word << 24) >> 24;
  word = (word - asuint(crossings.y)) >> 8;
  crossings.z = int(word << 24) >> 24;
  word = (word - asuint(crossings.z)) >> 8;
  crossings.w = int(word << 24) >> 24;
  return crossings;
}

// The vote of one axis on a node that is in `solids` parts of the mesh: bit 0, that it is inside;
// bit 2, that it is inside more than one. The votes of three axes fit side by side into their sum.
uint voteOf(int solids) { return (solids > 0 ? 1u : 0u) | (solids > 1 ? 4u : 0u); }
bool isVotedInside(uint votes) { return (votes & 3u) > 1u; }
bool isVotedOverlap(uint votes) { return ((votes >> 2) & 3u) > 1u; }

#endif
