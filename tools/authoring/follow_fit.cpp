#include "follow_fit.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "pelage/authoring/guides.h"
#include "polyline.h"

namespace pelage::detail {
namespace {

// Smaller weights are not worth a guide.
constexpr double kMinWeight = 1e-3;
constexpr int kMaxRotations = 6;
// The problem has several valleys: hair that comes together, runs parallel, comes apart.
constexpr std::array<double, 4> kStarts = {0, -1.5, 1.5, 4};
constexpr double kLeastSlope = -1.0 - double{kMaxFittedTipFactor};
constexpr double kMostSlope = double{kMaxFittedTipFactor} - 1.0;

using Weights = std::array<double, 3>;
using Choice = std::array<size_t, 3>;  // of candidates

struct Fit {
  double squared = std::numeric_limits<double>::infinity();
  Choice choice = {};
  size_t count = 0;
  Weights weights = {};
  double slope = 0;  // factor at the tip - 1
};

// With roots r and r_k, along(v) = v / (V - 1) and weights w_k that sum to 1, a follow hair differs
// from the hair p that it stands for by
//   sum_k w_k (z_k + q along e_k),  z_k = (g_k - r_k) - (p - r),  e_k = r - r_k,
// as its offset is sum_k w_k e_k and its factor 1 + q along. All that the squared length needs are
// the products of z_k and along e_k.
class Products {
 public:
  Products(std::span<const Float4> strand, std::span<const Candidate> guides) {
    const size_t vertexCount = strand.size();
    const Vector root = vectorOf(strand[0]);
    std::vector<Vector> differences(guides.size() * vertexCount);
    for (size_t k = 0; k < guides.size(); ++k) {
      const Vector guideRoot = vectorOf(guides[k].strand[0]);
      offsets_[k] = root - guideRoot;
      for (size_t v = 1; v < vertexCount; ++v) {
        const Vector z = (vectorOf(guides[k].strand[v]) - guideRoot) - (vectorOf(strand[v]) - root);
        const double along = static_cast<double>(v) / static_cast<double>(vertexCount - 1);
        differences[k * vertexCount + v] = z;
        sums_[k] += z * along;
        if (k == 0) alongSquared_ += along * along;
      }
    }
    for (size_t k = 0; k < guides.size(); ++k)
      for (size_t l = 0; l <= k; ++l) {
        double sum = 0;
        for (size_t v = 1; v < vertexCount; ++v)
          sum += dot(differences[k * vertexCount + v], differences[l * vertexCount + v]);
        shapes_[k][l] = shapes_[l][k] = sum;
      }
  }

  // Product of two guides' differences with a slope.
  double product(size_t k, size_t l, double slope) const {
    return shapes_[k][l] + slope * (dot(sums_[k], offsets_[l]) + dot(sums_[l], offsets_[k])) +
           slope * slope * alongSquared_ * dot(offsets_[k], offsets_[l]);
  }

  // The best slope for weights.
  double slope(const Choice& choice, size_t count, const Weights& weights) const {
    Vector offset, sum;
    for (size_t i = 0; i < count; ++i) {
      offset += offsets_[choice[i]] * weights[i];
      sum += sums_[choice[i]] * weights[i];
    }
    return slope(offset, sum);
  }
  double slope(const Vector& offset, const Vector& sum) const {
    const double square = alongSquared_ * dot(offset, offset);
    if (!(square > 0)) return 0;
    return std::clamp(-dot(sum, offset) / square, kLeastSlope, kMostSlope);
  }
  // The slope that is best for an offset as it is stored.
  double slope(const Choice& choice, size_t count, const Weights& weights,
               const Vector& offset) const {
    Vector sum;
    for (size_t i = 0; i < count; ++i) sum += sums_[choice[i]] * weights[i];
    return slope(offset, sum);
  }

