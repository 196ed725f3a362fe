// A fragment of a strand in the list of its pixel: its segment, depth key and opacity. Optical depths
// are sums of integers, which no order of strands changes: units of 2^-20, to the base 2.
#ifndef PELAGE_OIT_TILES_STRAND_TILE_FRAGMENT_HLSLI
#define PELAGE_OIT_TILES_STRAND_TILE_FRAGMENT_HLSLI

// Bits of the root of an opacity.
static const uint kTileRootBits = 10u;
static const uint kTileRoots = 1023u;
// Bits of depth keys that are not the same for all, see depthKey().
static const uint kTileKeyBits = 30u;

struct TileFragment {
  uint key;      // of its depth, without the lowest bits that have no room
  uint root;     // of its opacity, 0..kTileRoots
  uint segment;  // its first record, times 2, plus the index of the triangle
};

// \param segmentBits that indices of segments have, 24..31: keys lose one for each beyond 24.
uint2 packTileFragment(TileFragment fragment, uint segmentBits) {
  uint lowBits = 32u - segmentBits;
  uint key = (fragment.key & ((1u << kTileKeyBits) - 1u)) >> (segmentBits - 24u);
  return uint2((key << (kTileRootBits - lowBits)) | (fragment.root >> lowBits),
               (fragment.root << segmentBits) | fragment.segment);
}

TileFragment unpackTileFragment(uint2 words, uint segmentBits) {
  uint lowBits = 32u - segmentBits;
  uint highBits = kTileRootBits - lowBits;
  TileFragment fragment;
  fragment.key = words.x >> highBits;
  fragment.root = ((words.x & ((1u << highBits) - 1u)) << lowBits) | (words.y >> segmentBits);
  fragment.segment = words.y & ((1u << segmentBits) - 1u);
  return fragment;
}

static const float kOpticalUnit = 1048576.0;
// No light comes through this.
static const float kOpaqueDepth = 32.0;

// \param alpha 0..1 \return at least 1 for an alpha of fragment_packing.hlsli that is not 0
uint opticalDepthOf(float alpha) {
  float through = 1.0 - alpha;
  return uint((through > 0.0 ? min(-log2(through), kOpaqueDepth) : kOpaqueDepth) * kOpticalUnit +
              0.5);
}

float transmittanceOfDepth(uint depth) { return exp2(float(depth) * (-1.0 / kOpticalUnit)); }

// The optical depth behind which nothing is looked for. \param epsilon transmittance, 0..1
uint opticalCut(float epsilon) {
  return uint(clamp(-log2(max(epsilon, 1e-9)), 0.0, 30.0) * kOpticalUnit + 0.5);
}

#endif
