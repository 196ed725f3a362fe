#include "pelage/authoring/guides.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <iterator>
#include <limits>
#include <numeric>
#include <string>
#include <utility>

#include "common/errors.h"
#include "follow_fit.h"
#include "hair_clusters.h"
#include "polyline.h"

namespace pelage {
namespace {

using detail::Candidate;
using detail::FeatureTree;
using detail::HairFeatures;
using detail::Neighbor;
using detail::vectorOf;
using tools::invalid;

// With an error bound: a round makes guides of one in so many hairs beyond it.
constexpr uint32_t kHairsPerPromotion = 8;
constexpr uint32_t kGrowth = 4;  // of the number of clusters, until it no longer gets better
constexpr uint32_t kBisections = 3;
constexpr uint64_t kMaxTrials = 16;  // numbers of clusters tried at most, for the progress

// Distances of the vertices of a placed hair from where they should be.
struct Deviation {
  double largest = 0, sum = 0, squares = 0;
};

class Selector {
 public:
  Selector(const HairAsset& groom, const GuideDef& def, const AuthoringProgress& progress)
      : groom_(groom),
        def_(def),
        progress_(progress),
        features_(groom, double{def.rootWeight}),
        everyHair_(groom.strandCount),
        evaluated_(groom.verticesPerStrand) {
    std::iota(everyHair_.begin(), everyHair_.end(), 0u);
  }

  GuideSelection run() {
    if (def_.guideCount > 0) {
      total_ = uint64_t{detail::kClusterIterations} + 2;
      guides_ = detail::findMedoids(features_, everyHair_, def_.guideCount, def_.seed,
                                    [this] { step(); });
      fitAll();
    } else if (!def_.guides.empty()) {
      total_ = 2;
      guides_ = def_.guides;
      fitAll();
    } else {
      total_ = kMaxTrials;
      searchForBound();
    }
    return finish();
  }

 private:
  struct Follow {
    FollowHair hair;  // guides by their index in the full groom
    Deviation deviation;
  };

  void step() {
    done_ = std::min(done_ + 1, total_ - 1);
    if (progress_) progress_(done_, total_);
  }

  std::span<const Float4> strandOf(uint32_t hair) const {
    const size_t count = groom_.verticesPerStrand;
    return {groom_.positions.data() + hair * count, count};
  }

  Deviation measure(uint32_t hair, const FollowHair& follow) {
    detail::evaluateFollowHair(
        follow, groom_.verticesPerStrand, [&](uint32_t guide) { return strandOf(guide).data(); },
        evaluated_.data());
    const std::span<const Float4> strand = strandOf(hair);
    Deviation r;
    for (size_t v = 0; v < strand.size(); ++v) {
      const detail::Vector d = vectorOf(evaluated_[v]) - vectorOf(strand[v]);
      const double square = dot(d, d);
      r.largest = std::max(r.largest, square);
      r.sum += std::sqrt(square);
      r.squares += square;
    }
    r.largest = std::sqrt(r.largest);
    return r;
  }

  // Fits some hairs, none of them a guide, to guides_.
  void fit(std::span<const uint32_t> hairs) {
    const FeatureTree tree(features_, guides_);
    std::vector<Neighbor> found;
    std::vector<Candidate> candidates;
    for (const uint32_t hair : hairs) {
      tree.nearest(features_[hair], detail::kMaxCandidates, found);
      candidates.clear();
      for (const Neighbor& n : found) candidates.push_back({n.hair, strandOf(n.hair).data()});
      Follow& follow = follows_[hair];
      follow.hair = detail::fitFollowHair(strandOf(hair), candidates, def_.guidesPerHair);
      follow.deviation = measure(hair, follow.hair);
    }
  }

  void fitAll() {
    follows_.assign(groom_.strandCount, {});
    fit(followers());
    step();
  }

  std::vector<uint32_t> followers() const {
    std::vector<uint32_t> hairs;
    std::set_difference(everyHair_.begin(), everyHair_.end(), guides_.begin(), guides_.end(),
                        std::back_inserter(hairs));
    return hairs;
  }

