// The results of the scene benchmark: tables for a person and CSV files.
#pragma once

#include <string>
#include <vector>

#include "pelage/headless.h"
#include "pelage/result.h"
#include "scenes/scene_measure.h"

namespace bench {

/// A table of the rows, then one of their passes.
std::string sceneTable(const std::vector<SceneResult>& results);

/// Appends a row to a CSV file, and its passes to a second one beside it, NAME_passes.csv. Both get
/// a header where they are new.
pelage::Result<void> appendSceneCsv(const std::string& path, const SceneResult& result,
                                    const pelage::DeviceInfo& device, const std::string& commit);
/// Appends the time of a first frame [ms] to NAME_first_frame.csv.
pelage::Result<void> appendFirstFrameCsv(const std::string& path, const SceneRow& row,
                                         double milliseconds, const pelage::DeviceInfo& device,
                                         const std::string& commit);

/// Checks a row of a smoke test; the error names what is missing.
pelage::Result<void> checkResult(const SceneResult& result);

}  // namespace bench
