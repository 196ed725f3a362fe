#include "static_rod.h"

#include <Eigen/LU>

namespace pelage::rod {
namespace {

struct State {
  Vector3d position, moment;
  Quaterniond frame;
};

State advanced(const State& a, const State& rate, double h) {
  return {a.position + rate.position * h,
          a.moment + rate.moment * h,
          {a.frame.x + rate.frame.x * h, a.frame.y + rate.frame.y * h, a.frame.z + rate.frame.z * h,
           a.frame.w + rate.frame.w * h}};
}

}  // namespace

// Balance of force and moment of the rod (Antman, Nonlinear Problems of Elasticity, chapter VIII):
// n' = -f, m' = -r' x n; with the end free, n(s) = f (length - s).
StaticRod::Shot StaticRod::shoot(const Vector3d& clampMoment, double load) const {
  const auto rateOf = [&](double s, const State& state) {
    const Quaterniond q = normalized(state.frame);
    const Vector3d tangent = axisX(q);
    const Vector3d local = rotate(conjugate(q), state.moment);
    const double factor = stiffness ? stiffness(s) : 1;
    const Vector3d strain(local.x / twist, local.y / bend, local.z / bend);
    const Vector3d darboux = curls(s) + strain * (1 / factor);
    const Quaterniond rotation = q * Quaterniond(darboux * 0.5, 0);
    return State{tangent, -cross(tangent, gravity * (load * (length - s))), rotation};
  };
  const double h = length / steps;
  Shot shot;
  State state{origin, clampMoment, clamp};
  shot.points.push_back(state.position);
  for (int i = 0; i < steps; ++i) {
    const double s = i * h;
    const State k1 = rateOf(s, state);
    const State k2 = rateOf(s + h / 2, advanced(state, k1, h / 2));
    const State k3 = rateOf(s + h / 2, advanced(state, k2, h / 2));
    const State k4 = rateOf(s + h, advanced(state, k3, h));
    state = advanced(advanced(state, k1, h / 6), k2, h / 3);
    state = advanced(advanced(state, k3, h / 3), k4, h / 6);
    state.frame = normalized(state.frame);
    shot.points.push_back(state.position);
  }
  shot.endMoment = state.moment;
  return shot;
}

std::optional<std::vector<Vector3d>> StaticRod::solve(int loadSteps) const {
  const double scale = rod::length(gravity) * length * length;
  Vector3d moment;
  for (int step = 1; step <= loadSteps; ++step) {
    const double load = static_cast<double>(step) / loadSteps;
    for (int iteration = 0; iteration < 50; ++iteration) {
      const Vector3d end = shoot(moment, load).endMoment;
      if (rod::length(end) < 1e-12 * scale) break;
      const double delta = 1e-6 * scale;
      Eigen::Matrix3d jacobian;
      for (int k = 0; k < 3; ++k) {
        const Vector3d nudge(k == 0 ? delta : 0, k == 1 ? delta : 0, k == 2 ? delta : 0);
        const Vector3d change = (shoot(moment + nudge, load).endMoment - end) * (1 / delta);
        jacobian.col(k) = Eigen::Vector3d(change.x, change.y, change.z);
      }
      Eigen::Vector3d newton = jacobian.fullPivLu().solve(Eigen::Vector3d(end.x, end.y, end.z));
      const double limit = 0.3 * scale;
      if (newton.norm() > limit) newton *= limit / newton.norm();
      moment -= Vector3d(newton(0), newton(1), newton(2));
    }
  }
  Shot shot = shoot(moment, 1);
  if (!(rod::length(shot.endMoment) < 1e-8 * scale)) return std::nullopt;
  return std::move(shot.points);
}

Vector3d pointAt(const std::vector<Vector3d>& curve, double share) {
  const double slot = share * static_cast<double>(curve.size() - 1);
  const size_t i = std::min(static_cast<size_t>(slot), curve.size() - 2);
  const double rest = slot - static_cast<double>(i);
  return curve[i] * (1 - rest) + curve[i + 1] * rest;
}

}  // namespace pelage::rod
