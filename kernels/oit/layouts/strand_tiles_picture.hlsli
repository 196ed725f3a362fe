// Resources for drawing composited tiles. Group "strandTilesPicture", space1 after OitTiles.
#ifndef PELAGE_OIT_LAYOUTS_STRAND_TILES_PICTURE_HLSLI
#define PELAGE_OIT_LAYOUTS_STRAND_TILES_PICTURE_HLSLI

cbuffer StrandTilesPictureConstants : register(b0, space1) {
  int g_pictureX;  // of the viewport [pixels]
  int g_pictureY;
  uint2 g_pictureSize;   // [pixels]
};

// As g_tilePicture in strand_tiles_composite.hlsli.
StructuredBuffer<uint2> g_picture : register(t0, space1);

#endif
