// Selects guides for a groom: which strands to simulate, and how the others follow them.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "pelage/authoring/hair_curves.h"
#include "pelage/hair_asset.h"
#include "pelage/result.h"

namespace pelage {

/// Maximum absolute value of a fitted follow hair's tip factor. Its offset is rigid, so a larger
/// factor would swing the tip with the head.
inline constexpr float kMaxFittedTipFactor = 10.0f;

/// Set exactly one of guideCount, guideErrorBound and guides.
struct GuideDef {
  uint32_t guideCount = 0;    ///< >= 1; if the groom has no more hairs than this, all are guides
  float guideErrorBound = 0;  ///< > 0: maximum error of a vertex [m]; uses as few guides as found
  std::vector<uint32_t> guides = {};  ///< indices of the guides in the full groom, ascending
  uint64_t seed = 1;                  ///< the same seed gives the same guides on every machine
  uint32_t guidesPerHair = 3;         ///< maximum number of guides that a hair follows, 1..3
  /// Weight of the distance of two roots relative to the difference in shape, 0..100. Guides far
  /// away may fit the shape at rest, but move with another part of the skin.
  float rootWeight = 0.5f;
};

/// Distances of reconstructed vertices from those of the full groom [m], over all hairs except the
/// guides, which are exact.
struct GuideReport {
  uint32_t hairs = 0;  ///< of the full groom
  uint32_t guides = 0;
  float maxError = 0;
  float meanError = 0;     ///< of all vertices
  float rmsError = 0;      ///< of all vertices
  uint32_t worstHair = 0;  ///< index in the full groom of the hair with maxError
  /// The same if each hair copies the most similar guide, in parallel.
  float maxErrorUnfitted = 0;
  float rmsErrorUnfitted = 0;
};

struct GuideSelection {
  HairAsset guides;              ///< process() has not been called
  std::vector<uint32_t> source;  ///< [guide] index in the full groom, ascending
  /// One for each hair that is no guide; those of a guide are contiguous, as the kernels require.
  std::vector<FollowHair> followHairs;
  std::vector<uint32_t> followSource;  ///< [follow hair] index in the full groom
  std::vector<float> followErrors;     ///< [follow hair] maximum distance of a vertex [m]
  GuideReport report;
};

/// Chooses guides from a groom and fits the other hairs to them.
/// - Guides are the medoids of clusters of hairs: the hairs with the minimum sum of squared
///   distances to the hairs of their cluster. The distance of two hairs a, b with roots r is
///     d^2 = mean over vertices |(a - r_a) - (b - r_b)|^2 + rootWeight^2 |r_a - r_b|^2,
///   of the first 15 polynomial components of the vertices along the strand if it has more than 16
///   vertices. Start: k-means++ (Arthur and Vassilvitskii 2007); then Lloyd's iteration with
///   medoids.
/// - A hair gets those of the 8 most similar guides, the weights and the tip factor that minimize
///   the sum of its vertices' squared distances, as the kernel update_follow_hairs poses it at
///   rest. Its root is exact.
/// - guideErrorBound: clusters of some number, and further guides for the hairs that exceed the
///   bound; the number is searched by growing it by a factor of 4 and bisection.
/// - guides: those of an artist, as CurveLabel::isGuide marks them; only the others are fitted.
///
/// Errors: what validate(HairAsset) refuses, strands with their own vertexCounts (resample them
/// first), a value of `def` out of range.
Result<GuideSelection> selectGuides(const HairAsset& groom, const GuideDef& def,
                                    const AuthoringProgress& progress = {});

/// Returns the positions of follow hairs at rest [hair][vertex] [m], in the kernel's arithmetic; w
/// is the inverse mass of the guide. Errors: what validate(HairAsset) refuses, a guide that does
/// not exist, weights that are not within 0..1 or sum to more than 1.
Result<std::vector<Float4>> evaluateFollowHairs(const HairAsset& guides,
                                                std::span<const FollowHair> hairs);

}  // namespace pelage
