// The lights of this engine: their constants and textures.
#pragma once

#include "depth_map.h"
#include "engine_lights/gpu_structs.h"
#include "pelage/headless.h"
#include "pelage/pass_list.h"
#include "pelage/result.h"

namespace engine_lights {

/// Factors on the lights, and which of their shadows are there.
struct LightsOn {
  float sun = 1, spot = 1, sky = 1;
  bool cascades = true;  ///< false: opaque geometry does not shade the sun
};

/// The textures of the lights, made once.
struct LightRig {
  EngineRig constants;
  pelage::TextureId cascades = pelage::TextureId::kInvalid;
  pelage::TextureId open = pelage::TextureId::kInvalid;  ///< cascades in which nothing is
  pelage::TextureId spot = pelage::TextureId::kInvalid;
  pelage::TextureId irradiance = pelage::TextureId::kInvalid;

  /// Draws the maps of the opaque triangles. Errors: those of the device.
  static pelage::Result<LightRig> create(pelage::HeadlessDevice& device,
                                         const OpaqueGeometry& opaque);
  /// Resources that rig.hlsli reads in the hair's kernels and in the body's.
  std::vector<pelage::NamedResource> resources(const LightsOn& on) const;
};

/// The unit vector towards the sun.
pelage::Float3 sunDirection();

}  // namespace engine_lights
