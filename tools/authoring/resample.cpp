#include "pelage/authoring/hair_curves.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numeric>
#include <string>
#include <utility>
#include <vector>

#include "common/errors.h"
#include "polyline.h"
#include "vertex_placement.h"

namespace pelage {
namespace {

using detail::Curve;
using detail::PolylinePoint;
using detail::Vector;
using detail::vectorOf;
using tools::invalid;

constexpr uint64_t kMaxVertices = 0x7fffffff;
constexpr uint64_t kProgressStride = 256;

float lerp(float a, float b, double t) {
  return static_cast<float>(double{a} + (double{b} - double{a}) * t);
}
Float2 lerp(const Float2& a, const Float2& b, double t) {
  return {lerp(a.x, b.x, t), lerp(a.y, b.y, t)};
}
Float4 lerp(const Float4& a, const Float4& b, double t) {
  return {lerp(a.x, b.x, t), lerp(a.y, b.y, t), lerp(a.z, b.z, t), lerp(a.w, b.w, t)};
}

class Resampler {
 public:
  Resampler(const HairCurves& curves, const ResampleDef& def, const AuthoringProgress& progress)
      : curves_(curves), def_(def), progress_(progress) {
    size_t first = 0;
    for (const uint32_t count : curves.vertexCounts) {
      firsts_.push_back(first);
      first += count;
    }
  }

  Result<ResampleResult> run() {
    uint32_t count = def_.verticesPerStrand;
    if (def_.errorBound > 0) {
      const Result<uint32_t> found = findCount();
      if (!found) return found.error();
      count = *found;
    }
    if (uint64_t{curves_.curveCount()} * count > kMaxVertices)
      return invalid(
          fmt::format("{} curves with {} vertices each are more than 2^31 vertices; take "
                      "fewer vertices or split the groom",
                      curves_.curveCount(), count));
    return build(count);
  }

 private:
  // A strand of a curve.
  struct Strand {
    std::vector<PolylinePoint> sites;
    std::vector<Float3> positions;
    double deviation = 0;
    double lengthChange = 0;  // relative
  };

  Curve load(uint32_t index) const {
    Curve curve;
    const size_t first = firsts_[index];
    for (size_t i = 0; i < curves_.vertexCounts[index]; ++i)
      curve.points.push_back(vectorOf(curves_.positions[first + i]));
    curve.arc = detail::arcLengths(curve.points);
    return curve;
  }

  Strand sample(const Curve& curve, uint32_t count) const {
    Strand strand;
    strand.sites.resize(count);
    if (curve.length() > 0) {
      const std::vector<double> lengths = detail::pointVertices(curve, count, def_.placement);
      for (size_t i = 0; i < count; ++i)
        strand.sites[i] = detail::positionAt(curve.arc, lengths[i]);
      strand.sites.front() = {0, 0};
      strand.sites.back() = {curve.points.size() - 2, 1};
    }
    std::vector<Vector> points;
    for (const PolylinePoint& site : strand.sites) {
      // The very ends: interpolation rounds.
      const Vector p =
          site.share == 1 ? curve.points[site.segment + 1] : detail::pointAt(curve.points, site);
      strand.positions.push_back(
          {static_cast<float>(p.x), static_cast<float>(p.y), static_cast<float>(p.z)});
      points.push_back(vectorOf(strand.positions.back()));
    }
    if (curve.length() > 0) {
      strand.deviation = detail::hausdorffDistance(curve.points, points);
      strand.lengthChange =
          std::abs(detail::arcLengths(points).back() - curve.length()) / curve.length();
    }
    return strand;
  }

  // Curves, each once; twice when the number of vertices is searched for.
  uint64_t total() const { return uint64_t{curves_.curveCount()} * (def_.errorBound > 0 ? 2 : 1); }
  void report(uint64_t done) const {
    if (progress_) progress_(done, total());
  }

  // The smallest number of vertices that holds the bound. More vertices may be worse for a curve
  // than fewer, so that each number has to be tried; the curves that were worst come first, and
  // nearly always one of them says no.
  Result<uint32_t> findCount() const {
    const uint32_t curveCount = curves_.curveCount();
    const auto bound = static_cast<double>(def_.errorBound);
    std::vector<double> deviations(curveCount);
    for (uint32_t i = 0; i < curveCount; ++i) {
      deviations[i] = sample(load(i), kMinVerticesPerStrand).deviation;
      if (i % kProgressStride == 0) report(i);
    }
    std::vector<uint32_t> order(curveCount);
    std::iota(order.begin(), order.end(), 0u);
    std::stable_sort(order.begin(), order.end(),
                     [&](uint32_t a, uint32_t b) { return deviations[a] > deviations[b]; });
    for (uint32_t count = kMinVerticesPerStrand; count <= kMaxVerticesPerStrand; ++count) {
      const auto tooFar = std::find_if(order.begin(), order.end(), [&](uint32_t i) {
        return sample(load(i), count).deviation > bound;
      });
      if (tooFar == order.end()) return count;
      std::rotate(order.begin(), tooFar, tooFar + 1);
    }
    double reached = 0;
    uint32_t worst = 0;
    for (uint32_t i = 0; i < curveCount; ++i) {
      const double deviation = sample(load(i), kMaxVerticesPerStrand).deviation;
      if (deviation > reached) worst = i;
      reached = std::max(reached, deviation);
    }
    return invalid(
        fmt::format("no number of vertices holds the error bound of {} m: {}, the most "
                    "there can be, reach {:.4g} m (curve {})",
                    def_.errorBound, kMaxVerticesPerStrand, reached, worst));
  }

