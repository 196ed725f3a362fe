// Shows how much hair the tiles of a transparency method have, over the hair.
#pragma once

#include "pelage/frame.h"
#include "pelage/scene.h"
#include "pelage/transparency.h"
#include "stage/inspection_look.h"

namespace viewer_kernels {
struct DrawValuesBindings;
struct TileCountsBindings;
}  // namespace viewer_kernels

namespace viewer {

class TileInspection {
 public:
  /// Adds a view behind that of the hair, which was drawn last. Methods without tiles, and views
  /// without hair, get none.
  pelage::Result<void> draw(const InspectionLook& look, pelage::Scene& scene,
                            const pelage::View& view, pelage::Frame& frame);
  /// Takes what the last frame counted; `known` is false before the first one.
  pelage::Result<InspectionFigures> measure(const pelage::BufferReader& read) const;
  /// Removes the buffers.
  void clear(pelage::Scene& scene);

 private:
  void makeBuffers(pelage::ResourceTable& table, uint64_t tiles);
  static pelage::Result<void> count(const pelage::TransparencyTiles& tiles, uint64_t pixels,
                                    const viewer_kernels::DrawValuesBindings& drawn,
                                    const viewer_kernels::TileCountsBindings& counts,
                                    pelage::PassList& list);

  pelage::BufferId counts_ = pelage::BufferId::kInvalid, summary_ = pelage::BufferId::kInvalid;
  bool drew_ = false;  // in the last frame
};

}  // namespace viewer
