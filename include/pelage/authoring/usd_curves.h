// Simulated hair for other tools: UsdGeomBasisCurves as ASCII .usda, with a time sample a frame.
// docs/bake_outputs.md shows such a file.
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "pelage/result.h"
#include "pelage/types.h"

namespace pelage {

/// The properties that all frames of a file share.
struct UsdCurvesDef {
  std::string name = "hair";  ///< of the prim: letters, digits and _, not a digit first; 1..255
  std::vector<uint32_t> vertexCounts = {};  ///< [strand] at least 2; at least 1 strand
  /// Widths (diameters) of fibers [m], finite, >= 0: one for all, [strand] or [vertex]; empty:
  /// none.
  std::vector<float> widths = {};
  std::vector<uint64_t> strandIds = {};  ///< [strand] below 2^63, as primvars:id; empty: none
  double framesPerSecond = 24;           ///< also the time codes per second; 1e-3..1e6
  int64_t firstFrame = 0;                ///< time code of the first frame, within +-2^40
  /// Writes velocities [m/s]: central differences, and one-sided ones in the first and last frame.
  bool velocities = true;
};

/// Makes the checks of UsdCurvesWriter::create().
Result<void> validate(const UsdCurvesDef& def);

/// Writes a file frame by frame; memory is that of three frames, and 32 bytes a frame. The same
/// input gives the same bytes; numbers have the digits that give the same float when read.
///
/// The file appears under its name in close(). Until then there are `<path>.partial` and, with
/// velocities, `<path>.velocities.partial`, which are removed with a writer that was not closed.
///
/// Threads: one at a time, which has `threads` - 1 others write text with it in append().
class UsdCurvesWriter {
 public:
  /// Errors: a field of `def` out of range, a file that cannot be created. \param threads  that
  /// write the text of a frame together, each some 4096 vertices at a time; they change no byte.
  static Result<UsdCurvesWriter> create(const std::filesystem::path& path, UsdCurvesDef def,
                                        uint32_t threads = 1);
  UsdCurvesWriter(UsdCurvesWriter&&) noexcept;
  UsdCurvesWriter& operator=(UsdCurvesWriter&&) noexcept;
  ~UsdCurvesWriter();

  /// Adds the next frame. \param positions [m] of all vertices, strand by strand from the root, in
  /// a world with y up. Errors: another number of positions, a value that is not finite, a full
  /// disk.
  Result<void> append(std::span<const Float3> positions);
  /// Completes the file; append() and close() are errors from then on. Errors: no frame was added,
  /// a full disk, a file that cannot be renamed.
  Result<void> close();

 private:
  struct Impl;
  explicit UsdCurvesWriter(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

/// A file of a shot that was written in parts.
struct UsdClip {
  std::string file;         ///< relative to the root file, with /; without @ and control characters
  int64_t firstFrame = 0;   ///< UsdCurvesDef::firstFrame of the part
  uint64_t frameCount = 0;  ///< at least 1
};

/// Writes a root file and its manifest, `<stem>.manifest.usda` beside it, that show the parts of a
/// shot as one prim: a USD value-clip set. The parts stay as they are, and load when they are
/// shown. \param def that of the parts; firstFrame is not read \param clips at least 1, ascending,
/// without gaps. Velocities are one-sided where parts meet. Errors: a def or a clip out of range, a
/// file that cannot be written.
Result<void> saveUsdClips(const std::filesystem::path& path, const UsdCurvesDef& def,
                          std::span<const UsdClip> clips);

}  // namespace pelage
