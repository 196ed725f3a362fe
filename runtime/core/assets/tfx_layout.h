// The parts of a .tfx file that saving keeps.
#pragma once

#include "pelage/hair_asset.h"

namespace pelage::detail {

/// Returns true if an asset's arrays still match its TfxFileLayout: saveTfx() then writes the file
/// of the layout, whose size is at most that of the asset's arrays, the extras and the header.
bool tfxLayoutFits(const HairAsset& asset);

}  // namespace pelage::detail
