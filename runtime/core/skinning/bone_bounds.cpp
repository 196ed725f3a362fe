#include "skinning/bone_bounds.h"

#include "base/bounds.h"

namespace pelage::detail {

HostArray<BoneBounds> boundsOfRoots(const HairAsset& asset,
                                    std::span<const BoneInfluences> influences) {
  const size_t stride = asset.verticesPerStrand;
  const auto root = [&](uint32_t strand) {
    const Float4& p = asset.positions[strand * stride];
    return Float3{p.x, p.y, p.z};
  };
  std::vector<Box> boxes(1);
  const auto add = [&](uint32_t bone, Float3 p) {
    if (bone >= boxes.size()) boxes.resize(bone + 1);
    boxes[bone] = include(boxes[bone], p);
  };
  for (uint32_t s = 0; s < asset.strandCount; ++s) {
    bool bound = false;
    for (size_t k = 0; k < 4 && s < influences.size(); ++k) {
      if (!(influences[s].weights[k] > 0)) continue;
      add(influences[s].bones[k], root(s));
      bound = true;
    }
    if (!bound) add(s < influences.size() ? influences[s].bones[0] : 0, root(s));
  }
  HostArray<BoneBounds> bounds;
  for (uint32_t bone = 0; bone < boxes.size(); ++bone) {
    const Box& box = boxes[bone];
    if (box.isEmpty()) continue;
    const Float3 center = middleOf(box);
    bounds.push_back({bone, center, distance(center, box.high)});
  }
  return bounds;
}

Float3 middleOf(std::span<const BoneBounds> bounds, std::span<const AffineTransform> bones) {
  double sum[3] = {0, 0, 0};
  for (const BoneBounds& ball : bounds) {
    const AffineTransform bone = bones.empty() ? AffineTransform{} : bones[ball.bone];
    for (int axis = 0; axis < 3; ++axis) {
      const Float4& row = bone.rows[axis];
      sum[axis] += static_cast<double>(row.x * ball.center.x + row.y * ball.center.y +
                                       row.z * ball.center.z + row.w);
    }
  }
  const auto mean = [&](int axis) {
    return static_cast<float>(sum[axis] / static_cast<double>(bounds.size()));
  };
  return {mean(0), mean(1), mean(2)};
}

}  // namespace pelage::detail
