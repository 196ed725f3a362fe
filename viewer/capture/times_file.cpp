#include "capture/times_file.h"

#include <fmt/format.h>

#include "interface/pass_history.h"

namespace viewer {

pelage::Result<TimesFile> TimesFile::open(const std::filesystem::path& path) {
  TimesFile times;
  times.path_ = path;
  times.file_.open(path);
  if (!times.file_)
    return pelage::Error{pelage::ErrorCode::kFileNotFound,
                         path.string() + ": the times cannot be written"};
  times.file_ << "frame,pass,passes,milliseconds\n";
  return times;
}

void TimesFile::add(uint64_t frame, std::span<const pelage::PassTiming> timings) {
  PassHistory own;
  own.add(timings);
  for (const PassHistory::PassTime& pass : own.passes())
    file_ << fmt::format("{},{},{},{:.6f}\n", frame, pass.name, pass.passes, pass.milliseconds);
  file_.flush();
}

}  // namespace viewer
