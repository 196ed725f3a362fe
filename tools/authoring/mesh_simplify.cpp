#include "mesh_simplify.h"

#include <meshoptimizer.h>

#include <algorithm>
#include <numeric>

#include "cut_caps.h"
#include "surface_distance.h"
#include "triangle_tree.h"

namespace pelage::detail {
namespace {

constexpr int kTries = 12;
// The measurement may be this share of the bound too large.
constexpr double kTolerance = 0.05;

TriangleTree treeOf(std::span<const Float3> positions, std::span<const uint32_t> indices) {
  std::vector<uint32_t> used(indices.size() / 3);
  std::iota(used.begin(), used.end(), 0u);
  return {positions, indices, std::move(used)};
}

std::vector<uint32_t> withoutCollapsed(std::span<const uint32_t> indices) {
  std::vector<uint32_t> result;
  for (size_t i = 0; i < indices.size(); i += 3) {
    const uint32_t a = indices[i], b = indices[i + 1], c = indices[i + 2];
    if (a != b && b != c && c != a) result.insert(result.end(), {a, b, c});
  }
  return result;
}

}  // namespace

SimplifiedMesh simplifyMesh(std::span<const Float3> positions, std::span<const uint32_t> indices,
                            double errorBound, bool keepRims) {
  const std::vector<uint32_t> source = withoutCollapsed(indices);
  if (source.empty()) return {{indices.begin(), indices.end()}, 0};
  const float* const coordinates = &positions[0].x;
  const double scale = meshopt_simplifyScale(coordinates, positions.size(), sizeof(Float3));
  if (!(scale > 0)) return {source, 0};
  const EdgeBalance sourceEdges(source);
  const unsigned options = keepRims ? unsigned{meshopt_SimplifyLockBorder} : 0u;
  const TriangleTree sourceTree = treeOf(positions, source);
  // meshoptimizer bounds a mean over the triangles that met in a vertex, so the distance comes out
  // larger or smaller than the bound.
  double target = errorBound;
  for (int i = 0; i < kTries; ++i) {
    std::vector<uint32_t> result(source.size());
    result.resize(meshopt_simplify(
        result.data(), source.data(), source.size(), coordinates, positions.size(), sizeof(Float3),
        0, static_cast<float>(std::min(target / scale, 1.0)), options, nullptr));
    result = withoutCollapsed(result);
    if (result.size() == source.size()) break;
    if (result.empty() ||
        ((keepRims || sourceEdges.isClosed()) && !(EdgeBalance(result) == sourceEdges))) {
      target *= 0.5;
      continue;
    }
    const double tolerance = kTolerance * errorBound;
    const DistanceBounds there =
        maxDistance(positions, source, treeOf(positions, result), tolerance, errorBound);
    const DistanceBounds back =
        maxDistance(positions, result, sourceTree, tolerance, errorBound, there.lower);
    const double error = std::max(there.upper, back.upper);
    if (error <= errorBound) return {std::move(result), error};
    target *= std::clamp(0.9 * errorBound / error, 0.2, 0.8);
  }
  return {source, 0};
}

}  // namespace pelage::detail
