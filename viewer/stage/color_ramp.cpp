#include "stage/color_ramp.h"

#include <algorithm>

namespace viewer {

using pelage::Float3;

const ColorRamp kSignedRamp = {{{{0.01f, 0.06f, 0.60f},
                                 {0.06f, 0.25f, 0.50f},
                                 {0.35f, 0.35f, 0.35f},
                                 {0.60f, 0.22f, 0.03f},
                                 {0.60f, 0.02f, 0.01f}}}};
const ColorRamp kDepthRamp = {{{{0.12f, 0.13f, 0.14f},
                                {0.45f, 0.35f, 0.04f},
                                {0.60f, 0.26f, 0.01f},
                                {0.60f, 0.08f, 0.01f},
                                {0.60f, 0.005f, 0.02f}}}};
const ColorRamp kCountRamp = {{{{0.01f, 0.01f, 0.10f},
                                {0.01f, 0.10f, 0.45f},
                                {0.02f, 0.45f, 0.15f},
                                {0.60f, 0.50f, 0.02f},
                                {0.60f, 0.02f, 0.01f}}}};
const ColorRamp kKindRamp = {{{{0.05f, 0.09f, 0.16f},
                               {0.05f, 0.09f, 0.16f},
                               {0.05f, 0.09f, 0.16f},
                               {0.60f, 0.25f, 0.02f},
                               {0.60f, 0.25f, 0.02f}}}};
const ColorRamp kDetailRamp = {{{{0.03f, 0.06f, 0.22f},
                                 {0.05f, 0.24f, 0.30f},
                                 {0.10f, 0.50f, 0.14f},
                                 {0.50f, 0.36f, 0.03f},
                                 {0.60f, 0.10f, 0.01f}}}};

Float3 colorAt(const ColorRamp& ramp, float low, float high, float value) {
  const float share = (value - low) / (high - low);
  const size_t last = ramp.colors.size() - 1;
  const float at = share > 0 ? std::min(share, 1.0f) * static_cast<float>(last) : 0;
  const size_t first = std::min(static_cast<size_t>(at), last - 1);
  const Float3 &a = ramp.colors[first], &b = ramp.colors[first + 1];
  const float t = at - static_cast<float>(first);
  return {a.x + (b.x - a.x) * t, a.y + (b.y - a.y) * t, a.z + (b.z - a.z) * t};
}

}  // namespace viewer
