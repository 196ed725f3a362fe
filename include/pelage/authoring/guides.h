// A few guide strands for a groom of many: which ones to simulate, and how the others follow them.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "pelage/authoring/resample.h"
#include "pelage/hair_asset.h"
#include "pelage/result.h"

namespace pelage {

/// Largest factor of a fitted follow hair's offset at the tip, either way. Its offset is rigid, so
/// more would swing the tip with the head.
inline constexpr float kMaxFittedTipFactor = 10.0f;

/// Exactly one of guideCount and guideErrorBound is to be set.
struct GuideDef {
  uint32_t guideCount = 0;     ///< >= 1; when there are no more hairs than that, all are guides
  float guideErrorBound = 0;   ///< > 0: as few guides as are found with no vertex farther off [m]
  uint64_t seed = 1;           ///< the same seed gives the same guides on every machine
  uint32_t guidesPerHair = 3;  ///< guides that a hair is the weighted mean of at most, 1..3
  /// How much the distance of two roots counts against the difference in shape, 0..100. Guides far
  /// away may fit the shape at rest, but move with another part of the skin.
  float rootWeight = 0.5f;
};

/// Distances of reconstructed vertices from those of the full groom [m], over the hairs that are no
/// guides; guides are exact.
struct GuideReport {
  uint32_t hairs = 0;  ///< of the full groom
  uint32_t guides = 0;
  float maxError = 0;
  float meanError = 0;     ///< of all vertices
  float rmsError = 0;      ///< of all vertices
  uint32_t worstHair = 0;  ///< index in the full groom of the hair with maxError
  /// The same when each hair copies the guide that is most like it, parallel.
  float maxErrorUnfitted = 0;
  float rmsErrorUnfitted = 0;
};

struct GuideSelection {
  HairAsset guides;              ///< process() has not been called
  std::vector<uint32_t> source;  ///< [guide] index in the full groom, ascending
  /// One for each hair that is no guide; those of a guide are neighbours, as the kernels like it.
  std::vector<FollowHair> followHairs;
  std::vector<uint32_t> followSource;  ///< [follow hair] index in the full groom
  std::vector<float> followErrors;     ///< [follow hair] largest distance of a vertex [m]
  GuideReport report;
};

/// Chooses guides out of a groom and fits the others to them.
/// - Guides are the medoids of clusters of hairs: those which are, squared, least far from the
///   hairs of their cluster. The distance of two hairs a, b with roots r is
///     d^2 = mean over vertices |(a - r_a) - (b - r_b)|^2 + rootWeight^2 |r_a - r_b|^2,
///   of the vertices' first 15 polynomial components along the strand when it has more than 16.
///   Start: k-means++ (Arthur and Vassilvitskii 2007); then Lloyd's iteration with medoids.
/// - A hair gets those of the 8 most similar guides, their weights and the factor at the tip with
///   which the sum of its vertices' squared distances is least, as the kernel
///   update_follow_strands places it at rest. Its root is exact.
/// - guideErrorBound: clusters of some number, and further guides in place of the hairs that stay
///   beyond the bound; the number is searched by growing it by 4 and bisection.
/// Errors: what validate(HairAsset) refuses, strands with vertexCounts of their own (resample them
/// first), a value of `def` out of range.
Result<GuideSelection> selectGuides(const HairAsset& groom, const GuideDef& def,
                                    const AuthoringProgress& progress = {});

/// Positions of follow hairs at rest [hair][vertex] [m], in the kernel's arithmetic; w is the
/// inverse mass of the guide. Errors: what validate(HairAsset) refuses, a guide that is not there,
/// weights that are not 0 to 1.
Result<std::vector<Float4>> placeFollowHairs(const HairAsset& guides,
                                             std::span<const FollowHair> hairs);

}  // namespace pelage
