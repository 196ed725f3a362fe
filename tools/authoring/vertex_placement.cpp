#include "vertex_placement.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>

namespace pelage::detail {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
// Candidates for a vertex, per even segment; and the shortest and longest segment in them.
constexpr size_t kSteps = 12, kShortest = 4, kLongest = 24;
constexpr size_t kLengths = kLongest - kShortest + 1;

// Chooses vertices among candidates by dynamic programming.
class Fitting {
 public:
  Fitting(const Curve& curve, uint32_t count)
      : curve_(curve), segments_(count - 1), last_(segments_ * kSteps) {
    distributeCandidates();
    measureChords();
  }

  std::vector<double> run() {
    // The smallest possible largest deviation; then the most even choice that has it.
    const double least = choose([&](size_t, size_t, double deviation) { return deviation; },
                                [](double a, double b) { return std::max(a, b); });
    const double allowed = least * (1 + 1e-9);
    choose(
        [&](size_t, size_t steps, double deviation) {
          const double uneven = static_cast<double>(steps) - static_cast<double>(kSteps);
          return deviation <= allowed ? uneven * uneven : kInfinity;
        },
        [](double a, double b) { return a + b; });
    std::vector<double> chosen(segments_ + 1);
    size_t at = last_;
    for (size_t segment = segments_; segment > 0; --segment) {
      chosen[segment] = candidates_[at];
      at -= steps_[segment * (last_ + 1) + at];
    }
    return chosen;
  }

 private:
  // Even ones; the nearest one to each point of the curve, where the curve has its corner, is moved
  // there.
  void distributeCandidates() {
    const double step = curve_.length() / static_cast<double>(last_);
    for (size_t i = 0; i <= last_; ++i) candidates_.push_back(step * static_cast<double>(i));
    candidates_.back() = curve_.length();
    size_t moved = 0;
    for (size_t i = 1; i + 1 < curve_.arc.size(); ++i) {
      const auto nearest = static_cast<size_t>(std::llround(curve_.arc[i] / step));
      if (nearest <= moved || nearest >= last_) continue;
      candidates_[nearest] = curve_.arc[i];
      moved = nearest;
    }
  }

  // How far the curve between two candidates is from the chord that joins them: at most as far as
  // its farthest vertex.
  void measureChords() {
    std::vector<Vector> at;
    std::vector<size_t> next;  // first point of the curve beyond the candidate
    for (const double length : candidates_) {
      at.push_back(pointAt(curve_.points, positionAt(curve_.arc, length)));
      next.push_back(static_cast<size_t>(
          std::upper_bound(curve_.arc.begin(), curve_.arc.end(), length) - curve_.arc.begin()));
    }
    chords_.assign((last_ + 1) * kLengths, kInfinity);
    for (size_t end = kShortest; end <= last_; ++end)
      for (size_t steps = kShortest; steps <= std::min(kLongest, end); ++steps) {
        const size_t begin = end - steps;
        // Vertex 1 moves with the bones: it must not take more of the hair than it would evenly.
        if (begin == 0 && steps > kSteps) continue;
        double squared = 0;
        for (size_t i = next[begin]; i < curve_.arc.size() && curve_.arc[i] < candidates_[end]; ++i)
          squared = std::max(squared, squaredDistance(curve_.points[i], at[begin], at[end]));
        chords_[end * kLengths + steps - kShortest] = std::sqrt(squared);
      }
  }

  // Least cost of ending at the last candidate after all segments; fills steps_.
  template <class Cost, class Join>
  double choose(const Cost& cost, const Join& join) {
    std::vector<double> reached(last_ + 1, kInfinity), before;
    reached[0] = 0;
    steps_.assign((segments_ + 1) * (last_ + 1), 0);
    for (size_t segment = 1; segment <= segments_; ++segment) {
      before.swap(reached);
      reached.assign(last_ + 1, kInfinity);
      // Sites that are reachable from the root, and from which the tip is reachable.
      const size_t left = segments_ - segment;
      const size_t first = std::max(segment * kShortest, last_ - std::min(last_, left * kLongest));
      const size_t end = std::min(segment * kLongest, last_ - left * kShortest);
      for (size_t i = first; i <= end; ++i)
        for (size_t steps = kShortest; steps <= std::min(kLongest, i); ++steps) {
          if (before[i - steps] == kInfinity) continue;
          const double total =
              join(before[i - steps], cost(i, steps, chords_[i * kLengths + steps - kShortest]));
          if (total >= reached[i]) continue;
          reached[i] = total;
          steps_[segment * (last_ + 1) + i] = static_cast<uint8_t>(steps);
        }
    }
    return reached[last_];
  }

  const Curve& curve_;
  size_t segments_, last_;  // last_: index of the last candidate
  std::vector<double> candidates_;
  std::vector<double> chords_;  // [end][steps - kShortest]
  std::vector<uint8_t> steps_;  // [segment][end] of the best choice so far
};

}  // namespace

std::vector<double> pointVertices(const Curve& curve, uint32_t count, VertexPlacement placement) {
  if (placement == VertexPlacement::kFitted && count > 2) return Fitting(curve, count).run();
  std::vector<double> chosen(count);
  for (uint32_t i = 0; i < count; ++i) chosen[i] = curve.length() * i / (count - 1);
  chosen.back() = curve.length();
  return chosen;
}

}  // namespace pelage::detail
