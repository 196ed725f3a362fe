// Resources for compositing layers of fragments. Group "hybridRead", space1 after OitTiles.
#ifndef PELAGE_OIT_LAYOUTS_HYBRID_READ_HLSLI
#define PELAGE_OIT_LAYOUTS_HYBRID_READ_HLSLI

cbuffer HybridReadConstants : register(b0, space1) {
  float2 g_layersOrigin;  // offset of the viewport [pixels]
  uint g_layersWidth;     // [pixels]
  uint g_layersHeight;    // [pixels]
  uint g_layersQuads;     // a quarter of the fragments that a pixel keeps
  uint g_layersPad0;
  uint g_layersPad1;
  uint g_layersPad2;
};

// As in hybrid_colors.hlsli, four words in one.
StructuredBuffer<uint4> g_layerColors : register(t0, space1);
StructuredBuffer<uint4> g_layerTail : register(t1, space1);

#endif
