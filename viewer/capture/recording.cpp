#include "capture/recording.h"

#include <fmt/format.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <iterator>
#include <sstream>
#include <string_view>
#include <system_error>
#include <vector>

#include "png_file.h"

namespace viewer {

using pelage::Error;
using pelage::ErrorCode;
using pelage::Result;
using Path = std::filesystem::path;

pelage::Result<void> writeScreenshot(const sample::ByteImage& picture,
                                     const std::filesystem::path& path) {
  std::error_code error;
  if (path.has_parent_path()) std::filesystem::create_directories(path.parent_path(), error);
  return sample::writePng(path.string(), picture);
}

namespace {

constexpr const char* kFfmpeg = "ffmpeg";

// Finds a program on the PATH; empty: there is none.
Path findProgram(const char* name) {
  const char* paths = std::getenv("PATH");
  std::string_view rest = paths != nullptr ? paths : "";
  while (!rest.empty()) {
    const size_t end = std::min(rest.find(':'), rest.size());
    Path path = Path(rest.substr(0, end)) / name;
    if (access(path.c_str(), X_OK) == 0) return path;
    rest.remove_prefix(std::min(end + 1, rest.size()));
  }
  return {};
}

class Pictures final : public Recording {
 public:
  explicit Pictures(const Path& folder) : Recording(folder) {}
  Result<void> add(const sample::ByteImage& picture) override {
    return writeScreenshot(picture, path_ / fmt::format("{:05}.png", ++pictures_));
  }
  Result<void> finish() override { return {}; }
};

class Video final : public Recording {
 public:
  Video(const Path& file, Path program) : Recording(file), program_(std::move(program)) {}
  ~Video() override { static_cast<void>(finish()); }
  Result<void> add(const sample::ByteImage& picture) override;
  Result<void> finish() override;

 private:
  Result<void> start(const sample::ByteImage& first);
  Path program_;
  uint32_t width_ = 0, height_ = 0;
  int input_ = -1;
  pid_t process_ = -1;
};

// Returns the command that makes a video of the pictures on its input. Most players need even
// sizes: the last row and column of an odd picture are repeated.
std::vector<std::string> wordsOf(const Path& file, uint32_t width, uint32_t height) {
  const uint32_t right = width % 2, bottom = height % 2;
  std::istringstream command(
      fmt::format("{} -y -loglevel error -f rawvideo -pix_fmt rgb24 -s {}x{} -r 60 -i - -vf "
                  "pad={}:{},fillborders=right={}:bottom={}:mode=smear -pix_fmt yuv420p",
                  kFfmpeg, width, height, width + right, height + bottom, right, bottom));
  std::vector<std::string> words(std::istream_iterator<std::string>(command), {});
  // An absolute path is a file, even if the name begins with a dash or has a colon.
  std::error_code error;
  const Path absolute = std::filesystem::absolute(file, error);
  words.push_back(error ? file.string() : absolute.string());
  return words;
}

Result<void> Video::start(const sample::ByteImage& first) {
  width_ = first.width;
  height_ = first.height;
  // If ffmpeg ends early, write() fails. Without this, the signal would end the viewer.
  signal(SIGPIPE, SIG_IGN);
  std::array<int, 2> ends = {-1, -1};
  if (pipe(ends.data()) != 0)
    return Error{ErrorCode::kDevice, fmt::format("no pipe to ffmpeg: {}", std::strerror(errno))};
  std::vector<std::string> words = wordsOf(path_, width_, height_);
  std::vector<char*> arguments;
  for (std::string& word : words) arguments.push_back(word.data());
  arguments.push_back(nullptr);
  process_ = fork();
  if (process_ == 0) {
    dup2(ends[0], STDIN_FILENO);
    close(ends[0]);
    close(ends[1]);
    execv(program_.c_str(), arguments.data());
    _exit(127);
  }
  close(ends[0]);
  input_ = ends[1];
  if (process_ > 0) return {};
  close(input_);
  input_ = -1;
  return Error{ErrorCode::kDevice, fmt::format("ffmpeg cannot run: {}", std::strerror(errno))};
}

Result<void> Video::add(const sample::ByteImage& picture) {
  if (pictures_ == 0)
    if (Result<void> started = start(picture); !started) return started;
  if (picture.width != width_ || picture.height != height_)
    return Error{ErrorCode::kInvalidArgument,
                 fmt::format("a video keeps its size, {} x {}; the window is {} x {} now", width_,
                             height_, picture.width, picture.height)};
  for (size_t done = 0; done < picture.rgb.size();) {
    const ssize_t written = write(input_, picture.rgb.data() + done, picture.rgb.size() - done);
    if (written < 0 && errno == EINTR) continue;
    if (written <= 0)
      return Error{ErrorCode::kDevice,
                   fmt::format("ffmpeg ended early; it cannot write {}, or says "
                               "why on the terminal",
                               path_.string())};
    done += static_cast<size_t>(written);
  }
  ++pictures_;
  return {};
}

Result<void> Video::finish() {
  if (process_ <= 0) return {};
  close(input_);
  int status = 0;
  waitpid(process_, &status, 0);
  process_ = -1;
  if (WIFEXITED(status) && WEXITSTATUS(status) == 0) return {};
  return Error{ErrorCode::kDevice,
               fmt::format("ffmpeg failed with {}; it says why on the terminal", path_.string())};
}

}  // namespace

bool hasFfmpeg() { return !findProgram(kFfmpeg).empty(); }

Result<std::unique_ptr<Recording>> recordPictures(const Path& folder) {
  std::error_code error;
  std::filesystem::create_directories(folder, error);
  if (error)
    return Error{ErrorCode::kFileNotFound, fmt::format("{}: the folder cannot be made: {}",
                                                       folder.string(), error.message())};
  return std::unique_ptr<Recording>(std::make_unique<Pictures>(folder));
}

Result<std::unique_ptr<Recording>> recordVideo(const Path& file) {
  Path program = findProgram(kFfmpeg);
  if (program.empty())
    return Error{ErrorCode::kUnsupported,
                 "there is no ffmpeg on the PATH, which makes videos: install it, or record a "
                 "sequence of pictures"};
  return std::unique_ptr<Recording>(std::make_unique<Video>(file, std::move(program)));
}

Path nextFile(const std::string& ending) {
  constexpr int kMost = 9999;
  for (int number = 1;; ++number) {
    Path path = fmt::format("pelage-{:04}{}", number, ending);
    std::error_code error;
    if (number == kMost || !std::filesystem::exists(path, error)) return path;
  }
}

}  // namespace viewer
