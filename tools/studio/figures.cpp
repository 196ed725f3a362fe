#include "figures.h"

#include <fmt/format.h>

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <numeric>

#include "names.h"

namespace sample {

using pelage::DeviceInfo;

namespace {

// A field as RFC 4180 has it: quoted where a comma, a quote or a line end needs it.
std::string csvField(const std::string& text) {
  if (text.find_first_of(",\"\r\n") == std::string::npos) return text;
  std::string out = "\"";
  for (const char c : text) {
    if (c == '"') out += '"';
    out += c;
  }
  return out + '"';
}

constexpr const char* kCsvHeader =
    "commit,device,driver,api,asset,guides,follow,strands,vertices_per_strand,frames,pass,passes,"
    "min_ms,median_ms,mean_ms,bytes_per_pass,gb_per_s\n";

}  // namespace

double PassFigure::totalMilliseconds() const {
  return std::accumulate(milliseconds.begin(), milliseconds.end(), 0.0);
}

double PassFigure::meanMilliseconds() const {
  return milliseconds.empty() ? 0 : totalMilliseconds() / static_cast<double>(milliseconds.size());
}

double PassFigure::minMilliseconds() const {
  return milliseconds.empty() ? 0 : *std::min_element(milliseconds.begin(), milliseconds.end());
}

double PassFigure::medianMilliseconds() const {
  if (milliseconds.empty()) return 0;
  std::vector<double> sorted = milliseconds;
  std::sort(sorted.begin(), sorted.end());
  const size_t half = sorted.size() / 2;
  return sorted.size() % 2 == 1 ? sorted[half] : (sorted[half - 1] + sorted[half]) / 2;
}

double PassFigure::gigabytesPerSecond() const {
  const double time = totalMilliseconds();
  if (time <= 0 || passes != milliseconds.size()) return 0;
  return static_cast<double>(bytes) / (time * 1e6);
}

void Figures::add(const std::vector<pelage::PassList>& lists,
                  const std::vector<pelage::PassTiming>& timings) {
  size_t first = 0;
  for (const pelage::PassList& list : lists) {
    const size_t last = std::min(first + list.passes.size(), timings.size());
    add(list, {timings.begin() + static_cast<std::ptrdiff_t>(first),
               timings.begin() + static_cast<std::ptrdiff_t>(last)});
    first = last;
  }
}

void Figures::add(const pelage::PassList& list, const std::vector<pelage::PassTiming>& timings) {
  for (size_t i = 0; i < list.passes.size(); ++i) {
    const pelage::Pass& pass = list.passes[i];
    auto figure = std::find_if(passes_.begin(), passes_.end(),
                               [&](const PassFigure& f) { return f.name == pass.name; });
    if (figure == passes_.end()) figure = passes_.insert(passes_.end(), {pass.name, 0, 0, {}});
    ++figure->passes;
    figure->bytes += pass.bytes;
    if (i < timings.size() && timings[i].milliseconds >= 0)
      figure->milliseconds.push_back(timings[i].milliseconds);
  }
}

std::string Figures::table() const {
  std::string out =
      fmt::format("{:<24}{:>8}{:>12}{:>11}{:>11}{:>11}{:>12}{:>9}\n", "pass", "passes", "total ms",
                  "mean ms", "min ms", "median ms", "MB a pass", "GB/s");
  for (const PassFigure& f : passes_) {
    out += fmt::format("{:<24}{:>8}", f.name, f.passes);
    if (f.milliseconds.empty())
      out += fmt::format("{:>12}{:>11}{:>11}{:>11}", "-", "-", "-", "-");
    else
      out += fmt::format("{:>12.2f}{:>11.4f}{:>11.4f}{:>11.4f}", f.totalMilliseconds(),
                         f.meanMilliseconds(), f.minMilliseconds(), f.medianMilliseconds());
    if (f.bytes == 0)
      out += fmt::format("{:>12}{:>9}\n", "-", "-");
    else
      out += fmt::format("{:>12.3f}{:>9.2f}\n",
                         static_cast<double>(f.bytes) / static_cast<double>(f.passes) / 1e6,
                         f.gigabytesPerSecond());
  }
  return out;
}

Result<void> appendCsv(const std::string& path, const Figures& figures, const DeviceInfo& device,
                       const RunInfo& run) {
  std::string rows;
  for (const PassFigure& f : figures.passes())
    rows += fmt::format("{},{},{},{},{},{},{},{},{},{},{},{},{:.6f},{:.6f},{:.6f},{},{:.3f}\n",
                        csvField(run.commit), csvField(device.name), csvField(device.driver),
                        pelage::apiName(device.api), csvField(run.asset), run.guides, run.follow,
                        run.guides + run.follow, run.verticesPerStrand, run.frames, f.name,
                        f.passes, f.minMilliseconds(), f.medianMilliseconds(), f.meanMilliseconds(),
                        f.bytes / f.passes, f.gigabytesPerSecond());
  std::FILE* file = std::fopen(path.c_str(), "ab");
  if (file == nullptr)
    return pelage::Error{pelage::ErrorCode::kFileNotFound,
                         fmt::format("{}: cannot be opened: {}", path, std::strerror(errno))};
  // The position of a stream opened for appending is not at the end before the first write.
  bool good = std::fseek(file, 0, SEEK_END) == 0;
  if (good && std::ftell(file) == 0) good = std::fputs(kCsvHeader, file) >= 0;
  good = good && std::fputs(rows.c_str(), file) >= 0;
  good = std::fclose(file) == 0 && good;
  if (!good)
    return pelage::Error{pelage::ErrorCode::kFileNotFound,
                         fmt::format("{}: cannot be written: {}", path, std::strerror(errno))};
  return {};
}

}  // namespace sample
