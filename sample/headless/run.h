// The work of pelage-headless.
#pragma once

#include "options.h"
#include "pelage/result.h"

namespace sample {

/// Does what the options ask for and prints the figures. Ends early, after the frame at hand, when
/// interrupted() becomes true.
pelage::Result<void> run(Options options);

}  // namespace sample
