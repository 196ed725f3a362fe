// The motion of bones from a glTF file.
#pragma once

#include <filesystem>
#include <string>

#include "demo_scene.h"
#include "pelage/result.h"

namespace sample {

/// Loads a clip; an empty name takes the first one. Errors: those of pelage::loadAnimation(); a
/// build without PELAGE_AUTHORING, which has none.
pelage::Result<BoneMotion> loadMotion(const std::filesystem::path& path, const std::string& clip);

}  // namespace sample
