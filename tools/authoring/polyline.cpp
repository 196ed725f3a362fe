#include "polyline.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>

namespace pelage::detail {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr double kRelativeTolerance = 0x1p-30;

}  // namespace

double squaredDistance(const Vector& p, const Vector& a, const Vector& b) {
  const Vector edge = b - a, arm = p - a;
  const double square = dot(edge, edge);
  const double share = square > 0 ? std::clamp(dot(arm, edge) / square, 0.0, 1.0) : 0.0;
  const Vector difference = arm - edge * share;
  return dot(difference, difference);
}

std::vector<double> arcLengths(std::span<const Vector> points) {
  std::vector<double> arc(points.size());
  for (size_t i = 1; i < points.size(); ++i)
    arc[i] = arc[i - 1] + length(points[i] - points[i - 1]);
  return arc;
}

PolylinePoint positionAt(std::span<const double> arc, double length) {
  // The first point at or beyond the length ends its segment; a segment without length is skipped.
  const auto end = std::lower_bound(arc.begin() + 1, arc.end() - 1, length);
  const auto segment = static_cast<size_t>(end - arc.begin()) - 1;
  const double size = arc[segment + 1] - arc[segment];
  if (!(size > 0)) return {segment, 1};
  return {segment, std::clamp((length - arc[segment]) / size, 0.0, 1.0)};
}

PolylineTree::PolylineTree(std::span<const Vector> points) : points_(points) {
  const size_t segments = points.size() - 1;
  leafCount_ = std::bit_ceil((segments + kLeafSize - 1) / kLeafSize);
  const Box empty = {{kInfinity, kInfinity, kInfinity}, {-kInfinity, -kInfinity, -kInfinity}};
  boxes_.assign(2 * leafCount_, empty);
  const auto grow = [](Box& box, const Vector& low, const Vector& high) {
    box.low = {std::min(box.low.x, low.x), std::min(box.low.y, low.y), std::min(box.low.z, low.z)};
    box.high = {std::max(box.high.x, high.x), std::max(box.high.y, high.y),
                std::max(box.high.z, high.z)};
  };
  for (size_t i = 0; i < segments; ++i)
    for (const Vector& p : {points[i], points[i + 1]})
      grow(boxes_[leafCount_ + i / kLeafSize], p, p);
  for (size_t node = leafCount_ - 1; node >= 1; --node)
    for (const size_t child : {2 * node, 2 * node + 1})
      grow(boxes_[node], boxes_[child].low, boxes_[child].high);
}

double PolylineTree::squaredDistance(const Vector& p, const Box& box) {
  // An empty box is infinitely far.
  const auto outside = [](double value, double low, double high) {
    return std::max({low - value, value - high, 0.0});
  };
  const Vector d = {outside(p.x, box.low.x, box.high.x), outside(p.y, box.low.y, box.high.y),
                    outside(p.z, box.low.z, box.high.z)};
  return dot(d, d);
}

double PolylineTree::squaredRange(const Vector& p, const Vector& q, size_t& hint) const {
  const auto extentOf = [&](size_t i) {
    return std::max(detail::squaredDistance(p, points_[i], points_[i + 1]),
                    detail::squaredDistance(q, points_[i], points_[i + 1]));
  };
  const auto boundOf = [&](size_t node) {
    return std::max(squaredDistance(p, boxes_[node]), squaredDistance(q, boxes_[node]));
  };
  double best = extentOf(hint);
  struct Visit {
    size_t node;
    double bound;
  };
  std::array<Visit, 66> stack;  // a binary tree of 2^64 leaves is at most 64 deep
  size_t height = 0;
  stack[height++] = {1, boundOf(1)};
  while (height > 0) {
    const Visit visit = stack[--height];
    if (visit.bound >= best) continue;
    if (visit.node >= leafCount_) {
      const size_t first = (visit.node - leafCount_) * kLeafSize;
      const size_t end = std::min(first + kLeafSize, points_.size() - 1);
      for (size_t i = first; i < end; ++i)
        if (const double range = extentOf(i); range < best) {
          best = range;
          hint = i;
        }
      continue;
    }
    const size_t left = 2 * visit.node;
    Visit near = {left, boundOf(left)}, far = {left + 1, boundOf(left + 1)};
    if (far.bound < near.bound) std::swap(near, far);
    stack[height++] = far;
    stack[height++] = near;
  }
  return best;
}

double maxDistance(std::span<const Vector> from, const PolylineTree& to, double tolerance) {
  size_t hint = 0;
  double largest = 0;
  const auto measure = [&](const Vector& p) {
    const double distance = std::sqrt(to.squaredRange(p, p, hint));
    largest = std::max(largest, distance);
    return distance;
  };
  struct Piece {
    Vector p, q;
    double atP, atQ;
  };
  // Branch and bound. The distance to one segment is convex along a straight piece, so that the
  // piece is nowhere farther than squaredRange() of its ends; and the distance changes by no more
  // than one walks. What can be farther than the largest distance so far is halved.
  std::vector<Piece> pieces;
  double before = measure(from[0]);
  for (size_t i = 0; i + 1 < from.size(); ++i) {
    const double after = measure(from[i + 1]);
    pieces.push_back({from[i], from[i + 1], before, after});
    before = after;
    while (!pieces.empty()) {
      const Piece piece = pieces.back();
      pieces.pop_back();
      const double walked = (piece.atP + piece.atQ + length(piece.q - piece.p)) / 2;
      if (walked <= largest + tolerance) continue;
      if (std::sqrt(to.squaredRange(piece.p, piece.q, hint)) <= largest + tolerance) continue;
      const Vector middle = lerp(piece.p, piece.q, 0.5);
      const double atMiddle = measure(middle);
      pieces.push_back({piece.p, middle, piece.atP, atMiddle});
      pieces.push_back({middle, piece.q, atMiddle, piece.atQ});
    }
  }
  return largest;
}

double hausdorffDistance(std::span<const Vector> a, std::span<const Vector> b) {
  Vector low = a[0], high = a[0];
  for (const std::span<const Vector> points : {a, b})
    for (const Vector& p : points) {
      low = {std::min(low.x, p.x), std::min(low.y, p.y), std::min(low.z, p.z)};
      high = {std::max(high.x, p.x), std::max(high.y, p.y), std::max(high.z, p.z)};
    }
  // Never below what coordinates far from the origin resolve, or halving would not end.
  const double magnitude = std::max({std::abs(low.x), std::abs(low.y), std::abs(low.z),
                                     std::abs(high.x), std::abs(high.y), std::abs(high.z)});
  const double tolerance =
      std::max({length(high - low) * kRelativeTolerance, magnitude * 0x1p-48, 0x1p-100});
  return std::max(maxDistance(a, PolylineTree(b), tolerance),
                  maxDistance(b, PolylineTree(a), tolerance));
}

}  // namespace pelage::detail
