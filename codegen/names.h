// Converts names of HLSL and the manifest to C++ names.
#pragma once

#include <string>
#include <string_view>

namespace pelage::codegen {

/// A C++ identifier that is not a keyword.
bool isIdentifier(std::string_view text);
/// "skin_roots" -> "SkinRoots".
std::string pascalCase(std::string_view snake);
/// "skin_roots" -> "skinRoots".
std::string camelCase(std::string_view snake);
/// "g_positions" -> "positions", "SimulationConstants" -> "simulationConstants",
/// "PPLLBuildConstants" -> "ppllBuildConstants".
std::string hostName(std::string_view hlsl);

}  // namespace pelage::codegen
