// Resources for resolving per-pixel linked lists. Group "ppllRead", space1 after OitTiles.
#ifndef PELAGE_OIT_LAYOUTS_PPLL_READ_HLSLI
#define PELAGE_OIT_LAYOUTS_PPLL_READ_HLSLI

#define STRAND_VIEW_REGISTER register(b0, space1)
#include "../../shading/layouts/strand_view.hlsli"

cbuffer PPLLReadConstants : register(b1, space1) {
  // Members of StrandShading, [material]; of model the first one, 4 materials in one.
  uint4 g_readModels[16];
  float4 g_readBodies[64];
  float4 g_readPrimaries[64];
  float4 g_readSecondaries[64];
  float4 g_readFibers[64];
  uint g_readWidth;   // [pixels]
  uint g_readHeight;  // [pixels]
  uint g_readNodeCapacity;
  float g_readEpsilon;  // transmittance that counts as none, 0..1
};

// As in ppll_build.hlsli.
StructuredBuffer<uint> g_readHeads : register(t0, space1);
StructuredBuffer<uint4> g_readNodes : register(t1, space1);
StructuredBuffer<uint4> g_readTail : register(t2, space1);
// Words of all shadow maps.
StructuredBuffer<uint> g_readShadowWords : register(t3, space1);

StrandShading readShading(uint material) {
  uint4 models = g_readModels[material >> 2];
  uint position = material & 3u;
  uint model = position == 0u
                   ? models.x
                   : (position == 1u ? models.y : (position == 2u ? models.z : models.w));
  return shadingFrom(model, g_readBodies[material], g_readPrimaries[material],
                     g_readSecondaries[material], g_readFibers[material]);
}

#endif
