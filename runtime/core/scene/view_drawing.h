// Drawing of a scene's hair.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "oit/oit_views.h"
#include "pelage/scene.h"
#include "pelage/tier.h"
#include "scene/frame_journal.h"
#include "scene/frame_state.h"
#include "scene/hair_internals.h"
#include "scene/hair_simulation.h"
#include "scene/hair_store.h"
#include "shading/strand_colors.h"
#include "shading/strand_depth.h"
#include "shading/strand_draws.h"
#include "shadow/shadow_maps.h"

namespace pelage::detail {

/// \param frame HairStore::frame
DrawnHair drawnHairOf(const HairObject& object, const HairInternals& hair, uint64_t frame);
/// Around the hair where a frame draws it.
Ball ballOfDrawn(const HairObject& object, const HairInternals& hair, uint64_t frame);

/// Notes which target the draws of lists are for: PassList::area and samples.
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
  std::vector<StrandShadowDef> defs;      ///< [map]
  std::vector<OpaqueShadowPlan> opaques;  ///< [map of opaque geometry]
};

/// Draws the hair of a scene in views. Scene documents functions of the same name.
class ViewDrawing {
 public:
  Tier tier = Tier::kWide;
  OitViews oit;
  ShadowMaps shadows;
  StrandColors colors;
  StrandDepths depths;
  std::vector<std::unique_ptr<FrameState>> spareFrames;  ///< for their memory

  ViewDrawing(HairStore& store, FrameJournal& journal, HairSimulation& simulation)
      : store_(store), journal_(journal), simulation_(simulation) {}
  Result<void> draw(const View& view, const Light& light, PassList& list);
  Result<void> draw(const View& view, std::span<const Light> lights,
                    const TransparencySettings& settings, std::vector<PassList>& lists);
  Result<void> drawDepth(const View& view, const HairDepthSettings& settings, PassList& list);
  Result<uint32_t> castShadows(std::span<const Light> lights, PassList& list);
  Result<void> drawCollider(ColliderId id, const View& view, const Light& light,
                            const ColliderLook& look, PassList& list);
  Result<void> drawContacts(HairId id, const View& view, const ContactLook& look, PassList& list);
  TransparencyWork predictWork(const View& view);
  /// \param reason  why lists that have not run cannot any more
  void trim(const char* reason);

 private:
  /// \param list  that the view is drawn into, behind what it has
  Result<DrawnView> begin(const View& view, std::span<const Light> lights,
                          const PassList* list = nullptr);
  Result<void> castHairs(Ball& all);
  Result<void> checkShadows(std::span<const Light> lights, bool draws);
  Result<void> addShadows(DrawnView& frame, PassList& list);

  HairStore& store_;
  FrameJournal& journal_;
  HairSimulation& simulation_;
  // The current draw uses these; they keep their memory.
  std::vector<DrawnHair> drawn_;
  ShadowCast cast_;
  OitPlan plan_;
};

}  // namespace pelage::detail
