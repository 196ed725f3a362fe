// Resources of sample_strand_colors. Group "strandColors", all in space0.
#ifndef PELAGE_SHADING_LAYOUTS_STRAND_COLORS_HLSLI
#define PELAGE_SHADING_LAYOUTS_STRAND_COLORS_HLSLI

cbuffer StrandColorsConstants : register(b0, space0) {
  uint g_colorsGuideCount;   // elements of g_strandUvs; first: decision 0008
  uint g_colorsVertexCount;  // vertices per strand
  float g_colorsTexels;      // of mip level 0, along the longer side
  float g_colorsLastLevel;   // of the mip levels
  float g_colorsLodBias;     // levels
  float g_colorsSpread;      // factor on the distance between roots: guides that are not drawn
  float g_colorsPixelSize;   // size of a pixel where clip w is 1 [m]
  float g_colorsUnused;
  float4 g_colorsClipW;      // row of the matrix that gives clip w
};

// [guide][vertex]: world position [m].
StructuredBuffer<float4> g_colorsPositions : register(t0, space0);
// [guide]: x and y UV of the root, z distance between neighboring roots [m], w change of the UV
// along the surface [1/m].
StructuredBuffer<float4> g_strandUvs : register(t1, space0);
// The engine's, with its mip levels; alpha multiplies the opacity.
Texture2D<float4> g_strandTexture : register(t2, space0);
SamplerState g_strandSampler : register(s0, space0);
// [guide][2]: the UV as the bits of two floats, then linear rgba as two words of two 16-bit unorms.
RWStructuredBuffer<uint2> g_strandColors : register(u0, space0);

#endif
