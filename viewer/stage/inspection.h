// Draws what a view of errors shows, with kernels of the viewer's own.
#pragma once

#include <cstdint>
#include <map>
#include <span>
#include <vector>

#include "demo_scene.h"
#include "pelage/frame.h"
#include "pelage/scene.h"
#include "stage/inspection_look.h"
#include "stage/tile_inspection.h"

namespace viewer_kernels {
struct DrawValuesConstants;
}

namespace viewer {

/// What is inspected.
struct Inspected {
  pelage::Scene* scene = nullptr;
  const sample::DemoScene* demo = nullptr;  ///< in the scene
  double seconds = 0;                       ///< of DemoScene::pose()
  /// Colliders of all hair beside its own.
  std::span<const pelage::CapsuleCollider> others = {};
};

class Inspection {
 public:
  /// Adds what stands in for meshes: SDF surfaces. \param list the first one of a view.
  static pelage::Result<void> drawSurfaces(const Inspected& what, const pelage::View& view,
                                           pelage::PassList& list);
  /// Adds views of its own to a frame, behind those that have drawn it.
  pelage::Result<void> draw(const InspectionLook& look, const Inspected& what,
                            const pelage::View& view, pelage::Frame& frame);
  /// Takes what the last frame measured. \param read reads a buffer back.
  pelage::Result<void> measure(const InspectionLook& look, const pelage::BufferReader& read);
  const InspectionFigures& figures() const { return figures_; }
  /// Forgets the figures: another value, or other hair.
  void forget() { figures_ = {}; }
  /// Removes the buffers.
  void clear(pelage::Scene& scene);

 private:
  struct Hair {
    pelage::BufferId records = pelage::BufferId::kInvalid;
    pelage::BufferId summary = pelage::BufferId::kInvalid;
    pelage::BufferId restLengths = pelage::BufferId::kInvalid;
    pelage::BufferId colliders = pelage::BufferId::kInvalid;
    uint32_t posed = 0;  ///< strands of the last frame
  };
  Hair& hairOf(const Inspected& what, size_t index);
  pelage::Result<void> drawStrands(const InspectionLook& look, const Inspected& what,
                                   const pelage::View& view, pelage::PassList& list);
  static pelage::Result<void> drawValues(const InspectionLook& look,
                                         const pelage::HairObject& object, const Hair& hair,
                                         viewer_kernels::DrawValuesConstants constants,
                                         const pelage::View& view, pelage::PassList& list);
  static pelage::Result<void> drawStrands(const pelage::HairObject& object, const Hair& hair,
                                          const viewer_kernels::DrawValuesConstants& constants,
                                          const pelage::DrawState& state, pelage::PassList& list);
  pelage::Result<void> countStrands(const Inspected& what, const pelage::HairObject& object,
                                    const Hair& hair, viewer_kernels::DrawValuesConstants constants,
                                    const pelage::View& view, pelage::PassList& list) const;
  pelage::Result<void> drawOverdraw(const InspectionLook& look, const Inspected& what,
                                    const pelage::View& view, pelage::Frame& frame);
  pelage::Result<void> measureOverdraw(const pelage::BufferReader& read);
  static pelage::Result<void> pose(const InspectionLook& look, const Inspected& what, size_t index,
                                   Hair& hair, pelage::PassList& list);
  static pelage::Result<void> measureStretch(const InspectionLook& look, const Inspected& what,
                                             size_t index, const Hair& hair,
                                             pelage::PassList& list);
  static pelage::Result<void> measurePenetration(const InspectionLook& look, const Inspected& what,
                                                 size_t index, Hair& hair, pelage::PassList& list);
  static pelage::Result<void> drawSlice(const InspectionLook& look, const Inspected& what,
                                        const pelage::View& view, pelage::PassList& list);

  std::map<pelage::HairId, Hair> hairs_;
  pelage::BufferId counts_ = pelage::BufferId::kInvalid, sums_ = pelage::BufferId::kInvalid;
  TileInspection tiles_;
  InspectionFigures figures_;
};

}  // namespace viewer
