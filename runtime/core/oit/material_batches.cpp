#include "oit/material_batches.h"

#include <algorithm>
#include <numeric>
#include <optional>

#include "base/vector3.h"

namespace pelage::detail {

namespace {

double distanceOf(const DrawnView& view, const DrawnHair& hair) {
  const Float3& p = hair.ball.center;
  const double x = toDouble(p.x) - toDouble(view.view.eye.x);
  const double y = toDouble(p.y) - toDouble(view.view.eye.y);
  const double z = toDouble(p.z) - toDouble(view.view.eye.z);
  const double squared = x * x + y * y + z * z;
  return squared >= 0 ? squared : 0;  // what is not a number is near
}

void addTo(MaterialBatch& batch, size_t index, const DrawnHair& hair, size_t material) {
  batch.hairs.push_back(index);
  batch.materialOf.push_back(material);
  batch.vertices += uint64_t{hair.strands.count} * hair.vertexCount;
}

// Where the batch has this shading, or room for it.
std::optional<size_t> findMaterial(MaterialBatch& batch, std::vector<ShadingParts>& shadings,
                                   const StrandMaterial& material) {
  const ShadingParts shading = shadingOf(material);
  const auto known = std::find(shadings.begin(), shadings.end(), shading);
  if (known != shadings.end()) return static_cast<size_t>(known - shadings.begin());
  if (shadings.size() == kMaxMaterials) return std::nullopt;
  shadings.push_back(shading);
  batch.materials.push_back(&material);
  return shadings.size() - 1;
}

// In an order, as many objects a batch as have room.
std::vector<MaterialBatch> fill(const DrawnView& view, const std::vector<size_t>& order) {
  std::vector<MaterialBatch> batches(1);
  std::vector<ShadingParts> shadings;
  for (const size_t i : order) {
    const DrawnHair& hair = view.hairs[i];
    std::optional<size_t> material = findMaterial(batches.back(), shadings, *hair.material);
    if (!material) {
      batches.emplace_back();
      shadings.clear();
      material = findMaterial(batches.back(), shadings, *hair.material);
    }
    addTo(batches.back(), i, hair, *material);
  }
  return batches;
}

}  // namespace

std::vector<MaterialBatch> materialBatches(const DrawnView& view) {
  std::vector<size_t> order(view.hairs.size());
  std::iota(order.begin(), order.end(), size_t{0});
  if (order.size() <= kMaxMaterials) {
    std::vector<MaterialBatch> one(1);
    for (const size_t i : order) {
      addTo(one[0], i, view.hairs[i], i);
      one[0].materials.push_back(view.hairs[i].material);
    }
    return one;
  }
  std::vector<MaterialBatch> batches = fill(view, order);
  if (batches.size() == 1) return batches;
  std::stable_sort(order.begin(), order.end(), [&](size_t a, size_t b) {
    return distanceOf(view, view.hairs[a]) > distanceOf(view, view.hairs[b]);
  });
  return fill(view, order);
}

}  // namespace pelage::detail
