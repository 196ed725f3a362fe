#include "hair_clusters.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <utility>

#include "pelage/random.h"
#include "polyline.h"

namespace pelage::detail {
namespace {

constexpr float kInfinity = std::numeric_limits<float>::infinity();
constexpr size_t kMaxComponents = 15;
constexpr uint32_t kLeafSize = 8;

// Orthonormal functions of the vertex, [component][vertex], all 0 at the root: the polynomials
// t, t^2, ... made orthogonal (by Arnoldi's process, with every product orthogonalised twice, which
// is stable). The first few hold nearly all of a hair's shape.
std::vector<std::vector<double>> makeBasis(uint32_t vertexCount) {
  const auto scale = [](std::vector<double>& f) {
    double square = 0;
    for (const double value : f) square += value * value;
    for (double& value : f) value /= std::sqrt(square);
  };
  std::vector<std::vector<double>> basis;
  std::vector<double> next(vertexCount);
  for (uint32_t v = 0; v < vertexCount; ++v) next[v] = v;
  scale(next);
  while (true) {
    basis.push_back(next);
    if (basis.size() == std::min<size_t>(vertexCount - 1, kMaxComponents)) return basis;
    for (uint32_t v = 0; v < vertexCount; ++v)
      next[v] *= static_cast<double>(v) / (vertexCount - 1);
    for (int pass = 0; pass < 2; ++pass)
      for (const std::vector<double>& other : basis) {
        double share = 0;
        for (uint32_t v = 0; v < vertexCount; ++v) share += next[v] * other[v];
        for (uint32_t v = 0; v < vertexCount; ++v) next[v] -= share * other[v];
      }
    scale(next);
  }
}

// The tree over all hairs of a clustering, which knows how far each is from the centers so far.
class SeedTree : public FeatureTree {
 public:
  SeedTree(const HairFeatures& features, std::vector<uint32_t> hairs)
      : FeatureTree(features, std::move(hairs)),
        squared_(hairs_.size(), std::numeric_limits<float>::max()),
        largest_(nodes_.size(), kInfinity),
        sums_(nodes_.size(), 0) {}

  void addCenter(uint32_t hair) { update(features_[hair], 0); }

  // A hair, with a probability that goes with the squared distance from the nearest center; false
  // when every hair is at a center.
  bool draw(Random& random, uint32_t& hair) const {
    if (!(sums_[0] > 0)) return false;
    double rest = random.uniformDouble() * sums_[0];
    size_t node = 0;
    while (nodes_[node].right != 0) {
      const double left = sums_[node + 1];
      // Rounding must not lead into a half where nothing is left.
      const bool goRight = (rest >= left && sums_[nodes_[node].right] > 0) || !(left > 0);
      if (goRight) rest -= left;
      node = goRight ? nodes_[node].right : node + 1;
    }
    for (uint32_t i = nodes_[node].begin; i < nodes_[node].end; ++i) {
      if (!(squared_[i] > 0)) continue;
      hair = hairs_[i];
      rest -= double{squared_[i]};
      if (rest < 0) break;
    }
    return true;
  }

 private:
  void update(const float* center, size_t node) {
    if (boxDistance(center, node, largest_[node]) >= largest_[node]) return;
    const Node& n = nodes_[node];
    if (n.right != 0) {
      update(center, node + 1);
      update(center, n.right);
      largest_[node] = std::max(largest_[node + 1], largest_[n.right]);
      sums_[node] = sums_[node + 1] + sums_[n.right];
      return;
    }
    largest_[node] = 0;
    sums_[node] = 0;
    for (uint32_t i = n.begin; i < n.end; ++i) {
      squared_[i] = std::min(squared_[i], squaredDistance(center, features_[hairs_[i]],
                                                          features_.size(), squared_[i]));
      largest_[node] = std::max(largest_[node], squared_[i]);
      sums_[node] += double{squared_[i]};
    }
  }

