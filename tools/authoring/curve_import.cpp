#include "pelage/authoring/hair_curves.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <type_traits>
#include <utility>
#include <vector>

#include "axes.h"
#include "common/errors.h"
#include "pelage/hair_asset.h"
#include "pelage/random.h"
#include "points.h"

namespace pelage {
namespace {

Error invalidCurves(std::string what) { return tools::invalid("curves: " + std::move(what)); }

Result<void> checkDef(const CurveImportDef& def) {
  if (!detail::isScale(def.scale))
    return invalidCurves(fmt::format("the scale is {}; it must be 1e-9 to 1e9", def.scale));
  if (!(def.minCurveLength >= 0 && def.minCurveLength <= kMaxCoordinate))
    return invalidCurves(
        fmt::format("minCurveLength is {} m; it must be 0 to 1e6", def.minCurveLength));
  return {};
}

// Whether the arrays fit together; unlike validate(), not their values.
Result<void> checkSizes(const HairCurves& curves) {
  uint64_t vertexCount = 0;
  for (const uint32_t count : curves.vertexCounts) vertexCount += count;
  if (curves.positions.size() != vertexCount)
    return invalidCurves(
        fmt::format("{} positions for {} vertices", curves.positions.size(), vertexCount));
  const auto fits = [](size_t size, uint64_t count) { return size == 0 || size == count; };
  if (!fits(curves.inverseMasses.size(), vertexCount) || !fits(curves.radii.size(), vertexCount) ||
      !fits(curves.colors.size(), vertexCount) || !fits(curves.vertexUv.size(), vertexCount) ||
      !fits(curves.strandUv.size(), curves.vertexCounts.size()) ||
      !fits(curves.labels.size(), curves.vertexCounts.size()))
    return invalidCurves(fmt::format("arrays that do not fit {} curves with {} vertices",
                                     curves.vertexCounts.size(), vertexCount));
  return {};
}

class Preparation {
 public:
  Preparation(HairCurves& curves, const CurveImportDef& def, CurveImportReport& report)
      : curves_(curves), def_(def), report_(report) {}

  Result<void> run() {
    report_.curvesRead = curves_.vertexCounts.size();
    report_.verticesRead = curves_.positions.size();
    for (Float3& p : curves_.positions) p = toMetres(p);
    repairValues();
    dropCurves();
    if (curves_.vertexCounts.empty())
      return invalidCurves(
          fmt::format("none of {} is left: {} with a single vertex, {} without usable "
                      "coordinates, {} without length, {} shorter than {} m (check the "
                      "scale)",
                      report_.curvesRead, report_.droppedSingleVertex, report_.droppedUnusable,
                      report_.droppedNoLength, report_.droppedShort, def_.minCurveLength));
    if (def_.randomizeStrands) shuffle();
    report_.curvesKept = curves_.vertexCounts.size();
    report_.verticesKept = curves_.positions.size();
    return {};
  }

 private:
  Float3 toMetres(const Float3& p) const {
    return detail::turned({p.x * def_.scale, p.y * def_.scale, p.z * def_.scale}, def_.upAxis,
                          def_.invertZ);
  }

  void repair(float& value, float lowest) {
    if (std::isfinite(value) && value >= lowest) return;
    value = 0;
    ++report_.repairedValues;
  }

  void repairValues() {
    constexpr float kLowest = std::numeric_limits<float>::lowest();
    for (float& mass : curves_.inverseMasses) repair(mass, 0);
    for (float& radius : curves_.radii) {
      radius *= def_.scale;
      repair(radius, 0);
    }
    for (Float4& color : curves_.colors)
      for (float* value : {&color.x, &color.y, &color.z, &color.w}) repair(*value, kLowest);
    for (std::vector<Float2>* uvs : {&curves_.vertexUv, &curves_.strandUv})
      for (Float2& uv : *uvs) {
        if (def_.invertV) uv.y = 1 - uv.y;
        repair(uv.x, kLowest);
        repair(uv.y, kLowest);
      }
  }

  static double distance(const Float3& a, const Float3& b) {
    const double x = double{b.x} - a.x, y = double{b.y} - a.y, z = double{b.z} - a.z;
    return std::sqrt(x * x + y * y + z * z);
  }

