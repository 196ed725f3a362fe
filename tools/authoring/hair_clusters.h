// Hairs as points of a space in which near ones look alike, and clusters of them.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "pelage/hair_asset.h"

namespace pelage::detail {

/// A point for each hair; their squared distances are those of selectGuides().
class HairFeatures {
 public:
  /// `groom` is valid.
  HairFeatures(const HairAsset& groom, double rootWeight);

  uint32_t count() const { return count_; }
  size_t size() const { return size_; }  ///< numbers a point, a multiple of kBlock
  const float* operator[](size_t hair) const { return values_.data() + hair * size_; }

  static constexpr size_t kBlock = 4;

 private:
  uint32_t count_;
  size_t size_;
  std::vector<float> values_;
};

/// Squared distance of two points; some value >= `limit` when it is not below `limit`.
float squaredDistance(const float* a, const float* b, size_t size, float limit);

struct Neighbor {
  float squared = 0;
  uint32_t hair = 0;
  bool operator<(const Neighbor& o) const {
    return squared != o.squared ? squared < o.squared : hair < o.hair;
  }
};

/// A k-d tree (Friedman, Bentley and Finkel 1977) with boxes, over some of the hairs.
class FeatureTree {
 public:
  /// `hairs` must not be empty.
  FeatureTree(const HairFeatures& features, std::vector<uint32_t> hairs);

  /// The nearest `count` hairs, nearest first; fewer when there are fewer. Equally near ones in
  /// the order of their indices.
  void nearest(const float* point, size_t count, std::vector<Neighbor>& found) const;

 protected:
  struct Node {
    uint32_t begin = 0, end = 0;  // of hairs_
    uint32_t right = 0;           // child; the left one is the next node; 0: a leaf
  };
  // Squared distance of a node's box; some value >= limit when it is not below.
  float boxDistance(const float* point, size_t node, float limit) const;

  const HairFeatures& features_;
  std::vector<uint32_t> hairs_;
  std::vector<Node> nodes_;

 private:
  uint32_t build(uint32_t begin, uint32_t end);

  std::vector<float> boxes_;  // [node] low, high, each of features_.size()
};

/// The medoids of `count` clusters of `hairs`, ascending: all of them when there are no more.
/// \param hairs ascending, not empty. \param step called after each iteration.
std::vector<uint32_t> findMedoids(const HairFeatures& features, std::span<const uint32_t> hairs,
                                  uint32_t count, uint64_t seed,
                                  const std::function<void()>& step = {});

inline constexpr uint32_t kClusterIterations = 20;

}  // namespace pelage::detail
