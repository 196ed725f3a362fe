#include "groom_presets.h"

namespace sample {

namespace {

// Chestnut hair whose bind shape hangs already, lit as dielectric fibers are.
PresetLook parted() {
  PresetLook look;
  look.groom.clumpLengthVariation = 0.15f;
  look.groom.clumpTaper = 0.2f;
  look.groom.hairlineFade = 0.014f;
  look.material.rootColor = {0.018f, 0.009f, 0.006f};
  look.material.tipColor = {0.110f, 0.052f, 0.026f};
  look.material.colorVariation = 0.25f;
  look.material.fiberRadius = 115e-6f;
  look.material.tipRadiusRatio = 0.15f;
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
  look.material.rootColor = {0.008f, 0.006f, 0.005f};
  look.material.tipColor = {0.022f, 0.014f, 0.011f};
  look.material.longitudinalRoughness = 0.2f;
  look.bendLength = 0.12f;
  return look;
}

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
  look.material.rootColor = {0.060f, 0.016f, 0.004f};
  look.material.tipColor = {0.200f, 0.058f, 0.012f};
  look.material.longitudinalRoughness = 0.35f;
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
  look.material.rootColor = {0.060f, 0.040f, 0.022f};
  look.material.tipColor = {0.50f, 0.37f, 0.20f};
  look.material.longitudinalRoughness = 0.45f;
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
  look.material.rootColor = {0.070f, 0.009f, 0.003f};
  look.material.tipColor = {0.340f, 0.050f, 0.008f};
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