  // Moves what is kept to the front of the arrays.
  void dropCurves() {
    size_t from = 0, to = 0, curveTo = 0;
    double sum = 0;
    for (size_t curve = 0; curve < curves_.vertexCounts.size(); ++curve) {
      const uint32_t count = curves_.vertexCounts[curve];
      const size_t begin = to;
      for (const size_t end = from + count; from < end; ++from) {
        if (!detail::isCoordinate(curves_.positions[from])) {
          ++report_.removedVertices;
          continue;
        }
        moveVertex(from, to++);
      }
      const auto kept = static_cast<uint32_t>(to - begin);
      double length = 0;
      for (size_t i = begin + 1; i < to; ++i)
        length += distance(curves_.positions[i - 1], curves_.positions[i]);
      if (!keeps(count, kept, length)) {
        to = begin;
        continue;
      }
      report_.minLength = curveTo == 0 ? length : std::min(report_.minLength, length);
      report_.maxLength = std::max(report_.maxLength, length);
      sum += length;
      curves_.vertexCounts[curveTo] = kept;
      if (!curves_.strandUv.empty()) curves_.strandUv[curveTo] = curves_.strandUv[curve];
      if (!curves_.labels.empty()) curves_.labels[curveTo] = curves_.labels[curve];
      ++curveTo;
    }
    resizeVertices(to);
    curves_.vertexCounts.resize(curveTo);
    if (!curves_.strandUv.empty()) curves_.strandUv.resize(curveTo);
    if (!curves_.labels.empty()) curves_.labels.resize(curveTo);
    if (curveTo > 0) report_.meanLength = sum / static_cast<double>(curveTo);
  }

  bool keeps(uint32_t count, uint32_t kept, double length) {
    uint64_t* dropped = count < kMinVerticesPerStrand          ? &report_.droppedSingleVertex
                        : kept < kMinVerticesPerStrand         ? &report_.droppedUnusable
                        : !(length > kMinSegmentLength)        ? &report_.droppedNoLength
                        : length < double{def_.minCurveLength} ? &report_.droppedShort
                                                               : nullptr;
    if (dropped != nullptr) ++*dropped;
    return dropped == nullptr;
  }

  void moveVertex(size_t from, size_t to) {
    curves_.positions[to] = curves_.positions[from];
    if (!curves_.inverseMasses.empty()) curves_.inverseMasses[to] = curves_.inverseMasses[from];
    if (!curves_.radii.empty()) curves_.radii[to] = curves_.radii[from];
    if (!curves_.colors.empty()) curves_.colors[to] = curves_.colors[from];
    if (!curves_.vertexUv.empty()) curves_.vertexUv[to] = curves_.vertexUv[from];
  }

  void resizeVertices(size_t count) {
    curves_.positions.resize(count);
    if (!curves_.inverseMasses.empty()) curves_.inverseMasses.resize(count);
    if (!curves_.radii.empty()) curves_.radii.resize(count);
    if (!curves_.colors.empty()) curves_.colors.resize(count);
    if (!curves_.vertexUv.empty()) curves_.vertexUv.resize(count);
  }

  // Fisher and Yates, in the form of Durstenfeld 1964, "Algorithm 235: Random permutation".
  void shuffle() {
    std::vector<uint32_t> order(curves_.vertexCounts.size());
    std::iota(order.begin(), order.end(), 0u);
    Random random(def_.seed);
    for (size_t i = order.size(); i > 1; --i)
      std::swap(order[i - 1], order[random.below(static_cast<uint32_t>(i))]);
    std::vector<size_t> begins(order.size());
    size_t vertex = 0;
    for (size_t i = 0; i < begins.size(); ++i) {
      begins[i] = vertex;
      vertex += curves_.vertexCounts[i];
    }
    const auto reorder = [&](auto& values, bool perVertex) {
      if (values.empty()) return;
      std::remove_reference_t<decltype(values)> sorted;
      sorted.reserve(values.size());
      for (const uint32_t curve : order) {
        const size_t begin = perVertex ? begins[curve] : curve;
        const size_t count = perVertex ? curves_.vertexCounts[curve] : 1;
        for (size_t i = 0; i < count; ++i) sorted.push_back(values[begin + i]);
      }
      values = std::move(sorted);
    };
    reorder(curves_.positions, true);
    reorder(curves_.inverseMasses, true);
    reorder(curves_.radii, true);
    reorder(curves_.colors, true);
    reorder(curves_.vertexUv, true);
    reorder(curves_.strandUv, false);
    reorder(curves_.labels, false);
    reorder(curves_.vertexCounts, false);
  }

  HairCurves& curves_;
  const CurveImportDef& def_;
  CurveImportReport& report_;
};

}  // namespace

Result<void> prepareCurves(HairCurves& curves, const CurveImportDef& def,
                           CurveImportReport* report) {
  return tools::guarded([&]() -> Result<void> {
    CurveImportReport found;
    if (auto r = checkDef(def); !r) return r;
    if (auto r = checkSizes(curves); !r) return r;
    if (curves.vertexCounts.size() > std::numeric_limits<uint32_t>::max())
      return invalidCurves("more than 2^32 - 1; split the groom");
    auto done = Preparation(curves, def, found).run();
    if (report != nullptr) *report = found;
    return done;
  });
}

}  // namespace pelage