  std::vector<float> squared_;  // [index in hairs_]
  std::vector<float> largest_;  // [node]
  std::vector<double> sums_;    // [node]
};

}  // namespace

HairFeatures::HairFeatures(const HairAsset& groom, double rootWeight) : count_(groom.strandCount) {
  const uint32_t vertexCount = groom.verticesPerStrand;
  const std::vector<std::vector<double>> basis = makeBasis(vertexCount);
  const size_t used = 3 + 3 * basis.size();
  size_ = (used + kBlock - 1) / kBlock * kBlock;
  values_.assign(count_ * size_, 0.0f);
  Vector center;
  for (uint32_t i = 0; i < count_; ++i)
    center += vectorOf(groom.positions[uint64_t{i} * vertexCount]) * (1.0 / count_);
  const double perVertex = 1 / std::sqrt(static_cast<double>(vertexCount));
  for (uint32_t i = 0; i < count_; ++i) {
    const Float4* strand = groom.positions.data() + uint64_t{i} * vertexCount;
    float* out = values_.data() + i * size_;
    const auto put = [&](const Vector& v) {
      *out++ = static_cast<float>(v.x);
      *out++ = static_cast<float>(v.y);
      *out++ = static_cast<float>(v.z);
    };
    const Vector root = vectorOf(strand[0]);
    put((root - center) * rootWeight);
    for (const std::vector<double>& component : basis) {
      Vector sum;
      for (uint32_t v = 1; v < vertexCount; ++v) sum += (vectorOf(strand[v]) - root) * component[v];
      put(sum * perVertex);
    }
  }
}

float squaredDistance(const float* a, const float* b, size_t size, float limit) {
  std::array<float, HairFeatures::kBlock> sums = {};
  float total = 0;
  // Most of a distance is in the first components: one look after each three blocks is enough.
  for (size_t i = 0; i < size;) {
    const size_t end = std::min(size, i + 3 * HairFeatures::kBlock);
    for (; i < end; i += HairFeatures::kBlock)
      for (size_t k = 0; k < HairFeatures::kBlock; ++k) {
        const float d = a[i + k] - b[i + k];
        sums[k] += d * d;
      }
    total = (sums[0] + sums[1]) + (sums[2] + sums[3]);
    if (total >= limit) return total;
  }
  return total;
}

FeatureTree::FeatureTree(const HairFeatures& features, std::vector<uint32_t> hairs)
    : features_(features), hairs_(std::move(hairs)) {
  build(0, static_cast<uint32_t>(hairs_.size()));
}

uint32_t FeatureTree::build(uint32_t begin, uint32_t end) {
  const auto index = static_cast<uint32_t>(nodes_.size());
  nodes_.push_back({begin, end, 0});
  const size_t size = features_.size();
  boxes_.resize(boxes_.size() + 2 * size);
  float* low = boxes_.data() + index * 2 * size;
  float* high = low + size;
  std::fill(low, high, kInfinity);
  std::fill(high, high + size, -kInfinity);
  for (uint32_t i = begin; i < end; ++i) {
    const float* point = features_[hairs_[i]];
    for (size_t k = 0; k < size; ++k) {
      low[k] = std::min(low[k], point[k]);
      high[k] = std::max(high[k], point[k]);
    }
  }
  size_t axis = 0;
  for (size_t k = 1; k < size; ++k)
    if (high[k] - low[k] > high[axis] - low[axis]) axis = k;
  const auto first = hairs_.begin() + begin, last = hairs_.begin() + end;
  if (end - begin <= kLeafSize || !(high[axis] > low[axis])) {
    // The library's order inside of a half is not the same everywhere.
    std::sort(first, last);
    return index;
  }
  const uint32_t middle = begin + (end - begin) / 2;
  std::nth_element(first, hairs_.begin() + middle, last, [&](uint32_t a, uint32_t b) {
    const float atA = features_[a][axis], atB = features_[b][axis];
    return atA != atB ? atA < atB : a < b;
  });
  build(begin, middle);
  const uint32_t right = build(middle, end);
  nodes_[index].right = right;
  return index;
}

float FeatureTree::boxDistance(const float* point, size_t node, float limit) const {
  const size_t size = features_.size();
  const float* low = boxes_.data() + node * 2 * size;
  const float* high = low + size;
  std::array<float, HairFeatures::kBlock> sums = {};
  float total = 0;
  for (size_t i = 0; i < size && total < limit;) {
    const size_t end = std::min(size, i + 3 * HairFeatures::kBlock);
    for (; i < end; i += HairFeatures::kBlock)
      for (size_t k = 0; k < HairFeatures::kBlock; ++k) {
        const float below = low[i + k] - point[i + k], above = point[i + k] - high[i + k];
        const float d = std::max(std::max(below, above), 0.0f);
        sums[k] += d * d;
      }
    total = (sums[0] + sums[1]) + (sums[2] + sums[3]);
  }
  // The sum's rounding must not hide a hair that is just below the limit.
  return total * (1 - 0x1p-17f);
}

void FeatureTree::nearest(const float* point, size_t count, std::vector<Neighbor>& found) const {
  found.clear();
  const auto limit = [&] { return found.size() < count ? kInfinity : found.back().squared; };
  struct Visit {
    uint32_t node;
    float bound;
  };
  std::array<Visit, 40> stack;  // halves of 2^32 hairs: at most 33 deep
  size_t height = 0;
  stack[height++] = {0, 0.0f};
  while (height > 0) {
    const Visit visit = stack[--height];
    if (visit.bound > limit()) continue;
    const Node& node = nodes_[visit.node];
    if (node.right != 0) {
      const float most = std::nextafter(limit(), kInfinity);
      Visit near = {visit.node + 1, boxDistance(point, visit.node + 1, most)};
      Visit far = {node.right, boxDistance(point, node.right, most)};
      if (far.bound < near.bound) std::swap(near, far);
      stack[height++] = far;
      stack[height++] = near;
      continue;
    }
    for (uint32_t i = node.begin; i < node.end; ++i) {
      const float most = std::nextafter(limit(), kInfinity);
      const Neighbor next = {squaredDistance(point, features_[hairs_[i]], features_.size(), most),
                             hairs_[i]};
      if (found.size() == count && !(next < found.back())) continue;
      if (found.size() == count) found.pop_back();
      found.insert(std::upper_bound(found.begin(), found.end(), next), next);
    }
  }
}

namespace {

// Hairs far from each other.
std::vector<uint32_t> firstMedoids(const HairFeatures& features, std::span<const uint32_t> hairs,
                                   uint32_t count, uint64_t seed) {
  Random random(seed);
  std::vector<uint32_t> medoids;
  std::vector<bool> isMedoid(features.count(), false);
  const auto add = [&](uint32_t hair) {
    isMedoid[hair] = true;
    medoids.push_back(hair);
  };
  SeedTree seeds(features, {hairs.begin(), hairs.end()});
  uint32_t hair = hairs[random.below(static_cast<uint32_t>(hairs.size()))];
  do {
    add(hair);
    seeds.addCenter(hair);
  } while (medoids.size() < count && seeds.draw(random, hair));
  // The remaining hairs are copies of medoids.
  for (size_t i = 0; medoids.size() < count; ++i)
    if (!isMedoid[hairs[i]]) add(hairs[i]);
  return medoids;
}

struct Clusters {
  std::vector<uint32_t> of;    // [hair of the span] its cluster
  std::vector<float> centers;  // [cluster] mean of the features
};

Clusters clustersAround(const HairFeatures& features, std::span<const uint32_t> hairs,
                        std::span<const uint32_t> medoids) {
  constexpr uint32_t kNoCluster = 0xffffffff;
  const size_t size = features.size(), count = medoids.size();
  std::vector<uint32_t> clusterOf(features.count(), kNoCluster);  // [medoid]
  for (uint32_t c = 0; c < count; ++c) clusterOf[medoids[c]] = c;
  const FeatureTree tree(features, {medoids.begin(), medoids.end()});
  Clusters clusters = {std::vector<uint32_t>(hairs.size()), std::vector<float>(count * size)};
  std::vector<Neighbor> found;
  std::vector<double> sums(count * size, 0.0);
  std::vector<uint32_t> sizes(count, 0);
  for (size_t i = 0; i < hairs.size(); ++i) {
    // A medoid stays in its own cluster, even if another one is in the same place.
    uint32_t c = clusterOf[hairs[i]];
    if (c == kNoCluster) {
      tree.nearest(features[hairs[i]], 1, found);
      c = clusterOf[found[0].hair];
    }
    clusters.of[i] = c;
    ++sizes[c];
    for (size_t k = 0; k < size; ++k) sums[c * size + k] += double{features[hairs[i]][k]};
  }
  for (size_t i = 0; i < sums.size(); ++i)
    clusters.centers[i] = static_cast<float>(sums[i] / sizes[i / size]);
  return clusters;
}

// [cluster] The sum of the squared distances from one point to all of a cluster is its size times
// the squared distance from the mean, and a constant: the medoid is the hair nearest to the mean.
std::vector<uint32_t> medoidsOf(const Clusters& clusters, const HairFeatures& features,
                                std::span<const uint32_t> hairs) {
  const size_t size = features.size();
  std::vector<Neighbor> best(clusters.centers.size() / size, {kInfinity, 0});
  for (size_t i = 0; i < hairs.size(); ++i) {
    const uint32_t c = clusters.of[i];
    const float most = std::nextafter(best[c].squared, kInfinity);
    const Neighbor next = {
        squaredDistance(clusters.centers.data() + c * size, features[hairs[i]], size, most),
        hairs[i]};
    best[c] = std::min(best[c], next);
  }
  std::vector<uint32_t> medoids;
  for (const Neighbor& neighbor : best) medoids.push_back(neighbor.hair);
  return medoids;
}

}  // namespace

std::vector<uint32_t> findMedoids(const HairFeatures& features, std::span<const uint32_t> hairs,
                                  uint32_t count, uint64_t seed,
                                  const std::function<void()>& step) {
  if (count >= hairs.size()) return {hairs.begin(), hairs.end()};
  std::vector<uint32_t> medoids = firstMedoids(features, hairs, count, seed), before;
  for (uint32_t i = 0; i < kClusterIterations && medoids != before; ++i) {
    before = medoids;
    medoids = medoidsOf(clustersAround(features, hairs, before), features, hairs);
    if (step) step();
  }
  std::sort(medoids.begin(), medoids.end());
  return medoids;
}

}  // namespace pelage::detail
