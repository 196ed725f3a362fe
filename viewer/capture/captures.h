// The files that a session writes: screenshots, a recording of all frames, times of passes.
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <span>
#include <utility>

#include "capture/pass_times.h"
#include "capture/recording.h"
#include "image.h"
#include "interface/user_interface.h"
#include "pelage/headless.h"
#include "pelage/result.h"
#include "stage/stage.h"

namespace viewer {

struct CaptureFiles {
  std::filesystem::path frames;  ///< folder for the pictures of all frames; empty: none
  std::filesystem::path video;   ///< file for a video of all frames; empty: none
  std::filesystem::path times;   ///< CSV for the times of all passes; empty: none
};

class Captures {
 public:
  /// \param scripted a screenshot that cannot be written is an error, not a message.
  /// \param fixedClock whether the clock is fixed while nothing is recorded.
  Captures(CaptureFiles files, bool scripted, bool fixedClock)
      : files_(std::move(files)), scripted_(scripted), fixedClock_(fixedClock) {}
  /// Opens the files. Errors: those of recordPictures(), recordVideo() and TimesFile::open().
  pelage::Result<void> open();
  /// Begins a recording on a fixed clock, or ends it: a video where there is ffmpeg, else a folder
  /// of pictures.
  void toggleRecording(PlayClock& clock, UserInterface& interface);
  /// Begins a file of times, or ends it.
  void toggleTimes(UserInterface& interface);
  void addTimes(uint64_t frame, std::span<const pelage::PassTiming> timings);
  /// Saves the picture of this frame.
  void saveFrame(std::filesystem::path file) { screenshot_ = std::move(file); }
  /// Saves the picture of the next frame, under the next number.
  void saveNextFrame() { savesNext_ = true; }
  /// Whether take() needs the picture of this frame. Call it once a frame.
  bool wantsPicture();
  /// Takes the picture of a frame that was drawn; without a size there is none yet. Errors: a file
  /// that cannot be written, for a recording of CaptureFiles and for screenshots of a script.
  pelage::Result<void> take(const sample::ByteImage& picture, PlayClock& clock,
                            UserInterface& interface);
  void endRecording(PlayClock& clock, UserInterface& interface);

 private:
  pelage::Result<void> saveScreenshot(const sample::ByteImage& picture, UserInterface& interface);
  CaptureFiles files_;
  bool scripted_, fixedClock_;
  bool savesNext_ = false;
  std::filesystem::path screenshot_;  // of this frame; empty: none
  std::unique_ptr<Recording> recording_;
  std::optional<TimesFile> times_;
};

}  // namespace viewer