 private:
  std::array<std::array<double, kMaxCandidates>, kMaxCandidates> shapes_ = {};  // z_k . z_l
  std::array<Vector, kMaxCandidates> sums_ = {};                                // sum of along z_k
  std::array<Vector, kMaxCandidates> offsets_ = {};                             // e_k
  double alongSquared_ = 0;
};

// Weights that sum to 1 with the least w^T m w; false when there are none above 0. Fewer guides are
// choices of their own.
bool solveWeights(const std::array<std::array<double, 3>, 3>& m, size_t count, Weights& weights) {
  weights = {1, 0, 0};
  if (count == 1) return true;
  if (count == 2) {
    const double square = m[0][0] - 2 * m[0][1] + m[1][1];
    if (!(square > 0)) return false;
    const double w = (m[0][0] - m[0][1]) / square;
    weights = {1 - w, w, 0};
    return w > 0 && w < 1;
  }
  // Unknown: weights 1 and 2.
  const double a = m[0][0] - 2 * m[0][1] + m[1][1];
  const double b = m[0][0] - m[0][1] - m[0][2] + m[1][2];
  const double c = m[0][0] - 2 * m[0][2] + m[2][2];
  const double x = m[0][0] - m[0][1], y = m[0][0] - m[0][2];
  const double determinant = a * c - b * b;
  if (!(determinant > 1e-12 * a * c)) return false;
  const double w1 = (x * c - y * b) / determinant, w2 = (y * a - x * b) / determinant;
  weights = {1 - w1 - w2, w1, w2};
  return weights[0] > 0 && w1 > 0 && w2 > 0;
}

// The best weights for a slope; `squared` stays infinite when there are none above 0.
Fit fitSlope(const Products& products, const Choice& choice, size_t count, double slope) {
  Fit fit = {.choice = choice, .count = count, .slope = slope};
  std::array<std::array<double, 3>, 3> m = {};
  for (size_t i = 0; i < count; ++i)
    for (size_t k = 0; k <= i; ++k)
      m[i][k] = m[k][i] = products.product(choice[i], choice[k], slope);
  if (!solveWeights(m, count, fit.weights)) return fit;
  fit.squared = 0;
  for (size_t i = 0; i < count; ++i)
    for (size_t k = 0; k < count; ++k) fit.squared += fit.weights[i] * fit.weights[k] * m[i][k];
  return fit;
}

// Weights and slope in turns; each turn is the best for the other.
Fit fitChoice(const Products& products, const Choice& choice, size_t count) {
  Fit best;
  for (const double start : kStarts) {
    Fit fit = fitSlope(products, choice, count, start);
    for (int turn = 0; turn < kMaxRotations && std::isfinite(fit.squared); ++turn) {
      const Fit next =
          fitSlope(products, choice, count, products.slope(choice, count, fit.weights));
      if (!(next.squared < fit.squared)) break;
      const bool settled = next.squared > fit.squared * (1 - 1e-3);
      fit = next;
      if (settled) break;
    }
    if (fit.squared < best.squared) best = fit;
    if (count == 1) break;
  }
  return best;
}

// The hair with the weights as they are stored, an offset with which the kernel's sum gives the
// root, and the slope that is best for those.
FollowHair makeHair(const Fit& fit, const Products& products, std::span<const Float4> strand,
                    std::span<const Candidate> guides) {
  std::array<size_t, 3> order = {0, 1, 2};
  // The offset turns with the first guide: that of the largest weight.
  std::stable_sort(order.begin(), order.begin() + static_cast<std::ptrdiff_t>(fit.count),
                   [&](size_t a, size_t b) { return fit.weights[a] > fit.weights[b]; });
  double sum = 0;
  for (size_t i = 0; i < fit.count; ++i)
    if (fit.weights[i] >= kMinWeight) sum += fit.weights[i];
  FollowHair hair;
  hair.guide = guides[fit.choice[order[0]]].guide;
  std::array<const Float4*, 3> strands = {guides[fit.choice[order[0]]].strand, nullptr, nullptr};
  Choice choice = {fit.choice[order[0]], 0, 0};
  size_t used = 1;
  for (size_t i = 1; i < fit.count; ++i) {
    if (fit.weights[order[i]] < kMinWeight) continue;
    const size_t k = fit.choice[order[i]];
    hair.otherGuides[used - 1] = guides[k].guide;
    hair.otherWeights[used - 1] = static_cast<float>(fit.weights[order[i]] / sum);
    strands[used] = guides[k].strand;
    choice[used] = k;
    ++used;
  }
  // None but the first can be 1/2 or more, so that the rest of 1 is above 0.
  const GuideShares shares = sharesOf(hair);
  const Float4* const(&all)[3] = {strands[0], used > 1 ? strands[1] : strands[0],
                                  used > 2 ? strands[2] : strands[0]};
  hair.offset = {0, 0, 0, 1};
  const Float4 mean =
      evaluateFollowVertex(hair, shares, all, 0, static_cast<uint32_t>(strand.size()));
  hair.offset.x = strand[0].x - mean.x;
  hair.offset.y = strand[0].y - mean.y;
  hair.offset.z = strand[0].z - mean.z;
  const Weights stored = {double{shares.shares[0]}, double{shares.shares[1]},
                          double{shares.shares[2]}};
  hair.offset.w =
      static_cast<float>(1 + products.slope(choice, used, stored, vectorOf(hair.offset)));
  return hair;
}

}  // namespace

GuideShares sharesOf(const FollowHair& hair) {
  GuideShares r;
  const float weights[3] = {1 - hair.otherWeights[0] - hair.otherWeights[1], hair.otherWeights[0],
                            hair.otherWeights[1]};
  const uint32_t guides[3] = {hair.guide, hair.otherGuides[0], hair.otherGuides[1]};
  const float sum = weights[0] + weights[1] + weights[2];
  const size_t first = weights[0] > 0 ? 0 : weights[1] > 0 ? 1 : 2;
  r.first = guides[first];
  const bool one = !(sum > std::max({weights[0], weights[1], weights[2]}));
  for (size_t i = 0; i < 3; ++i) {
    // A guide without a share is not read.
    r.shares[i] = one ? (i == first ? 1.0f : 0.0f) : std::max(weights[i], 0.0f) / sum;
    r.guides[i] = r.shares[i] > 0 ? guides[i] : r.first;
  }
  return r;
}

Float4 evaluateFollowVertex(const FollowHair& hair, const GuideShares& shares,
                            const Float4* const (&strands)[3], uint32_t vertex,
                            uint32_t vertexCount) {
  Float4 p;
  for (size_t i = 0; i < 3; ++i) {
    if (!(shares.shares[i] > 0)) continue;
    const Float4& guide = strands[i][vertex];
    p.x += guide.x * shares.shares[i];
    p.y += guide.y * shares.shares[i];
    p.z += guide.z * shares.shares[i];
    if (shares.guides[i] == shares.first) p.w = guide.w;
  }
  const float along = static_cast<float>(vertex) / static_cast<float>(vertexCount - 1);
  const float factor = 1 + (hair.offset.w - 1) * along;
  return {p.x + hair.offset.x * factor, p.y + hair.offset.y * factor, p.z + hair.offset.z * factor,
          p.w};
}

FollowHair copyGuide(std::span<const Float4> strand, const Candidate& guide) {
  FollowHair hair;
  hair.guide = guide.guide;
  hair.offset = {strand[0].x - guide.strand[0].x, strand[0].y - guide.strand[0].y,
                 strand[0].z - guide.strand[0].z, 1};
  return hair;
}

FollowHair fitFollowHair(std::span<const Float4> strand, std::span<const Candidate> guides,
                         uint32_t guidesPerHair) {
  const Products products(strand, guides);
  Fit best;
  const auto consider = [&](const Choice& choice, size_t count) {
    const Fit fit = fitChoice(products, choice, count);
    if (fit.squared < best.squared) best = fit;
  };
  const size_t count = guides.size();
  for (size_t a = 0; a < count; ++a) {
    consider({a, 0, 0}, 1);
    for (size_t b = 0; b < a && guidesPerHair > 1; ++b) {
      consider({a, b, 0}, 2);
      for (size_t c = 0; c < b && guidesPerHair > 2; ++c) consider({a, b, c}, 3);
    }
  }
  return makeHair(best, products, strand, guides);
}

}  // namespace pelage::detail
