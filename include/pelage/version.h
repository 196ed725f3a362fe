// The version of pelage, for the preprocessor and at run time.
#pragma once

#include <cstdint>

/// Semantic version. While the major number is 0, another minor number is another API.
#define PELAGE_VERSION_MAJOR 0
#define PELAGE_VERSION_MINOR 1
#define PELAGE_VERSION_PATCH 0
/// One number to compare: 10000 major + 100 minor + patch.
#define PELAGE_VERSION \
  (PELAGE_VERSION_MAJOR * 10000 + PELAGE_VERSION_MINOR * 100 + PELAGE_VERSION_PATCH)

namespace pelage {

/// PELAGE_VERSION of the library that the program is linked to. It differs from the macro when the
/// headers are those of another version.
uint32_t libraryVersion();

}  // namespace pelage
