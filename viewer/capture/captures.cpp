#include "capture/captures.h"

#include <fmt/format.h>

#include <utility>

namespace viewer {

using pelage::Result;

Result<void> Captures::open() {
  if (!files_.frames.empty() || !files_.video.empty()) {
    auto opened = files_.video.empty() ? recordPictures(files_.frames) : recordVideo(files_.video);
    if (!opened) return opened.error();
    recording_ = *std::move(opened);
  }
  if (files_.times.empty()) return {};
  auto opened = TimesFile::open(files_.times);
  if (!opened) return opened.error();
  times_.emplace(*std::move(opened));
  return {};
}

void Captures::toggleRecording(PlayClock& clock, UserInterface& interface) {
  if (recording_) {
    endRecording(clock, interface);
    return;
  }
  const bool video = hasFfmpeg();
  auto opened = video ? recordVideo(nextFile(".mp4")) : recordPictures(nextFile(""));
  if (!opened) {
    interface.say("No recording", opened.error().message);
    return;
  }
  recording_ = *std::move(opened);
  clock.fixed = true;
  if (!video)
    interface.say("Pictures instead of a video",
                  "There is no ffmpeg on the PATH, which makes videos. Each frame becomes a "
                  "picture in the folder " +
                      recording_->path().string() + " until F10 is pressed again.");
}

void Captures::toggleTimes(UserInterface& interface) {
  if (times_) {
    interface.say("Times of passes", "are in " + times_->path().string());
    times_.reset();
    return;
  }
  auto opened = TimesFile::open(nextFile(".csv"));
  if (opened)
    times_.emplace(*std::move(opened));
  else
    interface.say("No times", opened.error().message);
}

void Captures::addTimes(uint64_t frame, std::span<const pelage::PassTiming> timings) {
  if (times_) times_->add(frame, timings);
}

bool Captures::wantsPicture() {
  if (std::exchange(savesNext_, false) && screenshot_.empty()) screenshot_ = nextFile(".png");
  return !screenshot_.empty() || recording_;
}

Result<void> Captures::take(const sample::ByteImage& picture, PlayClock& clock,
                            UserInterface& interface) {
  if (picture.width == 0) return {};
  if (recording_) {
    if (Result<void> added = recording_->add(picture); !added) {
      endRecording(clock, interface);
      if (!files_.frames.empty() || !files_.video.empty()) return added;
      interface.say("The recording has ended", added.error().message);
    }
  }
  return screenshot_.empty() ? Result<void>() : saveScreenshot(picture, interface);
}

Result<void> Captures::saveScreenshot(const sample::ByteImage& picture, UserInterface& interface) {
  const std::filesystem::path path = std::exchange(screenshot_, {});
  Result<void> written = writeScreenshot(picture, path);
  if (written) {
    fmt::print("{}\n", path.string());
    return written;
  }
  if (scripted_) return written;
  interface.say("No screenshot", written.error().message);
  return {};
}

void Captures::endRecording(PlayClock& clock, UserInterface& interface) {
  if (!recording_) return;
  const std::unique_ptr<Recording> ended = std::move(recording_);
  const Result<void> done = ended->finish();
  clock.fixed = fixedClock_;
  if (!done)
    interface.say("The recording is incomplete", done.error().message);
  else
    fmt::print("{}: {} pictures\n", ended->path().string(), ended->pictures());
}

}  // namespace viewer
