// What the passes of views of errors have in common.
#pragma once

#include <cstdint>

#include "pelage/pass_list.h"
#include "pelage/view.h"
#include "stage/inspection_look.h"
#include "viewer_kernels/bindings.h"
#include "viewer_kernels/constants.h"

namespace viewer {

/// Adds a dispatch over threads, in rows of strand_value::kInspectRow.
template <class Variant>
void dispatchOver(pelage::PassBuilder& pass, const Variant& variant, uint64_t threads) {
  constexpr uint64_t kRow = viewer_kernels::strand_value::kInspectRow;
  pass.dispatch(variant, static_cast<uint32_t>(threads < kRow ? threads : kRow),
                static_cast<uint32_t>((threads + kRow - 1) / kRow));
}

/// Constants of draws in the colors of a look. \param vertices of a strand.
viewer_kernels::DrawValuesConstants valuesOf(const InspectionLook& look, const pelage::View& view,
                                             uint32_t vertices);

inline pelage::PixelArea areaOf(const pelage::View& view) {
  return {static_cast<uint32_t>(view.x), static_cast<uint32_t>(view.y), view.width, view.height};
}

/// Draws that cover the viewport, over what is there.
inline pelage::DrawState overEverything() {
  pelage::DrawState state;
  state.depthCompare = pelage::DepthCompare::kAlways;
  state.depthWrite = false;
  state.blend = pelage::BlendMode::kPremultipliedAlpha;
  return state;
}

}  // namespace viewer
