#include "planar_chain.h"

#include <Eigen/Cholesky>
#include <numbers>

namespace pelage::rod {

PlanarChain::PlanarChain(const RestStrand& rest, double bend, double drag, double gravity)
    : edges_(rest.size() - 1),
      root_(rest.positions[0]),
      lengths_(rest.lengths),
      voronoiLengths_(rest.voronoiLengths),
      bend_(bend),
      drag_(drag),
      gravity_(gravity) {
  outerMass_.assign(edges_ + 1, 0);
  for (int j = edges_ - 1; j >= 0; --j) outerMass_[j] = outerMass_[j + 1] + voronoiLengths_[j + 1];
  for (int j = 0; j < edges_; ++j) {
    const Vector3d edge = rest.positions[j + 1] - rest.positions[j];
    restAngles_.push_back(std::atan2(edge.y, edge.x));
  }
  angles_ = restAngles_;
  rates_.assign(edges_, 0);
}

double PlanarChain::bendAngle(const std::vector<double>& angles, int vertex) const {
  const double angle =
      (angles[vertex] - angles[vertex - 1]) - (restAngles_[vertex] - restAngles_[vertex - 1]);
  return std::remainder(angle, 2 * std::numbers::pi);
}

// Lagrange's equations in absolute angles. The kinetic energy is
//   1/2 sum_jk l_j l_k m_jk cos(a_j - a_k) w_j w_k, m_jk the mass beyond the outer of j and k.
std::vector<double> PlanarChain::accelerations(const std::vector<double>& angles,
                                               const std::vector<double>& rates) const {
  const int free = edges_ - 1;
  Eigen::MatrixXd mass(free, free);
  Eigen::VectorXd force(free);
  // Derivative of 8 kb tan^2(angle / 4), the energy of a vertex.
  const auto moment = [&](int vertex) {
    const double s = std::tan(bendAngle(angles, vertex) / 4);
    return bend_ / voronoiLengths_[vertex] * 4 * s * (1 + s * s);
  };
  for (int j = 1; j <= free; ++j) {
    double sum = -outerMass_[j] * lengths_[j] * gravity_ * std::cos(angles[j]);
    for (int k = 1; k <= free; ++k) {
      const double m = lengths_[j] * lengths_[k] * outerMass_[std::max(j, k)];
      const double angle = angles[j] - angles[k];
      mass(j - 1, k - 1) = m * std::cos(angle);
      sum -= m * std::sin(angle) * rates[k] * rates[k] + drag_ * m * std::cos(angle) * rates[k];
    }
    if (bend_ > 0) {
      sum -= moment(j);
      if (j < free) sum += moment(j + 1);
    }
    force(j - 1) = sum;
  }
  const Eigen::VectorXd solved = mass.llt().solve(force);
  std::vector<double> result(edges_, 0);
  for (int j = 1; j <= free; ++j) result[j] = solved(j - 1);
  return result;
}

void PlanarChain::step(double h) {
  const auto advanced = [&](const std::vector<double>& from, const std::vector<double>& rate,
                            double time) {
    std::vector<double> to = from;
    for (int j = 1; j < edges_; ++j) to[j] += rate[j] * time;
    return to;
  };
  const std::vector<double> v1 = rates_, a1 = accelerations(angles_, v1);
  const std::vector<double> v2 = advanced(rates_, a1, h / 2),
                            a2 = accelerations(advanced(angles_, v1, h / 2), v2);
  const std::vector<double> v3 = advanced(rates_, a2, h / 2),
                            a3 = accelerations(advanced(angles_, v2, h / 2), v3);
  const std::vector<double> v4 = advanced(rates_, a3, h),
                            a4 = accelerations(advanced(angles_, v3, h), v4);
  for (int j = 1; j < edges_; ++j) {
    angles_[j] += h / 6 * (v1[j] + 2 * v2[j] + 2 * v3[j] + v4[j]);
    rates_[j] += h / 6 * (a1[j] + 2 * a2[j] + 2 * a3[j] + a4[j]);
  }
}

std::vector<Vector3d> PlanarChain::positions() const {
  std::vector<Vector3d> points{root_};
  for (int j = 0; j < edges_; ++j) {
    const Vector3d direction(std::cos(angles_[j]), std::sin(angles_[j]), 0);
    points.push_back(points.back() + direction * lengths_[j]);
  }
  return points;
}

double PlanarChain::energy() const {
  const std::vector<Vector3d> points = positions();
  Vector3d velocity;
  double sum = 0;
  for (int j = 1; j < edges_; ++j) {
    velocity +=
        Vector3d(-std::sin(angles_[j]), std::cos(angles_[j]), 0) * (lengths_[j] * rates_[j]);
    sum += voronoiLengths_[j + 1] * (0.5 * dot(velocity, velocity) + gravity_ * points[j + 1].y);
    const double s = std::tan(bendAngle(angles_, j) / 4);
    sum += 8 * bend_ / voronoiLengths_[j] * s * s;
  }
  return sum;
}

}  // namespace pelage::rod
