#include "scenes/drawing_report.h"

#include <fmt/format.h>

#include "simulation/csv_file.h"

namespace bench {

using pelage::DeviceInfo;
using pelage::Result;

namespace {

std::string csvHeader() {
  std::string header =
      "commit,api,row,method,width,height,guides,follow_hairs,frames,frame_us_median,frame_us_mean,"
      "drawing_us_median,drawing_us_mean,added_us_median,added_us_mean";
  for (size_t i = 0; i < kPassGroups; ++i)
    header += fmt::format(",{0}_us_median,{0}_us_mean", passGroupName(static_cast<PassGroup>(i)));
  return header +
         ",show_us_median,show_us_mean,fragments,spilled,bytes,psnr_db,reference_us_before,"
         "reference_us_after,"
         "runs,device,driver\n";
}

constexpr const char* kDrawingPassCsvHeader =
    "commit,api,row,method,pass,group,us_median,us_mean,passes_a_frame,device,driver\n";

std::string shown(double value, bool known) { return known ? fmt::format("{:.1f}", value) : "-"; }

std::string csvRow(const DrawingResult& r) {
  const bool timed = r.figures.isTimed();
  const auto spread = [&](const Spread& s, bool known) {
    return csvNumber(s.median, known) + "," + csvNumber(s.mean, known);
  };
  std::string row =
      fmt::format("{},{},{},{},{},{},{},{}", r.row.width, r.row.height, r.guides, r.followHairs,
                  r.figures.frames(), spread(r.figures.frame(), timed),
                  spread(drawingTime(r.figures), timed), spread(r.added, timed && r.hasAdded));
  for (size_t i = 0; i < kPassGroups; ++i)
    row += "," + spread(r.figures.of(static_cast<PassGroup>(i)), timed);
  row += "," + spread(spreadOf(r.showUs), !r.showUs.empty());
  return row + fmt::format(",{},{},{},{},{},{},{}", r.fragments, r.spilled, r.bytes,
                           csvNumber(r.psnr, r.psnr > 0),
                           csvNumber(r.copies.before, r.copies.before > 0),
                           csvNumber(r.copies.after, r.copies.after > 0), r.copies.runs);
}

}  // namespace

const char* drawingMethodName(pelage::Transparency method) {
  return method == pelage::Transparency::kTiles ? "tiles" : "windowed";
}

std::string drawingTable(const std::vector<DrawingResult>& results) {
  if (results.empty()) return {};
  const DrawingRow& first = results[0].row;
  std::string text = fmt::format(
      "\nGPU time a frame [us], medians; {} x {}, {}\n{:<25}{:>9}{:>9}{:>9}", first.width,
      first.height, drawingMethodName(results[0].method), "row", "frame", "drawing", "added");
  for (size_t i = 0; i < kPassGroups; ++i)
    text += fmt::format("{:>15}", passGroupName(static_cast<PassGroup>(i)));
  text += fmt::format("{:>9}{:>11}{:>9}{:>8}{:>8}{:>9}{:>9}{:>5}\n", "show", "fragments", "spilled",
                      "MB", "dB", "before", "after", "runs");
  for (const DrawingResult& r : results) {
    const bool timed = r.figures.isTimed();
    text += fmt::format(
        "{:<25}{:>9}{:>9}{:>9}", r.row.name(), shown(r.figures.frame().median, timed),
        shown(drawingTime(r.figures).median, timed), shown(r.added.median, timed && r.hasAdded));
    for (size_t i = 0; i < kPassGroups; ++i)
      text += fmt::format("{:>15}", shown(r.figures.of(static_cast<PassGroup>(i)).median, timed));
    text += fmt::format("{:>9}{:>11}{:>9}{:>8}{:>8}{:>9}{:>9}{:>5}\n",
                        shown(spreadOf(r.showUs).median, !r.showUs.empty()), r.fragments, r.spilled,
                        r.bytes / 1000000, shown(r.psnr, r.psnr > 0),
                        shown(r.copies.before, r.copies.before > 0),
                        shown(r.copies.after, r.copies.after > 0), r.copies.runs);
  }
  text += fmt::format("\n{:<25}{:<28}{:<15}{:>12}{:>12}{:>10}\n", "row", "pass", "group",
                      "median us", "mean us", "a frame");
  for (const DrawingResult& r : results)
    for (const PassFigure& pass : r.figures.passes()) {
      const Spread us = spreadOf(pass.us);
      text += fmt::format("{:<25}{:<28}{:<15}{:>12}{:>12}{:>10.2f}\n", r.row.name(), pass.name,
                          passGroupName(pass.group), shown(us.median, r.figures.isTimed()),
                          shown(us.mean, r.figures.isTimed()), r.figures.perFrame(pass));
    }
  return text;
}

Result<void> appendDrawingCsv(const std::string& path, const DrawingResult& result,
                              const DeviceInfo& device, const std::string& commit) {
  const std::string start = fmt::format("{},{},{},{}", commit, pelage::apiName(device.api),
                                        result.row.name(), drawingMethodName(result.method));
  const std::string end = csvEnd(device);
  const std::string row = start + "," + csvRow(result) + "," + end;
  if (Result<void> done = appendLines(besidePath(path, "_drawing"), csvHeader().c_str(), {row});
      !done)
    return done;
  std::vector<std::string> passes;
  for (const PassFigure& pass : result.figures.passes()) {
    const Spread us = spreadOf(pass.us);
    const bool timed = result.figures.isTimed();
    passes.push_back(fmt::format("{},{},{},{},{},{:.6g},{}", start, pass.name,
                                 passGroupName(pass.group), csvNumber(us.median, timed),
                                 csvNumber(us.mean, timed), result.figures.perFrame(pass), end));
  }
  return appendLines(besidePath(path, "_drawing_passes"), kDrawingPassCsvHeader, passes);
}

}  // namespace bench