  // Clusters, then further guides until no hair is beyond the bound; or until there are `most`
  // guides, which is of no use.
  void tryClusters(uint32_t count, size_t most) {
    guides_ = detail::findMedoids(features_, everyHair_, count, def_.seed);
    fitAll();
    std::vector<uint32_t> beyond = followers();
    while (guides_.size() < most) {
      std::erase_if(beyond, [&](uint32_t hair) {
        return follows_[hair].deviation.largest <= double{def_.guideErrorBound};
      });
      if (beyond.empty()) return;
      const auto more =
          static_cast<uint32_t>(beyond.size() + kHairsPerPromotion - 1) / kHairsPerPromotion;
      const std::vector<uint32_t> added = detail::findMedoids(features_, beyond, more, def_.seed);
      std::vector<uint32_t> all;
      std::merge(guides_.begin(), guides_.end(), added.begin(), added.end(),
                 std::back_inserter(all));
      guides_ = std::move(all);
      std::vector<uint32_t> rest;
      std::set_difference(beyond.begin(), beyond.end(), added.begin(), added.end(),
                          std::back_inserter(rest));
      beyond = std::move(rest);
      fit(beyond);
    }
  }

  void searchForBound() {
    std::vector<uint32_t> bestGuides;
    std::vector<Follow> bestFollows;
    uint32_t bestCount = 0;
    // Guides that come out of `count` clusters.
    const auto attempt = [&](uint32_t count) {
      tryClusters(count,
                  bestGuides.empty() ? std::numeric_limits<size_t>::max() : bestGuides.size());
      const size_t found = guides_.size();
      if (bestGuides.empty() || found < bestGuides.size()) {
        bestGuides = std::move(guides_);
        bestFollows = std::move(follows_);
        bestCount = count;
      }
      return found;
    };
    // Clusters alone are guides already: no number beyond the best can be better.
    int worse = 0;
    for (uint64_t count = 1; count <= groom_.strandCount && worse < 2; count *= kGrowth) {
      if (!bestGuides.empty() && count >= bestGuides.size()) break;
      const size_t before = bestGuides.size();
      worse = attempt(static_cast<uint32_t>(count)) >= before && before > 0 ? worse + 1 : 0;
    }
    for (uint32_t width = bestCount / 2, k = 0; k < kBisections && width > 0; ++k, width /= 2) {
      const uint32_t middle = bestCount;
      attempt(middle - width);
      if (bestCount == middle) attempt(middle + width);
    }
    guides_ = std::move(bestGuides);
    follows_ = std::move(bestFollows);
  }

  GuideSelection finish() {
    GuideSelection result;
    result.source = guides_;
    result.followSource = followers();
    copyGuides(result.guides);

    std::vector<uint32_t> guideOf(groom_.strandCount, 0);
    for (size_t i = 0; i < guides_.size(); ++i) guideOf[guides_[i]] = static_cast<uint32_t>(i);
    std::vector<uint32_t> owners, sources;
    for (const uint32_t source : result.followSource)
      owners.push_back(guideOf[follows_[source].hair.guide]);
    for (const uint32_t i : spreadOrder(owners, static_cast<uint32_t>(guides_.size())))
      sources.push_back(result.followSource[i]);
    result.followSource = std::move(sources);
    const FeatureTree tree(features_, guides_);
    std::vector<Neighbor> found;
    Deviation all, unfitted;
    GuideReport& report = result.report;
    for (const uint32_t source : result.followSource) {
      const Follow& follow = follows_[source];
      FollowHair hair = follow.hair;
      hair.guide = guideOf[hair.guide];
      for (size_t k = 0; k < 2; ++k)
        hair.otherGuides[k] = hair.otherWeights[k] > 0 ? guideOf[hair.otherGuides[k]] : 0;
      result.followHairs.push_back(hair);
      result.followErrors.push_back(static_cast<float>(follow.deviation.largest));
      if (follow.deviation.largest > all.largest || result.followErrors.size() == 1)
        report.worstHair = source;
      add(follow.deviation, all);
      tree.nearest(features_[source], 1, found);
      const Candidate nearest = {found[0].hair, strandOf(found[0].hair).data()};
      add(measure(source, detail::copyGuide(strandOf(source), nearest)), unfitted);
    }
    report.hairs = groom_.strandCount;
    report.guides = static_cast<uint32_t>(guides_.size());
    const double vertices =
        std::max(static_cast<double>(result.followSource.size()) * groom_.verticesPerStrand, 1.0);
    report.maxError = static_cast<float>(all.largest);
    report.meanError = static_cast<float>(all.sum / vertices);
    report.rmsError = static_cast<float>(std::sqrt(all.squares / vertices));
    report.maxErrorUnfitted = static_cast<float>(unfitted.largest);
    report.rmsErrorUnfitted = static_cast<float>(std::sqrt(unfitted.squares / vertices));
    if (progress_) progress_(total_, total_);
    return result;
  }

  static void add(const Deviation& one, Deviation& all) {
    all.largest = std::max(all.largest, one.largest);
    all.sum += one.sum;
    all.squares += one.squares;
  }

