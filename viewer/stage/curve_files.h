// Hair curves of modeling programs, through the authoring library.
#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "pelage/asset_cache.h"
#include "pelage/result.h"

namespace viewer {

/// Whether this build reads files of an extension (".hair") as hair curves.
bool isCurveFile(std::string_view extension);
/// ", .hair, ..." for messages; empty without the authoring library.
const char* curveExtensions();
/// Loads and resamples a file; hair is processed. \param scale meters per unit. Errors: those of
/// the authoring library; a build without it.
pelage::Result<pelage::CachedHair> loadCurveFile(const std::filesystem::path& path, float scale,
                                                 std::vector<std::string>& remarks);

}  // namespace viewer
