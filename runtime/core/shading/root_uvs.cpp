#include "shading/root_uvs.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <numbers>
#include <numeric>
#include <span>

#include "base/vector3.h"

namespace pelage::detail {

namespace {

using Point = Vector3<double>;
constexpr size_t kNeighbors = 4;

double coordinate(const Point& p, uint8_t axis) { return axis == 0 ? p.x : axis == 1 ? p.y : p.z; }

// The nearest points, nearest first.
struct Nearest {
  std::array<uint32_t, kNeighbors> points = {};
  std::array<double, kNeighbors> squares = {};  // of distances
  size_t count = 0;

  double range() const {
    return count < kNeighbors ? std::numeric_limits<double>::infinity() : squares[count - 1];
  }
  void add(uint32_t point, double square) {
    if (!(square < range())) return;
    if (count < kNeighbors) ++count;
    size_t at = count - 1;
    for (; at > 0 && square < squares[at - 1]; --at) {
      squares[at] = squares[at - 1];
      points[at] = points[at - 1];
    }
    squares[at] = square;
    points[at] = point;
  }
};

// A tree of planes: the middle of each range is the point on its plane, with those below it before
// and those above it behind.
class PointTree {
 public:
  explicit PointTree(std::span<const Point> points)
      : points_(points), order_(points.size()), axes_(points.size()) {
    std::iota(order_.begin(), order_.end(), 0u);
    build(0, order_.size());
  }
  Nearest nearestTo(uint32_t point) const {
    Nearest found;
    search(point, 0, order_.size(), found);
    return found;
  }

 private:
  void build(size_t first, size_t last) {
    if (last - first < 2) return;
    const size_t middle = first + (last - first) / 2;
    const uint8_t axis = axes_[middle] = widestAxis(first, last);
    const auto at = [&](size_t i) { return order_.begin() + static_cast<std::ptrdiff_t>(i); };
    std::nth_element(at(first), at(middle), at(last), [&](uint32_t a, uint32_t b) {
      const double x = coordinate(points_[a], axis), y = coordinate(points_[b], axis);
      return x < y || (x == y && a < b);
    });
    build(first, middle);
    build(middle + 1, last);
  }
  uint8_t widestAxis(size_t first, size_t last) const {
    Point low = points_[order_[first]], high = low;
    for (size_t i = first; i < last; ++i) {
      const Point& p = points_[order_[i]];
      low = {std::min(low.x, p.x), std::min(low.y, p.y), std::min(low.z, p.z)};
      high = {std::max(high.x, p.x), std::max(high.y, p.y), std::max(high.z, p.z)};
    }
    const Point size = high - low;
    if (size.x >= size.y && size.x >= size.z) return 0;
    return size.y >= size.z ? 1 : 2;
  }
  void search(uint32_t point, size_t first, size_t last, Nearest& found) const {
    if (first == last) return;
    const size_t middle = first + (last - first) / 2;
    const uint32_t other = order_[middle];
    const Point apart = points_[other] - points_[point];
    if (other != point) found.add(other, dot(apart, apart));
    const double plane = coordinate(apart, axes_[middle]);
    const bool below = plane > 0;
    search(point, below ? first : middle + 1, below ? middle : last, found);
    if (plane * plane < found.range())
      search(point, below ? middle + 1 : first, below ? last : middle, found);
  }

  std::span<const Point> points_;
  std::vector<uint32_t> order_;
  std::vector<uint8_t> axes_;  // [middle of a range]
};

}  // namespace

std::vector<Float4> rootUvsOf(const HairAsset& asset) {
  std::vector<Point> roots(asset.strandCount);
  for (size_t i = 0; i < roots.size(); ++i) {
    const Float4& p = asset.positions[i * asset.verticesPerStrand];
    roots[i] = {toDouble(p.x), toDouble(p.y), toDouble(p.z)};
  }
  const PointTree tree(roots);
  std::vector<Float4> result(roots.size());
  for (uint32_t i = 0; i < result.size(); ++i) {
    const Float2 uv = asset.strandUv[i];
    result[i] = {uv.x, uv.y, 0, 0};
    const Nearest near = tree.nearestTo(i);
    if (near.count == 0) continue;
    std::vector<double> changes;
    for (size_t n = 0; n < near.count; ++n) {
      if (!(near.squares[n] > 0)) continue;
      const Float2 other = asset.strandUv[near.points[n]];
      changes.push_back(
          std::hypot(toDouble(other.x) - toDouble(uv.x), toDouble(other.y) - toDouble(uv.y)) /
          std::sqrt(near.squares[n]));
    }
    std::sort(changes.begin(), changes.end());
    const double area =
        near.squares[near.count - 1] * std::numbers::pi / static_cast<double>(near.count);
    result[i].z = static_cast<float>(std::sqrt(area));
    // Finite, whatever coordinates there are.
    constexpr double kMax = 1e30;
    if (!changes.empty())
      result[i].w = static_cast<float>(std::min(changes[(changes.size() - 1) / 2], kMax));
  }
  return result;
}

}  // namespace pelage::detail
