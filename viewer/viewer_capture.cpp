// Recordings of the window: pictures of all frames, videos, times of passes.
#include <fmt/format.h>

#include "viewer.h"

namespace viewer {

using pelage::Result;

Result<void> Viewer::openCaptures() {
  if (!options_.frames.empty() || !options_.video.empty()) {
    auto opened =
        options_.video.empty() ? recordPictures(options_.frames) : recordVideo(options_.video);
    if (!opened) return opened.error();
    recording_ = *std::move(opened);
  }
  if (options_.times.empty()) return {};
  auto opened = TimesFile::open(options_.times);
  if (!opened) return opened.error();
  times_.emplace(*std::move(opened));
  return {};
}

// A video where there is ffmpeg, else a folder of pictures.
void Viewer::toggleRecording() {
  if (recording_) {
    endRecording();
    return;
  }
  const bool video = hasFfmpeg();
  auto opened = video ? recordVideo(nextFile(".mp4")) : recordPictures(nextFile(""));
  if (!opened) {
    interface_->say("No recording", opened.error().message);
    return;
  }
  recording_ = *std::move(opened);
  stage_.clock.fixed = true;
  if (!video)
    interface_->say("Pictures instead of a video",
                    "There is no ffmpeg on the PATH, which makes videos. Each frame becomes a "
                    "picture in the folder " +
                        recording_->path().string() + " until F10 is pressed again.");
}

void Viewer::toggleTimes() {
  if (times_) {
    interface_->say("Times of passes", "are in " + times_->path().string());
    times_.reset();
    return;
  }
  auto opened = TimesFile::open(nextFile(".csv"));
  if (opened)
    times_.emplace(*std::move(opened));
  else
    interface_->say("No times", opened.error().message);
}

// The picture of the last frame. Options ask for all of them: then one that cannot be written ends
// the program, as a screenshot of a script does.
Result<void> Viewer::record() {
  if (!recording_ || canvas_->captured().width == 0) return {};
  Result<void> added = recording_->add(canvas_->captured());
  if (added) return added;
  const bool asked = !options_.frames.empty() || !options_.video.empty();
  endRecording();
  if (asked) return added;
  interface_->say("The recording has ended", added.error().message);
  return {};
}

void Viewer::endRecording() {
  if (!recording_) return;
  const std::unique_ptr<Recording> ended = std::move(recording_);
  const Result<void> done = ended->finish();
  stage_.clock.fixed = options_.fixedClock || recorder_.has_value();
  if (!done)
    interface_->say("The recording is incomplete", done.error().message);
  else
    fmt::print("{}: {} pictures\n", ended->path().string(), ended->pictures());
}

}  // namespace viewer
