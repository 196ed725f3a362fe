// Resources of import_sdf. Group "importSdf", all in space0.
#ifndef PELAGE_SDF_LAYOUTS_IMPORT_SDF_HLSLI
#define PELAGE_SDF_LAYOUTS_IMPORT_SDF_HLSLI

// Bits of a key that a mesh would have the triangle in. With as many, codes are exact floats.
static const uint kImportTriangleBits = 6;

cbuffer ImportSdfConstants : register(b0, space0) {
  uint g_importNodeCount;     // first: decision 0008
  uint g_importFirst;         // element of node 0 in g_importDistances
  uint g_importFirstKey;      // and in g_importKeys
  float g_importCellsAMeter;  // 1 / cell size [1/m]
  float g_importBand;         // of the keys [cell]
  float g_importFarRange;     // likewise
  uint g_importPad0;
  uint g_importPad1;
};

// [node], x fastest: distance [m], negative inside.
StructuredBuffer<float> g_importDistances : register(t0, space0);
RWStructuredBuffer<uint> g_importKeys : register(u0, space0);

#endif
