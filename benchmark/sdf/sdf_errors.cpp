#include "sdf/sdf_errors.h"

#include <algorithm>
#include <cmath>

namespace bench {

using pelage::reference::DistanceOracle;
using pelage::reference::Vector3d;

namespace {

constexpr float kSignTolerance = 1e-4f;  // cell

class ErrorSum {
 public:
  void add(double error) {
    largest_ = std::max(largest_, error);
    squares_ += error * error;
    ++count_;
  }
  double largest() const { return largest_; }
  double rms() const { return count_ > 0 ? std::sqrt(squares_ / static_cast<double>(count_)) : 0; }

 private:
  double largest_ = 0, squares_ = 0;
  uint64_t count_ = 0;
};

}  // namespace

std::vector<float> trueDistances(const DistanceOracle& oracle, const NodeGrid& grid, double range) {
  const double cell = static_cast<double>(grid.cellSize);
  const Vector3d origin(grid.origin.x, grid.origin.y, grid.origin.z);
  const std::vector<double> near = oracle.gridDistances(origin, cell, grid.nodes, range * cell);
  std::vector<float> distances(near.size());
  size_t i = 0;
  for (uint32_t z = 0; z < grid.nodes[2]; ++z)
    for (uint32_t y = 0; y < grid.nodes[1]; ++y)
      for (uint32_t x = 0; x < grid.nodes[0]; ++x, ++i) {
        double distance = near[i];
        if (distance <= -range * cell)
          distance = -oracle.closest(origin + cell * Vector3d(x, y, z)).distance;
        distances[i] = static_cast<float>(distance / cell);
      }
  return distances;
}

SdfErrors compareSdf(std::span<const NodeValue> values, std::span<const float> truth) {
  SdfErrors errors;
  ErrorSum near, far;
  uint64_t inside = 0, unset = 0;
  for (size_t i = 0; i < values.size(); ++i) {
    const NodeValue& value = values[i];
    const bool hasDistance = value.state == NodeState::kNear || value.state == NodeState::kFar;
    if (truth[i] < -kSignTolerance) {
      ++inside;
      if (!hasDistance) ++unset;
    }
    if (value.state == NodeState::kUnwritten) continue;
    if (std::abs(truth[i]) >= kSignTolerance &&
        std::signbit(truth[i]) != std::signbit(value.distance))
      ++errors.wrongSigns;
    if (!hasDistance) continue;
    const float error = std::abs(std::abs(value.distance) - std::abs(truth[i]));
    (value.state == NodeState::kNear ? near : far).add(static_cast<double>(error));
  }
  errors.nearMax = near.largest();
  errors.nearRms = near.rms();
  errors.farMax = far.largest();
  errors.farRms = far.rms();
  if (inside > 0) errors.unsetInterior = static_cast<double>(unset) / static_cast<double>(inside);
  return errors;
}

}  // namespace bench
