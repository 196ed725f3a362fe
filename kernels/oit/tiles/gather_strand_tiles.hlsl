// Adds up the light of the visible fragments of pixels, in integers: no order of them changes a bit.
//
// Threads: groups of 128 for the pixels that groupPixels() says, per tile that has hair; dispatched
//          indirectly.
// Reads:   g_weighTiles, g_weighSums, g_weighVisible, g_weighPicture
// Writes:  g_weighPicture
#include "../layouts/strand_tiles_weigh.hlsli"
#include "../pixel_tiles.hlsli"
#include "../../shading/strand_record.hlsli"
#include "strand_tile_counters.hlsli"
#include "strand_tile_fragment.hlsli"
#include "strand_tile_pixel.hlsli"

// [pixel][channel]: whole units of light, and 2^-24 of them.
groupshared uint s_whole[3 * kMostPixels];
groupshared uint s_parts[3 * kMostPixels];
groupshared uint s_depth[kMostPixels];

static const float kParts = 16777216.0;
// Optical depth that is as good as any larger one; 128 times that is below 2^32.
static const uint kMostDepth = 33554431u;

void addLight(uint channel, uint whole, uint parts) {
  InterlockedAdd(s_whole[channel], whole);
  InterlockedAdd(s_parts[channel], parts);
}

float lightAt(uint channel) {
  return float(s_whole[channel]) + float(s_parts[channel]) * (1.0 / kParts);
}

[numthreads(128, 1, 1)]
void gather_strand_tiles(uint3 group : SV_GroupID, uint lane : SV_GroupIndex) {
  if (lane < 3u * kMostPixels) {
    s_whole[lane] = 0u;
    s_parts[lane] = 0u;
  }
  if (lane < kMostPixels) s_depth[lane] = 0u;
  GroupMemoryBarrierWithGroupSync();
  uint pixels = groupPixels();
  uint lanes = lanesOfPixel(pixels);
  uint own = pixelOfLane(lane, lanes);
  TilePixel pixel = tilePixelOf(group, pixels, own);
  uint place = pixel.at.y * g_weighWidth + pixel.at.x;
  if (pixel.inRound && pixel.inside) {
    uint2 range = g_weighPicture[place];
    uint3 whole = uint3(0u, 0u, 0u);
    uint3 parts = uint3(0u, 0u, 0u);
    uint depth = 0u;
    for (uint i = lane % lanes; i < range.y; i += lanes) {
      uint4 entry = g_weighVisible[range.x + i];
      // Halves end there; what is not a number counts as none.
      float3 light = asfloat(entry.xyz);
      light = float3(light.x > 0.0 ? min(light.x, 65000.0) : 0.0,
                     light.y > 0.0 ? min(light.y, 65000.0) : 0.0,
                     light.z > 0.0 ? min(light.z, 65000.0) : 0.0);
      float3 units = floor(light);
      whole += uint3(units);
      parts += uint3((light - units) * kParts);
      whole += parts >> 24;
      parts &= 0xffffffu;
      depth = min(depth + entry.w, kMostDepth);
    }
    addLight(3u * own, whole.r, parts.r);
    addLight(3u * own + 1u, whole.g, parts.g);
    addLight(3u * own + 2u, whole.b, parts.b);
    InterlockedAdd(s_depth[own], depth);
  }
  GroupMemoryBarrierWithGroupSync();
  // Tiles without room are empty; those of other rounds are left alone.
  bool written = pixel.inRound;
  if (pixel.known) written = written || g_weighTiles[pixel.tile] == 0u;
  if (lane % lanes == 0u && pixel.inside && written) {
    float3 sum = float3(lightAt(3u * own), lightAt(3u * own + 1u), lightAt(3u * own + 2u));
    g_weighPicture[place] = uint2(
        packHalves(sum.rg), packHalves(float2(sum.b, 1.0 - transmittanceOfDepth(s_depth[own]))));
  }
}
