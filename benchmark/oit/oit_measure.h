// Run time, memory and error of a kind of transparency.
#pragma once

#include <optional>
#include <span>
#include <string>
#include <vector>

#include "oit/classic_list.h"
#include "oit/fragment_reference.h"
#include "oit/hair_scene.h"
#include "simulation/copy_reference.h"

namespace bench {

struct OitMethod {
  const char* name;
  std::optional<pelage::Transparency> kind;  ///< nothing: the classic baseline
  uint32_t samples = 1;                      ///< of a pixel of the target
  bool writesDepth = false;                  ///< of hair: a second frame over the first one differs
};

/// All of them; the baseline, which ratios refer to, is the first one.
std::span<const OitMethod> oitMethods();

/// One row of results.
struct OitRow {
  std::string scene, viewName;
  const char* method = "";
  uint32_t samples = 1, width = 0, height = 0;
  double opacity = 0;
  PictureError error;
  /// Medians over the frames [ms]: what the method makes before it lights a fragment; what lights
  /// and composites; shadow maps; all three. Negative where the device has no timestamps.
  double build = 0, resolve = 0, shadow = 0, total = 0;
  double resolveRatio = 0;  ///< over the baseline's; 0 without one
  uint64_t bytes = 0;       ///< of the method's buffers
  uint64_t fragments = 0, spilled = 0;
  double layersMean = 0;
  uint32_t layersMax = 0, rowStep = 1;
  uint64_t hairPixels = 0;  ///< of the rows that errors are of
  CopyTimes copies;         ///< beside the frames
};

struct OitCase {
  HairScene& scene;
  CopyReference& copies;
  pelage::View view;  ///< of one sample
  const ExactPicture& exact;
};

/// How often a case is drawn.
struct OitFrameCounts {
  int frames = 8;    ///< that are timed
  int together = 4;  ///< of them without a pause, in which a GPU's clocks would fall
};

/// Renders and times; the frames run again where the copy drifts. \param row has the names of the
/// case. Errors: those of the device and of Scene::draw().
pelage::Result<void> measureOit(const OitCase& what, const OitMethod& method,
                                const OitFrameCounts& counts, OitRow& row);

pelage::Result<void> appendOitCsv(const std::string& path, const OitRow& row,
                                  const pelage::DeviceInfo& device, const std::string& commit);

}  // namespace bench
