// Guides that are too limp to hang in the shape that they were groomed in.
#pragma once

#include <filesystem>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>

#include "pelage/hair_asset.h"
#include "pelage/result.h"
#include "pelage/simulation_settings.h"
#include "session.h"

namespace CLI {
class App;
}

namespace pelage::convert {

/// The option --settings: what a report about sag is for.
struct SagOptions {
  std::filesystem::path settings;
};
/// Adds the option.
void addSagOption(CLI::App& command, SagOptions& options);

struct SagReport {
  nlohmann::json json;  ///< guides that hold their bind shape; index and share of each other one
  std::string text;     ///< the same for people
};
/// Finds the guides that can hang in their bind shape with the settings of the option, and warns of
/// those that cannot, where the settings ask for more. Nothing without the option.
/// \param asset  processed again
/// \param scale  meters per unit of the asset
/// \param name   of the asset, for warnings
Result<std::optional<SagReport>> sagReportOf(HairAsset asset, float scale, const std::string& name,
                                             const SagOptions& options, program::Session& session);

}  // namespace pelage::convert
