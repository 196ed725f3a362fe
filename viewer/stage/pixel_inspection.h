// Views of errors that count for each pixel or tile: overdraw, and the tiles of a transparency
// method.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "pelage/frame.h"
#include "pelage/scene.h"
#include "stage/inspection_look.h"
#include "stage/strand_inspection.h"

namespace viewer {

/// A buffer with a count for each pixel or tile, and a summary that the host reads.
class PixelCounts {
 public:
  /// Makes the buffers; another number of counts makes them again. \param words of the summary.
  void make(const std::string& name, uint64_t count, uint64_t words, pelage::ResourceTable& table);
  pelage::BufferId counts() const { return counts_; }
  pelage::BufferId summary() const { return summary_; }
  bool isMade() const { return summary_ != pelage::BufferId::kInvalid; }
  /// Reads the summary. Errors: those of `read`.
  pelage::Result<std::vector<uint32_t>> readSummary(const pelage::BufferReader& read) const;
  /// Removes the buffers.
  void clear(pelage::Scene& scene);

 private:
  pelage::BufferId counts_ = pelage::BufferId::kInvalid, summary_ = pelage::BufferId::kInvalid;
  uint64_t words_ = 0;
};

/// Fragments of each pixel.
class OverdrawInspection {
 public:
  /// Adds two views: one counts the fragments of strands, the other one shows the counts.
  pelage::Result<void> draw(const InspectionLook& look, const Inspected& what,
                            const pelage::View& view, StrandInspection& strands,
                            pelage::Frame& frame);
  /// Reads the counts of the last frame; `known` is false before the first one. Errors: those of
  /// `read`.
  pelage::Result<InspectionFigures> measure(const pelage::BufferReader& read) const;
  void clear(pelage::Scene& scene) { counts_.clear(scene); }

 private:
  PixelCounts counts_;
};

/// Amount of hair in each tile of a transparency method.
class TileInspection {
 public:
  /// Adds a view after the view of the hair, which must be the last one. Methods without tiles, and
  /// views without hair, get none.
  pelage::Result<void> draw(const InspectionLook& look, pelage::Scene& scene,
                            const pelage::View& view, pelage::Frame& frame);
  /// Reads the counts of the last frame; `known` is false before the first one. Errors: those of
  /// `read`.
  pelage::Result<InspectionFigures> measure(const pelage::BufferReader& read) const;
  void clear(pelage::Scene& scene);

 private:
  PixelCounts counts_;
  bool drew_ = false;  // in the last frame
};

}  // namespace viewer
