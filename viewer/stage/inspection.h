// Draws the view of errors of one side of a stage.
#pragma once

#include <cstdint>

#include "pelage/frame.h"
#include "pelage/scene.h"
#include "stage/inspection_look.h"
#include "stage/pixel_inspection.h"
#include "stage/strand_inspection.h"

namespace viewer {

class Inspection {
 public:
  /// Adds draws of SDF surfaces in place of meshes. \param list the first one of a view.
  static pelage::Result<void> drawSurfaces(const Inspected& what, const pelage::ColliderLook& look,
                                           const pelage::View& view, pelage::PassList& list);
  /// Sets the look of the next frame. A change forgets the figures; a look without passes removes
  /// the buffers.
  void follow(const InspectionLook& look, pelage::Scene& scene);
  /// Adds views of its own to a frame, after those that drew the hair.
  pelage::Result<void> draw(const Inspected& what, const pelage::View& view, pelage::Frame& frame);
  /// Reads the figures of the last frame, every some frames. Errors: those of `read`.
  pelage::Result<void> measure(const pelage::BufferReader& read);
  const InspectionFigures& figures() const { return figures_; }
  /// Removes the buffers, and forgets the figures.
  void clear(pelage::Scene& scene);

 private:
  InspectionLook look_;
  uint64_t frames_ = 0;  // since the look changed
  StrandInspection strands_;
  OverdrawInspection overdraw_;
  TileInspection tiles_;
  InspectionFigures figures_;
};

}  // namespace viewer
