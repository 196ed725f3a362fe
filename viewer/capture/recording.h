// Pictures of the window as files: screenshots, numbered pictures of all frames, videos by ffmpeg.
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>

#include "image.h"
#include "pelage/result.h"

namespace viewer {

/// Writes a picture as PNG, and makes the folder of the file. Errors: a file that cannot be
/// written.
pelage::Result<void> writeScreenshot(const sample::ByteImage& picture,
                                     const std::filesystem::path& path);

/// Takes the pictures of a recording one by one.
class Recording {
 public:
  virtual ~Recording() = default;
  Recording(const Recording&) = delete;
  Recording& operator=(const Recording&) = delete;
  /// Errors: a file that cannot be written; for videos, another size than the first picture's.
  virtual pelage::Result<void> add(const sample::ByteImage& picture) = 0;
  /// Ends the recording. Errors: a video that ffmpeg cannot write.
  virtual pelage::Result<void> finish() = 0;
  const std::filesystem::path& path() const { return path_; }
  uint64_t pictures() const { return pictures_; }

 protected:
  explicit Recording(std::filesystem::path path) : path_(std::move(path)) {}
  std::filesystem::path path_;
  uint64_t pictures_ = 0;
};

/// Writes FOLDER/00001.png and so on. It makes the folder, and overwrites files of these names.
/// Errors: the folder cannot be made.
pelage::Result<std::unique_ptr<Recording>> recordPictures(const std::filesystem::path& folder);

/// Makes a video of 60 pictures a second with ffmpeg, which chooses the format by the file's name.
/// Errors: no ffmpeg on the PATH; ffmpeg cannot be started.
pelage::Result<std::unique_ptr<Recording>> recordVideo(const std::filesystem::path& file);

/// Whether ffmpeg is on the PATH.
bool hasFfmpeg();

/// Returns the first name "pelage-NNNN" with an ending that does not exist in the current folder.
std::filesystem::path nextFile(const std::string& ending);

}  // namespace viewer
