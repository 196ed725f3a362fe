#include "mesh_weld.h"

#include <algorithm>
#include <array>
#include <bit>
#include <compare>
#include <numeric>

namespace pelage::detail {
namespace {

// Orders by what the vertices must agree in, so that those that agree are neighbors.
std::strong_ordering compare(const SkinnedMesh& mesh, WeldBy by, uint32_t a, uint32_t b) {
  // + 0 makes one zero of both.
  const auto bits = [](const Float3& v) {
    return std::array{std::bit_cast<uint32_t>(v.x + 0.0f), std::bit_cast<uint32_t>(v.y + 0.0f),
                      std::bit_cast<uint32_t>(v.z + 0.0f)};
  };
  const auto position = bits(mesh.positions[a]) <=> bits(mesh.positions[b]);
  if (position != 0 || by == WeldBy::kPosition) return position;
  if (by == WeldBy::kPositionNormalAndBones)
    if (const auto normal = bits(mesh.normals[a]) <=> bits(mesh.normals[b]); normal != 0)
      return normal;
  const BoneInfluences &x = mesh.influences[a], &y = mesh.influences[b];
  for (size_t k = 0; k < 4; ++k) {
    if (const auto bone = x.bones[k] <=> y.bones[k]; bone != 0) return bone;
    const auto weight =
        std::bit_cast<uint32_t>(x.weights[k]) <=> std::bit_cast<uint32_t>(y.weights[k]);
    if (weight != 0) return weight;
  }
  return std::strong_ordering::equal;
}

}  // namespace

std::vector<uint32_t> weldVertices(const SkinnedMesh& mesh, WeldBy by) {
  std::vector<uint32_t> order(mesh.positions.size());
  std::iota(order.begin(), order.end(), 0u);
  std::sort(order.begin(), order.end(), [&](uint32_t a, uint32_t b) {
    const auto result = compare(mesh, by, a, b);
    return result == 0 ? a < b : result < 0;
  });
  std::vector<uint32_t> first(order.size());
  for (size_t i = 0; i < order.size(); ++i) {
    const bool agrees = i > 0 && compare(mesh, by, order[i - 1], order[i]) == 0;
    first[order[i]] = agrees ? first[order[i - 1]] : order[i];
  }
  return first;
}

}  // namespace pelage::detail
