// Hair on the ray from a light through a point; no resources.
#ifndef PELAGE_SHADING_STRAND_LIGHT_PATH_HLSLI
#define PELAGE_SHADING_STRAND_LIGHT_PATH_HLSLI

// Optical depth that stands for hair without an end.
static const float kEndlessHair = 64.0;

// Optical depth of the hair behind a point that no map has.
static const float kOpenHair = 16.0;

struct StrandLightPath {
  bool known;           // the point is in the light's map
  float transmittance;  // of the hair between light and point, 0..1
  float front;          // its optical depth
  float behind;         // that of the hair beyond the point
  float across;         // that from side to side of all hair
};

// The path of a light without a map: to the lit edge of dense hair.
StrandLightPath openLightPath() {
  StrandLightPath path;
  path.known = false;
  path.transmittance = 1.0;
  path.front = 0.0;
  path.behind = kOpenHair;
  path.across = kOpenHair;
  return path;
}

#endif
