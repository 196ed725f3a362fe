#include "session.h"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <utility>

#include "program_messages.h"

namespace pelage::program {
namespace {

constexpr int kBarWidth = 32;

}  // namespace

void Session::add(std::string_view key, nlohmann::json value, std::string_view label,
                  std::string text) {
  if (!key.empty()) report_[std::string(key)] = std::move(value);
  if (!label.empty()) lines_.push_back({std::string(label), std::move(text)});
}

void Session::beginFile() {
  if (report_.empty()) return;
  earlier_.push_back(std::move(report_));
  report_ = {};
  if (!lines_.empty() && !lines_.back().label.empty()) lines_.push_back({});
}

void Session::endFiles(std::string_view list) {
  beginFile();
  list_ = list;
}

void Session::warn(std::string text) {
  if (!quiet) printWarning(program_, text);
  warnings_.push_back(std::move(text));
}

void Session::fail(std::string_view file, std::string text) {
  report_["file"] = file;
  fail(std::move(text));
}

void Session::fail(std::string text) {
  report_["error"] = text;
  errors_.push_back(std::move(text));
}

void Session::print() const {
  if (json) {
    nlohmann::ordered_json report = report_;
    if (!list_.empty()) {
      report[list_] = earlier_;
    } else if (!earlier_.empty()) {
      report = {{"files", earlier_}};
      report["files"].push_back(report_);
    }
    report["warnings"] = warnings_;
    fmt::print("{}\n", report.dump(2, ' ', false, nlohmann::json::error_handler_t::replace));
    return;
  }
  if (quiet) return;
  size_t width = 0;
  for (const Line& line : lines_) width = std::max(width, line.label.size());
  for (const Line& line : lines_)
    if (line.label.empty())
      fmt::print("\n");  // between files
    else
      fmt::print("{:<{}}  {}\n", line.label, width, line.text);
}

void Session::progress(std::string_view what, uint64_t done, uint64_t total) {
  if (quiet || json || total == 0 || isatty(STDERR_FILENO) == 0) return;
  const uint64_t permille = done * 1000 / total;
  if (permille == drawnPermille_) return;
  drawnPermille_ = permille;
  if (done >= total) {
    fmt::print(stderr, "\r\x1b[K");
    return;
  }
  const int filled = static_cast<int>(permille * kBarWidth / 1000);
  fmt::print(stderr, "\r[{:#<{}}{:.<{}}] {}\x1b[K", "", filled, "", kBarWidth - filled, what);
  std::fflush(stderr);
}

}  // namespace pelage::program
