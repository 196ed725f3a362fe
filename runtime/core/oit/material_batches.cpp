#include "oit/material_batches.h"

#include <algorithm>
#include <numeric>
#include <span>

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

}  // namespace

// Notes the next hair's material. Returns whether the last batch had it, or room for it.
bool MaterialBatches::addMaterial(const StrandMaterial& material, bool shares) {
  const ShadingParts shading = shadingOf(material);
  const auto known = shares ? std::ranges::find(shadings_, shading) : shadings_.end();
  if (known == shadings_.end() && shadings_.size() == kMaxMaterials) return false;
  materialOf_.push_back(static_cast<size_t>(known - shadings_.begin()));
  if (known != shadings_.end()) return true;
  shadings_.push_back(shading);
  materials_.push_back(&material);
  return true;
}

// As many objects a batch as have room.
void MaterialBatches::fillInOrder(const DrawnView& view, bool shares) {
  batches_.assign(1, {});
  shadings_.clear();
  materialOf_.clear();
  materials_.clear();
  materialOf_.reserve(order_.size());
  materials_.reserve(order_.size());
  size_t first = 0, firstMaterial = 0;
  const auto end = [&](size_t last) {
    MaterialBatch& batch = batches_.back();
    batch.hairs = std::span(order_).subspan(first, last - first);
    batch.materialOf = std::span(materialOf_).subspan(first, last - first);
    batch.materials = std::span(materials_).subspan(firstMaterial);
    first = last;
    firstMaterial = materials_.size();
  };
  for (size_t i = 0; i < order_.size(); ++i) {
    const DrawnHair& hair = view.hairs[order_[i]];
    if (!addMaterial(*hair.material, shares)) {
      end(i);
      batches_.emplace_back();
      shadings_.clear();
      addMaterial(*hair.material, shares);
    }
    batches_.back().vertices += uint64_t{hair.strands.count} * hair.vertexCount;
  }
  end(order_.size());
}

void MaterialBatches::fill(const DrawnView& view) {
  order_.resize(view.hairs.size());
  std::iota(order_.begin(), order_.end(), size_t{0});
  const bool shares = order_.size() > kMaxMaterials;
  fillInOrder(view, shares);
  if (batches_.size() == 1) return;
  std::ranges::sort(order_, [&](size_t a, size_t b) {
    const double distanceA = distanceOf(view, view.hairs[a]);
    const double distanceB = distanceOf(view, view.hairs[b]);
    return distanceA != distanceB ? distanceA > distanceB : a < b;
  });
  fillInOrder(view, shares);
}

}  // namespace pelage::detail
