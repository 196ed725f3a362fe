#include "sag_report.h"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <utility>
#include <vector>

#include "pelage/hair_asset.h"
#include "pelage/sag_compensation.h"
#include "pelage/settings/settings_file.h"

namespace pelage::convert {

namespace {

// Guides that people read; a program gets all.
constexpr size_t kGuidesListed = 8;

}  // namespace

void addSagOption(CLI::App& command, SagOptions& options) {
  command.add_option("--settings", options.settings,
                     "Settings, .json: report which guides of a .tfx or .pelage they make hang in "
                     "their bind shape");
}

Result<std::optional<SagReport>> sagReportOf(HairAsset asset, float scale, const std::string& name,
                                             const SagOptions& options, program::Session& session) {
  if (options.settings.empty()) return std::optional<SagReport>();
  auto file = SettingsFile::load(options.settings);
  if (!file) return file.error();
  SimulationSettings settings;
  file->apply(settings);
  if (scale != 1)
    if (auto r = scaleHair(asset, scale); !r) return r.error();
  if (auto r = asset.process(); !r) return r.error();
  auto shares = reachableSagCompensation(asset, settings);
  if (!shares) return shares.error();

  nlohmann::json limp = nlohmann::json::array();
  std::string list;
  size_t asked = 0;
  for (size_t guide = 0; guide < shares->size(); ++guide) {
    const float share = (*shares)[guide];
    if (share < settings.sagCompensation) ++asked;
    if (share == 1) continue;
    if (limp.size() < kGuidesListed)
      list += fmt::format("{}{} ({:.2g})", limp.empty() ? "" : ", ", guide, share);
    limp.push_back({{"guide", guide}, {"share", share}});
  }
  const size_t all = shares->size();
  std::string text = fmt::format("{} of {} guides hold their bind shape", all - limp.size(), all);
  if (!limp.empty())
    text += fmt::format("; too limp, with the share that they reach: {}{}", list,
                        limp.size() > kGuidesListed ? ", ..." : "");
  if (asked > 0)
    session.warn(
        fmt::format("{}: {} of {} guides are too limp for the 'sagCompensation' of {:g}: they sag; "
                    "raise 'bendLength' or 'globalStiffness', or groom them as they hang",
                    name, asked, all, settings.sagCompensation));
  return std::optional(
      SagReport{{{"holding", all - limp.size()}, {"limp", std::move(limp)}}, text});
}

}  // namespace pelage::convert