  void copyGuides(HairAsset& out) const {
    out.strandCount = static_cast<uint32_t>(guides_.size());
    out.verticesPerStrand = groom_.verticesPerStrand;
    out.fileLayout = groom_.fileLayout;
    const auto copy = [&](const auto& from, auto& to, size_t perStrand) {
      if (from.empty()) return;
      for (const uint32_t guide : guides_)
        to.insert(to.end(), from.begin() + static_cast<std::ptrdiff_t>(guide * perStrand),
                  from.begin() + static_cast<std::ptrdiff_t>((guide + 1) * perStrand));
    };
    copy(groom_.positions, out.positions, groom_.verticesPerStrand);
    copy(groom_.strandUv, out.strandUv, 1);
    copy(groom_.vertexUv, out.vertexUv, groom_.verticesPerStrand);
    copy(groom_.strandThickness, out.strandThickness, 1);
    copy(groom_.vertexColor, out.vertexColor, groom_.verticesPerStrand);
  }

  const HairAsset& groom_;
  const GuideDef& def_;
  const AuthoringProgress& progress_;
  uint64_t done_ = 0, total_ = 1;
  HairFeatures features_;
  std::vector<uint32_t> everyHair_;
  std::vector<Float4> evaluated_;  // of the hair being measured
  std::vector<uint32_t> guides_;   // ascending
  std::vector<Follow> follows_;    // [hair]; those of guides are not used
};

Result<void> checkGroom(const HairAsset& groom, const GuideDef& def) {
  const bool bounded = def.guideErrorBound != 0;
  if ((def.guideCount > 0) + bounded + !def.guides.empty() != 1)
    return invalid("either a number of guides, an error bound of theirs or a list is needed");
  for (size_t i = 0; i < def.guides.size(); ++i)
    if (def.guides[i] >= groom.strandCount || (i > 0 && def.guides[i] <= def.guides[i - 1]))
      return invalid(fmt::format("entry {} of the guides is {}; they ascend, below {}", i,
                                 def.guides[i], groom.strandCount));
  if (bounded && !(def.guideErrorBound > 0 && std::isfinite(def.guideErrorBound)))
    return invalid(
        fmt::format("the error bound of guides is {} m; it must be above 0", def.guideErrorBound));
  if (def.guidesPerHair < 1 || def.guidesPerHair > 3)
    return invalid(
        fmt::format("the number of guides per hair is {}; it must be 1 to 3", def.guidesPerHair));
  if (!(def.rootWeight >= 0 && def.rootWeight <= 100))
    return invalid(
        fmt::format("the weight of the roots is {}; it must be 0 to 100", def.rootWeight));
  if (auto r = validate(groom); !r) return r;
  for (size_t i = 0; i < groom.vertexCounts.size(); ++i)
    if (groom.vertexCounts[i] != groom.verticesPerStrand)
      return invalid(
          fmt::format("strand {} has {} vertices of {}; resample the hair to one number "
                      "before guides are selected",
                      i, groom.vertexCounts[i], groom.verticesPerStrand));
  return {};
}

Result<std::vector<Float4>> point(const HairAsset& guides, std::span<const FollowHair> hairs) {
  if (auto r = validate(guides); !r) return r.error();
  const size_t count = guides.verticesPerStrand;
  std::vector<Float4> placed(hairs.size() * count);
  for (size_t i = 0; i < hairs.size(); ++i) {
    const FollowHair& hair = hairs[i];
    for (const uint32_t guide : {hair.guide, hair.otherGuides[0], hair.otherGuides[1]})
      if (guide >= guides.strandCount)
        return invalid(
            fmt::format("follow hair {} follows guide {} of {}", i, guide, guides.strandCount));
    if (!(hair.otherWeights[0] >= 0 && hair.otherWeights[1] >= 0 &&
          hair.otherWeights[0] + hair.otherWeights[1] <= 1))
      return invalid(fmt::format("the weights of follow hair {} are not 0 to 1", i));
    detail::evaluateFollowHair(
        hair, guides.verticesPerStrand,
        [&](uint32_t guide) { return guides.positions.data() + guide * count; },
        placed.data() + i * count);
  }
  return placed;
}

}  // namespace

Result<GuideSelection> selectGuides(const HairAsset& groom, const GuideDef& def,
                                    const AuthoringProgress& progress) {
  return tools::guarded([&]() -> Result<GuideSelection> {
    if (auto r = checkGroom(groom, def); !r) return r.error();
    return Selector(groom, def, progress).run();
  });
}

Result<std::vector<Float4>> evaluateFollowHairs(const HairAsset& guides,
                                                std::span<const FollowHair> hairs) {
  return tools::guarded([&] { return point(guides, hairs); });
}

}  // namespace pelage
