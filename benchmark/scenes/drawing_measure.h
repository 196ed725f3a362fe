// Runs a row that draws: what drawing cost, and whether it drew.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "image.h"
#include "pelage/result.h"
#include "scenes/drawing_run.h"
#include "scenes/scene_measure.h"

namespace bench {

/// One row of the results that draw.
struct DrawingResult {
  DrawingRow row;
  pelage::Transparency method = pelage::Transparency::kWindowed;
  uint32_t guides = 0, followHairs = 0;
  FrameFigures figures;
  /// The most of a measured frame: fragments of lists, segments in tiles of tiles; of these without
  /// room.
  uint32_t fragments = 0, spilled = 0;
  uint64_t bytes = 0;    ///< of all buffers at the end
  double meanLight = 0;  ///< of the last picture, over all pixels; NaN where one is not finite
  CopyTimes copies;      ///< beside the frames
  /// By how much the drawing groups take longer than in the row that draws nothing else [us].
  Spread added;
  bool hasAdded = false;  ///< false without that row
  /// The last picture, and with DrawingExtra::kLevelOfDetail how far it is from that row's: PSNR of
  /// sRGB bytes over all pixels [dB].
  sample::ByteImage picture = {};
  double psnr = 0;
  /// [frame] Time in which the host sets positions, waits for the decoder included [us]. Rows that
  /// play have it.
  std::vector<double> showUs = {};
};

/// The passes of the drawing groups together.
Spread drawingTime(const FrameFigures& figures);

/// Runs a row from its first frame, several times where the reference drifts. Lists and tiles grow
/// in the frames that warm up.
pelage::Result<DrawingResult> measureDrawing(Workbench& workbench, CopyReference& reference,
                                             SceneAssets& assets, const DrawingRow& row,
                                             const engine_lights::LightRig& rig,
                                             const DrawingDef& drawing, const MeasureDef& def);

/// Checks a row of a smoke test; the error names what is missing.
pelage::Result<void> checkDrawing(const DrawingResult& result);
/// Compares rows of a smoke test: depth and motion must leave the picture alone, lights of an
/// engine must not. \param results  in the order of drawingRows(), some of them
pelage::Result<void> comparePictures(std::span<const DrawingResult> results);

}  // namespace bench
