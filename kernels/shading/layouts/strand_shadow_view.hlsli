// A shadow map of strands, shared by the kernels that write it and those that read it; no
// resources.
//
// A map is width x height texels in a buffer of uint: first a word each, row by row,
//   distance of the nearest hair behind the light's near plane [m], the bits of a float that is not
//   negative; kNoHair where there is none
// and then layerCount words each:
//   optical depth up to the end of layer 0, 1, ... [quanta]; undefined where there is no hair
// Layer i of n ends layerRange ((i + 1) / n)^2 behind the nearest hair; the last one has no end.
//
// The map of a light that hair surrounds is a cube: six such maps, of the directions +x, -x, +y,
// -y, +z and -z from the light, one behind the other.
#ifndef PELAGE_SHADING_LAYOUTS_STRAND_SHADOW_VIEW_HLSLI
#define PELAGE_SHADING_LAYOUTS_STRAND_SHADOW_VIEW_HLSLI

struct StrandShadowView {
  // From a world position p to the map: with w = mapW . (p, 1), texel = mapXY . (p, 1) / w, the
  // middle of the first one at 0.5, and mapZ . (p, 1) is the distance behind the near plane, along
  // the map's axis [m]. mapW is (0, 0, 0, 1) for light that is parallel. A map with another mapW
  // looks along its middle: mapXY / w is half the size there. Of a cube, mapX, mapY and mapW are
  // the offset from the light [m], shadow_faces.hlsli has the rest.
  float4 mapX;
  float4 mapY;
  float4 mapZ;
  float4 mapW;
  uint width;  // of a face [texel]
  uint height;
  uint firstWord;    // of the map in the buffer
  uint layerCount;   // 0: the map has depths only
  float layerRange;  // [m] > 0
  float bias;        // [m] >= 0, times w; hair this close behind the nearest is lit
  float extinction;  // without layers: optical depth per meter of hair [1/m]
  float texelSize;   // edge of a texel where w = 1 [m]
  float tauScale;    // quanta of an optical depth of 1
  float tauQuantum;  // 1 / tauScale
  float maxRadius;   // maximum radius of a fiber [texel]; wider ones count as this
  float nearW;       // w below this is not in the map; > 0
  uint faceCount;    // 1, or 6: a cube
  float across;      // optical depth from side to side of all hair, if it had its mean density
  uint pad1;
  uint pad2;
};

// Texels an axis; words are counted with 32 bits.
static const uint kMaxShadowSize = 8192;
static const uint kMaxShadowLayers = 16;
static const uint kNoHair = 0xffffffffu;

#endif
