#include "pelage/version.h"

namespace pelage {

uint32_t libraryVersion() { return PELAGE_VERSION; }

}  // namespace pelage
