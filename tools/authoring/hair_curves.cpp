#include "pelage/authoring/hair_curves.h"

#include <fmt/format.h>

#include <cstddef>
#include <string_view>

#include "common/errors.h"
#include "common/finite.h"
#include "pelage/hair_asset.h"
#include "points.h"

namespace pelage {
namespace {

using detail::isCoordinate;
using tools::invalid;
using tools::isFinite;

template <class T>
Result<void> checkArray(const std::vector<T>& values, size_t count, std::string_view what) {
  if (values.empty()) return {};
  if (values.size() != count)
    return invalid(fmt::format("curves: {} {} for {} elements", values.size(), what, count));
  for (size_t i = 0; i < count; ++i)
    if (!isFinite(values[i]))
      return invalid(fmt::format("curves: number {} of the {} is not finite", i, what));
  return {};
}

}  // namespace

Result<void> validate(const HairCurves& curves) {
  size_t vertex = 0;
  for (size_t curve = 0; curve < curves.vertexCounts.size(); ++curve) {
    const uint32_t count = curves.vertexCounts[curve];
    if (count < kMinVerticesPerStrand)
      return invalid(fmt::format("curve {} has {} vertices; it needs 2 or more", curve, count));
    if (count > curves.positions.size() - vertex)
      return invalid(fmt::format("curve {} has vertices {} to {}, but there are {} positions",
                                 curve, vertex, vertex + count, curves.positions.size()));
    for (const size_t end = vertex + count; vertex < end; ++vertex)
      if (const Float3& p = curves.positions[vertex]; !isCoordinate(p))
        return invalid(
            fmt::format("vertex {} of curve {} is at {} {} {}; coordinates must be within "
                        "+-1e6",
                        count - (end - vertex), curve, p.x, p.y, p.z));
  }
  if (vertex != curves.positions.size())
    return invalid(fmt::format("{} positions for {} vertices", curves.positions.size(), vertex));
  if (!curves.labels.empty() && curves.labels.size() != curves.vertexCounts.size())
    return invalid(fmt::format("curves: {} labels for {} curves", curves.labels.size(),
                               curves.vertexCounts.size()));
  if (auto r = checkArray(curves.inverseMasses, vertex, "inverse masses"); !r) return r;
  if (auto r = checkArray(curves.radii, vertex, "radii"); !r) return r;
  if (auto r = checkArray(curves.colors, vertex, "colors"); !r) return r;
  if (auto r = checkArray(curves.vertexUv, vertex, "vertex UV"); !r) return r;
  return checkArray(curves.strandUv, curves.vertexCounts.size(), "strand UV");
}

}  // namespace pelage
