// Resources for lighting the visible fragments of strands. Group "strandTilesComposite".
#ifndef PELAGE_OIT_LAYOUTS_STRAND_TILES_COMPOSITE_HLSLI
#define PELAGE_OIT_LAYOUTS_STRAND_TILES_COMPOSITE_HLSLI

#define STRAND_VIEW_REGISTER register(b0, space0)
#include "../../shading/layouts/strand_view.hlsli"

cbuffer StrandTilesCompositeConstants : register(b1, space0) {
  // Members of StrandShading, [material]; of model the first one, 4 materials in one.
  uint4 g_tileModels[16];
  float4 g_tileBodies[64];
  float4 g_tilePrimaries[64];
  float4 g_tileSecondaries[64];
  float4 g_tileFibers[64];
  uint g_tileWidth;    // [pixels]
  uint g_tileSumsEnd;  // index behind the sums of blocks
  uint g_tileStride;   // threads of the dispatch
  uint g_tilePad0;
};

// As in strand_tiles.hlsli and strand_tiles_weigh.hlsli.
StructuredBuffer<uint4> g_tileRecords : register(t0, space0);
StructuredBuffer<uint2> g_tileSums : register(t1, space0);
// Words of all shadow maps.
StructuredBuffer<uint> g_tileShadowWords : register(t2, space0);
RWStructuredBuffer<uint4> g_tileVisible : register(u0, space0);

StrandShading tileShading(uint material) {
  uint4 models = g_tileModels[material >> 2];
  uint index = material & 3u;
  uint model =
      index == 0u ? models.x : (index == 1u ? models.y : (index == 2u ? models.z : models.w));
  return shadingFrom(model, g_tileBodies[material], g_tilePrimaries[material],
                     g_tileSecondaries[material], g_tileFibers[material]);
}

#endif
