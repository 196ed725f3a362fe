#include "influence_blend.h"

#include <algorithm>
#include <vector>

#include "pelage/assert.h"

namespace pelage::detail {

BoneInfluences blendInfluences(std::span<const WeightedInfluences> parts, uint32_t maxBones,
                               double* lost) {
  struct Share {
    uint32_t bone;
    double weight;
  };
  std::vector<Share> shares;
  shares.reserve(4 * parts.size());
  for (const WeightedInfluences& part : parts) {
    double sum = 0;
    for (const float weight : part.influences->weights) sum += weight;
    for (size_t k = 0; k < 4; ++k)
      if (const double weight = part.weight * part.influences->weights[k] / sum; weight > 0)
        shares.push_back({part.influences->bones[k], weight});
  }
  PELAGE_ASSERT(!shares.empty(), "a mean of nothing");
  // Stable, so that the sums have one order.
  std::stable_sort(shares.begin(), shares.end(),
                   [](const Share& a, const Share& b) { return a.bone < b.bone; });
  size_t count = 0;
  for (const Share& share : shares) {
    if (count > 0 && shares[count - 1].bone == share.bone)
      shares[count - 1].weight += share.weight;
    else
      shares[count++] = share;
  }
  shares.resize(count);
  std::stable_sort(shares.begin(), shares.end(),
                   [](const Share& a, const Share& b) { return a.weight > b.weight; });
  const size_t kept = std::min<size_t>(count, maxBones);
  double sum = 0, rest = 0;
  for (size_t i = 0; i < count; ++i) (i < kept ? sum : rest) += shares[i].weight;
  if (lost != nullptr) *lost = rest / (sum + rest);
  BoneInfluences result;
  std::fill(std::begin(result.bones), std::end(result.bones), shares.front().bone);
  for (size_t i = 0; i < kept; ++i) {
    result.bones[i] = shares[i].bone;
    result.weights[i] = static_cast<float>(shares[i].weight / sum);
  }
  return result;
}

}  // namespace pelage::detail
