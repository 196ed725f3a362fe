// Pictures of all frames: numbered PNG files, or a video by ffmpeg.
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>

#include "image.h"
#include "pelage/result.h"

namespace viewer {

/// Takes the pictures of a recording, one after the other.
class Recording {
 public:
  virtual ~Recording() = default;
  Recording(const Recording&) = delete;
  Recording& operator=(const Recording&) = delete;
  /// Errors: a file that cannot be written; of a video another size than the first picture's.
  virtual pelage::Result<void> add(const sample::ByteImage& picture) = 0;
  /// Ends it. Errors: a video that ffmpeg cannot write.
  virtual pelage::Result<void> finish() = 0;
  const std::filesystem::path& path() const { return path_; }
  uint64_t pictures() const { return pictures_; }

 protected:
  explicit Recording(std::filesystem::path path) : path_(std::move(path)) {}
  std::filesystem::path path_;
  uint64_t pictures_ = 0;
};

/// Writes FOLDER/00001.png and so on; the folder is made. Files of these names are written over.
/// Errors: the folder cannot be made.
pelage::Result<std::unique_ptr<Recording>> recordPictures(const std::filesystem::path& folder);

/// Gives the pictures to ffmpeg, which makes a video of them, of any kind that it knows by the
/// file's name: 60 pictures a second. Errors: no ffmpeg on the PATH, which the message says; it
/// cannot be started.
pelage::Result<std::unique_ptr<Recording>> recordVideo(const std::filesystem::path& file);

/// Whether recordVideo() has its ffmpeg.
bool hasFfmpeg();

/// The first "pelage-NNNN" with this ending in the current folder that is not there yet.
std::filesystem::path nextFile(const std::string& ending);

}  // namespace viewer
