// What saving a .tfx file keeps of the file that the asset came from.
#pragma once

#include "pelage/hair_asset.h"

namespace pelage::detail {

/// Whether an asset's arrays are still those that its TfxFileLayout describes: saveTfx() then
/// writes the file of the layout. What such a layout describes has at most the size of the asset's
/// arrays, the extras and the header.
bool tfxLayoutFits(const HairAsset& asset);

}  // namespace pelage::detail
