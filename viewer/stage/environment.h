// Light from all sides to choose from.
#pragma once

#include <span>

#include "pelage/light.h"
#include "stage/stage.h"

namespace viewer {

struct NamedEnvironment {
  const char* name;
  pelage::EnvironmentLight light;
};

/// Environments to choose from, beside Stage::ownEnvironment().
std::span<const NamedEnvironment> environments();
inline constexpr const char* kOwnEnvironment = "of the scene";
/// Returns the name of the environment of the first light; kOwnEnvironment if it is none of
/// environments().
const char* environmentName(const Stage& stage);
/// Sets the environment of the first light.
void setEnvironment(const pelage::EnvironmentLight& environment, Stage& stage);

}  // namespace viewer