  Result<ResampleResult> build(uint32_t count) const {
    const uint32_t curveCount = curves_.curveCount();
    ResampleResult result;
    HairAsset& asset = result.asset;
    ResampleReport& facts = result.report;
    asset.strandCount = curveCount;
    asset.verticesPerStrand = count;
    asset.positions.reserve(uint64_t{curveCount} * count);
    asset.strandUv = curves_.strandUv;
    std::vector<double> radii;
    double lengthSum = 0, radiusSum = 0, deviationSum = 0, worst = -1, lengthChange = 0;
    for (uint32_t i = 0; i < curveCount; ++i) {
      const Curve curve = load(i);
      const Strand strand = sample(curve, count);
      append(strand, firsts_[i], asset);
      if (!curves_.radii.empty()) {
        radii.push_back(meanRadius(curve, firsts_[i]));
        lengthSum += curve.length();
        radiusSum += curve.length() * radii.back();
      }
      if (!(curve.length() > 0)) ++facts.zeroLengthCurves;
      deviationSum += strand.deviation;
      if (strand.deviation > worst) {
        worst = strand.deviation;
        facts.worstCurve = i;
      }
      lengthChange = std::max(lengthChange, strand.lengthChange);
      if (i % kProgressStride == 0) report(total() - curveCount + i);
    }
    if (lengthSum > 0 && radiusSum > 0) {
      facts.fiberRadius = static_cast<float>(radiusSum / lengthSum);
      for (const double radius : radii)
        asset.strandThickness.push_back(
            static_cast<float>(std::min(radius / double{def_.unitRadius}, double{kMaxCoordinate})));
    }
    facts.strands = curveCount;
    facts.verticesPerStrand = count;
    facts.maxDeviation = static_cast<float>(worst);
    facts.meanDeviation = static_cast<float>(deviationSum / curveCount);
    facts.maxLengthChange = static_cast<float>(lengthChange);
    report(total());
    return result;
  }

  // `first` is the curve's first vertex.
  void append(const Strand& strand, size_t first, HairAsset& asset) const {
    const size_t count = strand.sites.size();
    for (size_t i = 0; i < count; ++i) {
      const PolylinePoint& site = strand.sites[i];
      const size_t a = first + site.segment, b = a + 1;
      float inverseMass =
          curves_.inverseMasses.empty()
              ? 1.0f
              : lerp(curves_.inverseMasses[a], curves_.inverseMasses[b], site.share);
      if (i < 2 || (def_.bothEndsImmovable && i + 2 >= count)) inverseMass = 0;
      const Float3& p = strand.positions[i];
      asset.positions.push_back({p.x, p.y, p.z, inverseMass});
      if (!curves_.colors.empty())
        asset.vertexColor.push_back(lerp(curves_.colors[a], curves_.colors[b], site.share));
      if (!curves_.vertexUv.empty())
        asset.vertexUv.push_back(lerp(curves_.vertexUv[a], curves_.vertexUv[b], site.share));
    }
  }

  // By length; of the vertices where there is none.
  double meanRadius(const Curve& curve, size_t first) const {
    const float* radii = curves_.radii.data() + first;
    const size_t count = curve.points.size();
    double sum = 0;
    if (curve.length() > 0) {
      for (size_t i = 0; i + 1 < count; ++i)
        sum += (double{radii[i]} + double{radii[i + 1]}) / 2 * (curve.arc[i + 1] - curve.arc[i]);
      return sum / curve.length();
    }
    for (size_t i = 0; i < count; ++i) sum += double{radii[i]};
    return sum / static_cast<double>(count);
  }

  const HairCurves& curves_;
  const ResampleDef& def_;
  const AuthoringProgress& progress_;
  std::vector<size_t> firsts_;  // [curve] index of the first vertex
};

Result<void> checkCurves(const HairCurves& curves, const ResampleDef& def) {
  if (def.verticesPerStrand < kMinVerticesPerStrand ||
      def.verticesPerStrand > kMaxVerticesPerStrand)
    return invalid(fmt::format("the vertices per strand are {}; they must be {} to {}",
                               def.verticesPerStrand, kMinVerticesPerStrand,
                               kMaxVerticesPerStrand));
  if (!(def.errorBound >= 0) || !std::isfinite(def.errorBound))
    return invalid(fmt::format("the error bound is {} m; it must be 0 (none) or more, and finite",
                               def.errorBound));
  if (!(def.unitRadius > 0) || !std::isfinite(def.unitRadius))
    return invalid(
        fmt::format("the radius for a thickness of 1 is {} m; it must be above 0, and "
                    "finite",
                    def.unitRadius));
  if (auto r = validate(curves); !r) return r;
  if (curves.vertexCounts.empty()) return invalid("there are no curves to resample");
  size_t vertex = 0;
  for (uint32_t curve = 0; curve < curves.curveCount(); ++curve)
    for (uint32_t i = 0; i < curves.vertexCounts[curve]; ++i, ++vertex) {
      if (!curves.radii.empty() && curves.radii[vertex] < 0)
        return invalid(
            fmt::format("the radius at vertex {} of curve {} is {}; it must not be "
                        "negative",
                        i, curve, curves.radii[vertex]));
      if (!curves.inverseMasses.empty() && curves.inverseMasses[vertex] < 0)
        return invalid(
            fmt::format("the inverse mass of vertex {} of curve {} is {}; it must not be "
                        "negative",
                        i, curve, curves.inverseMasses[vertex]));
    }
  return {};
}

}  // namespace

Result<ResampleResult> resampleCurves(const HairCurves& curves, const ResampleDef& def,
                                      const AuthoringProgress& progress) {
  return tools::guarded([&]() -> Result<ResampleResult> {
    if (auto r = checkCurves(curves, def); !r) return r.error();
    return Resampler(curves, def, progress).run();
  });
}

}  // namespace pelage
