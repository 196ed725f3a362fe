#include "groom_presets.h"

namespace sample {

namespace {

// Chestnut hair whose bind shape hangs already.
PresetLook parted() {
  PresetLook look;
  look.material.rootColor = {0.030f, 0.014f, 0.009f};
  look.material.tipColor = {0.165f, 0.083f, 0.040f};
  look.material.fiberRadius = 115e-6f;
  look.material.primaryStrength = 0.09f;
  look.material.primaryExponent = 50;
  look.material.secondaryStrength = 0.9f;
  look.material.secondaryExponent = 14;
  return look;
}

PresetLook straight() {
  PresetLook look = parted();
  look.groom.style = pelage::HairStyle::kSweptBack;
  look.groom.length = 0.34f;
  look.groom.lengthVariation = 0.06f;
  look.groom.verticesPerStrand = 32;
  look.groom.curlRadius = 0;
  look.groom.clumpStrength = 0.25f;
  look.groom.noise = 0.002f;
  look.material.rootColor = {0.012f, 0.008f, 0.007f};
  look.material.tipColor = {0.040f, 0.024f, 0.018f};
  look.material.primaryStrength = 0.16f;
  look.material.primaryExponent = 90;
  look.bendLength = 0.12f;
  return look;
}

// Lit as dielectric fibers are.
PresetLook curly() {
  PresetLook look = parted();
  look.groom.length = 0.24f;
  look.groom.lengthVariation = 0.25f;
  look.groom.verticesPerStrand = 64;
  look.groom.curlRadius = 0.010f;
  look.groom.curlFrequency = 32;
  look.groom.clumpCount = 420;
  look.groom.clumpStrength = 0.55f;
  look.groom.volume = 0.016f;
  look.material.rootColor = {0.20f, 0.055f, 0.020f};
  look.material.tipColor = {0.46f, 0.17f, 0.055f};
  look.material.model = pelage::ShadingModel::kFiber;
  look.material.scatteredShare = 0.35f;
  look.globalStiffness = 0.10f;
  look.followRadius = 0.003f;
  return look;
}

PresetLook fur() {
  PresetLook look = parted();
  look.groom.strandCount = 9000;
  look.groom.verticesPerStrand = 8;
  look.groom.length = 0.022f;
  look.groom.lengthVariation = 0.4f;
  look.groom.lift = 1.1f;
  look.groom.hairline = -0.02f;
  look.groom.curlRadius = 0.0004f;
  look.groom.curlFrequency = 60;
  look.groom.clumpCount = 1500;
  look.groom.clumpStrength = 0.3f;
  look.groom.noise = 0.002f;
  look.material.rootColor = {0.10f, 0.070f, 0.045f};
  look.material.tipColor = {0.62f, 0.52f, 0.38f};
  look.material.fiberRadius = 70e-6f;
  look.globalStiffness = 0.3f;
  look.followPerGuide = 8;
  look.followRadius = 0.002f;
  return look;
}

PresetLook mohawk() {
  PresetLook look = parted();
  look.groom.strandCount = 1600;
  look.groom.style = pelage::HairStyle::kSweptBack;
  look.groom.stripWidth = 0.035f;
  look.groom.length = 0.10f;
  look.groom.lift = 1.5f;
  look.groom.comb = 3;
  look.groom.droop = 1;
  look.groom.curlRadius = 0.001f;
  look.groom.clumpCount = 60;
  look.groom.clumpStrength = 0.6f;
  look.material.rootColor = {0.16f, 0.026f, 0.010f};
  look.material.tipColor = {0.55f, 0.10f, 0.030f};
  look.bendLength = 0.3f;
  look.globalStiffness = 0.2f;
  look.followRadius = 0.003f;
  return look;
}

}  // namespace

PresetLook presetLook(GroomPreset preset) {
  switch (preset) {
    case GroomPreset::kStraight:
      return straight();
    case GroomPreset::kCurly:
      return curly();
    case GroomPreset::kFur:
      return fur();
    case GroomPreset::kMohawk:
      return mohawk();
    case GroomPreset::kParted:
      break;
  }
  return parted();
}

}  // namespace sample
