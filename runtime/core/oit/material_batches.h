// Hair objects of a view in batches whose fragments can name their shading.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "pelage/constants.h"
#include "shading/strand_draws.h"

namespace pelage::detail {

/// Shadings that fragments can tell apart.
inline constexpr size_t kMaxMaterials = fragment_packing::kMaterialLimit;

struct MaterialBatch {
  std::span<const size_t> hairs;                     ///< indices into DrawnView::hairs
  std::span<const size_t> materialOf;                ///< [hair of the batch] index into `materials`
  std::span<const StrandMaterial* const> materials;  ///< at most kMaxMaterials
  uint64_t vertices = 0;                             ///< of its strands that are drawn
};

/// Up to kMaxMaterials objects are one batch, each with a material of its own. More of them share
/// materials that shade alike. Where these are too many, batches are composited one over the other,
/// the farthest first, by the middles of the objects: each is exact, and so is the picture where
/// objects of different batches do not reach into each other's depths.
class MaterialBatches {
 public:
  /// Into the memory of an earlier view.
  void fill(const DrawnView& view);
  void clear() { batches_.clear(); }
  std::span<const MaterialBatch> all() const { return batches_; }

 private:
  void fillInOrder(const DrawnView& view, bool shares);
  bool addMaterial(const StrandMaterial& material, bool shares);

  std::vector<size_t> order_;       ///< of the view's hairs
  std::vector<size_t> materialOf_;  ///< [index into order_]
  std::vector<const StrandMaterial*> materials_;
  std::vector<ShadingParts> shadings_;  ///< [material of the last batch]
  std::vector<MaterialBatch> batches_;
};

}  // namespace pelage::detail
