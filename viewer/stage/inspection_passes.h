// Parts that the passes of all views of errors share.
#pragma once

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <vector>

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

/// Returns the constants of draws in the colors of a look. \param vertices of a strand.
viewer_kernels::DrawValuesConstants valuesOf(const InspectionLook& look, const pelage::View& view,
                                             uint32_t vertices);

inline pelage::PixelArea areaOf(const pelage::View& view) {
  return {static_cast<uint32_t>(view.x), static_cast<uint32_t>(view.y), view.width, view.height};
}

/// Returns the state of draws that blend over the whole viewport.
inline pelage::DrawState overEverything() {
  pelage::DrawState state;
  state.depthCompare = pelage::DepthCompare::kAlways;
  state.depthWrite = false;
  state.blend = pelage::BlendMode::kPremultipliedAlpha;
  return state;
}

inline constexpr uint32_t kCornersOfStrip = 4;

/// Returns the state of triangle strips with depth.
inline pelage::DrawState solid(const pelage::View& view) {
  pelage::DrawState state;
  state.topology = pelage::PrimitiveTopology::kTriangleStrip;
  state.depthCompare =
      view.reversedDepth ? pelage::DepthCompare::kGreater : pelage::DepthCompare::kLess;
  return state;
}

/// Returns the number of SDFs in a buffer of HairBuffers::sdfs.
uint32_t slotsOf(const pelage::ResourceTable& table, pelage::BufferId sdfs);

inline std::vector<uint32_t> wordsOf(const std::vector<std::byte>& bytes) {
  std::vector<uint32_t> words(bytes.size() / sizeof(uint32_t));
  std::memcpy(words.data(), bytes.data(), words.size() * sizeof(uint32_t));
  return words;
}

}  // namespace viewer
