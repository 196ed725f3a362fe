// The version of pelage, for the preprocessor and at run time. C may include it, too.
#pragma once

/// Semantic version. While the major number is 0, the API may change with every minor number.
#define PELAGE_VERSION_MAJOR 0
#define PELAGE_VERSION_MINOR 1
#define PELAGE_VERSION_PATCH 0
/// One number to compare: 10000 major + 100 minor + patch.
#define PELAGE_VERSION \
  (PELAGE_VERSION_MAJOR * 10000 + PELAGE_VERSION_MINOR * 100 + PELAGE_VERSION_PATCH)

#ifdef __cplusplus
#include <cstdint>

#include "pelage/export.h"

namespace pelage {

/// Returns PELAGE_VERSION of the linked library. It differs from the macro if the headers belong to
/// another version.
PELAGE_API uint32_t libraryVersion();

}  // namespace pelage
#endif
