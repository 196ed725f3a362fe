// What drawing knows of a hair object, and the rooms that draw.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "oit/oit_views.h"
#include "pelage/scene.h"
#include "pelage/tier.h"
#include "scene/hair_internals.h"
#include "shading/strand_colors.h"
#include "shading/strand_depth.h"
#include "shading/strand_draws.h"
#include "shadow/shadow_maps.h"

namespace pelage::detail {

/// \param frame DrawRooms::frame
DrawnHair drawnHairOf(const HairObject& object, const HairInternals& hair, uint64_t frame);
/// Around the hair where a frame draws it.
Ball ballOfDrawn(const HairObject& object, const HairInternals& hair, uint64_t frame);

/// Notes which viewport the draws of lists are for: PassList::area.
void setArea(std::span<PassList> lists, const View& view);

Ball ballAround(const Ball& a, const Ball& b);
/// At least as large, and the same for radii that differ little.
float steadyRadius(float radius);

ShadowedHair shadowedHairOf(const HairObject& object, const HairInternals& hair, uint64_t frame);
void setShadow(StrandViewConstants& constants, uint32_t index, const StrandShadowView& map);
void setOpaqueShadow(StrandViewConstants& constants, uint32_t index, const OpaqueShadow& map,
                     uint32_t firstWord);

/// Shadow maps that a draw takes, before anything has changed.
struct ShadowCast {
  std::vector<ShadowedHair> hairs;
  std::vector<size_t> lights;        ///< [map] index of the light
  std::vector<size_t> opaqueLights;  ///< [map of opaque geometry] likewise
  ShadowPlan plan;
};

/// The rooms that draw, and the frame that they draw in.
struct DrawRooms {
  uint64_t frame = 1;  ///< simulate() begins another one
  Tier tier = Tier::kWide;
  OitViews oit;
  ShadowMaps shadows;
  StrandColors colors;
  StrandDepths depths;
  std::vector<std::unique_ptr<PassList>> spareLists;  ///< of frames, for their memory

  void trim(const RoomBuffers& room, const char* reason) {
    oit.trim(room, reason);
    shadows.trim(room, reason);
    colors.trim(room, reason);
    depths.trim(room, reason);
  }
};

}  // namespace pelage::detail
