// The generated character in the light of an engine, by any transparency method.
#pragma once

#include <cstdint>
#include <vector>

#include "light_rig.h"
#include "pelage/headless.h"
#include "pelage/result.h"
#include "pelage/scene.h"

namespace engine_lights {

struct PictureDef {
  uint32_t size = 720;  ///< width and height [pixels], >= 1
  pelage::Transparency method = pelage::Transparency::kWindowed;
  uint32_t samples = 1;  ///< a pixel; see DeviceInfo::sampleCounts
  bool hair = true;      ///< false: the body alone
  LightsOn lights = {};
};

/// The character, its lights and the textures of these on a device of its own.
class LitCharacter {
 public:
  /// \param hairShare  factor on the number of strands, 0.01..1. Errors: those of the device.
  static pelage::Result<LitCharacter> create(pelage::HeadlessDevice& device, float hairShare = 1);
  /// Draws it. Linear color, alpha 0 where there is nothing. Errors: those of the scene and device.
  pelage::Result<pelage::RenderedImage> draw(const PictureDef& def);

 private:
  explicit LitCharacter(pelage::HeadlessDevice& device) : device_(&device) {}
  pelage::Result<void> drawBody(const pelage::View& view, const LightsOn& on,
                                pelage::PassList& list) const;
  /// For Transparency::kTiles: the depth of the body.
  pelage::BufferId depthOf(uint32_t size);

  pelage::HeadlessDevice* device_;
  pelage::Scene scene_;
  std::vector<pelage::HairId> hairs_;
  LightRig rig_;
  pelage::BufferId vertices_ = pelage::BufferId::kInvalid, indices_ = pelage::BufferId::kInvalid;
  uint32_t vertexCount_ = 0, indexCount_ = 0;
  pelage::BufferId depth_ = pelage::BufferId::kInvalid;
  uint32_t depthSize_ = 0;
};

}  // namespace engine_lights
