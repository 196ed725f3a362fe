// Kinds of hair that the sample makes.
#pragma once

#include <cstdint>

#include "pelage/demo/groom.h"
#include "pelage/view.h"

namespace sample {

enum class GroomPreset : uint8_t {
  kParted,    ///< medium-long and slightly wavy, with a side parting
  kStraight,  ///< long and straight
  kCurly,
  kFur,  ///< short, dense, on the whole scalp
  kMohawk,
};

/// How a generated groom is made, coloured and simulated.
struct PresetLook {
  pelage::GroomDef groom;
  pelage::StrandMaterial material;
  float bendLength = 0.08f;  ///< SimulationSettings::bendLength [m]
  float globalStiffness = 0.03f;
  uint32_t followPerGuide = 10;
  float followRadius = 0.004f;  ///< [m]
  float flyaways = 0.03f;       ///< FollowDef::flyaways
};

PresetLook presetLook(GroomPreset preset);

}  // namespace sample
