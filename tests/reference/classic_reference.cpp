#include "reference/classic_reference.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

namespace pelage::reference {
namespace {

constexpr int kSpanRounds = 16;

double smoothRamp(double excess) {
  const double x = std::clamp(excess, 0.0, 1.0);
  return x * x * (3 - 2 * x);
}

// The shortest rotation from one direction to another; not Eigen's, whose singular value
// decomposition takes a minute to compile.
Quaterniond rotationBetween(const Vector3d& from, const Vector3d& to) {
  const Vector3d a = from.normalized(), b = to.normalized();
  const double cosine = a.dot(b);
  if (cosine < -1 + 1e-14) {
    Vector3d axis = a.cross(std::abs(a.x()) < 0.9 ? Vector3d::UnitX() : Vector3d::UnitY());
    axis.normalize();
    return {0, axis.x(), axis.y(), axis.z()};
  }
  const Vector3d axis = a.cross(b);
  return Quaterniond(1 + cosine, axis.x(), axis.y(), axis.z()).normalized();
}

}  // namespace

Pose interpolate(const Pose& from, const Pose& to, double share) {
  Pose pose;
  const double side = from.rotation.dot(to.rotation) < 0 ? -1 : 1;
  pose.rotation =
      Quaterniond((1 - share) * from.rotation.coeffs() + share * side * to.rotation.coeffs());
  pose.rotation.normalize();
  pose.position = (1 - share) * from.position + share * to.position;
  return pose;
}

std::vector<Vector3d> restVectors(const std::vector<Vector3d>& bind) {
  std::vector<Vector3d> rest;
  Quaterniond frame = Quaterniond::Identity();
  for (size_t i = 0; i + 1 < bind.size(); ++i) {
    const Vector3d edge = bind[i + 1] - bind[i];
    rest.push_back(frame.conjugate() * edge);
    if (i > 0) frame = rotationBetween(bind[i] - bind[i - 1], edge) * frame;
  }
  return rest;
}

ClassicReference::ClassicReference(std::vector<Vector3d> bind, std::vector<int> held)
    : bind_(std::move(bind)), held_(bind_.size(), false), restVectors_(restVectors(bind_)) {
  held_[0] = held_[1] = true;
  for (int vertex : held) held_[vertex] = true;
  for (size_t i = 0; i + 1 < bind_.size(); ++i)
    lengths_.push_back((bind_[i + 1] - bind_[i]).norm());
  reset({Quaterniond::Identity(), bind_[0]});
}

Vector3d ClassicReference::target(const Pose& pose, int vertex) const {
  return pose.position + pose.rotation * (bind_[vertex] - bind_[0]);
}

void ClassicReference::reset(const Pose& pose) {
  current.clear();
  for (int i = 0; i < count(); ++i) current.push_back(target(pose, i));
  previous = current;
}

void ClassicReference::step(const ClassicStep& s, const Pose& begin, const Pose& end) {
  const double h = s.timeStep;
  const double before = h / s.timeStepRatio;
  const double force = std::max(h, kReferenceStep);

  // The root's motion that the strand takes part in.
  const Vector3d velocity = (end.position - current[0]) / h;
  const Vector3d velocityBefore = (current[0] - previous[0]) / before;
  const double acceleration = (velocity - velocityBefore).norm() * 2 / (h + before);
  const double share =
      s.vspCoefficient + (1 - s.vspCoefficient) * smoothRamp(acceleration / s.vspThreshold - 1);
  const Pose relativeRotation =
      interpolate({}, {end.rotation * begin.rotation.conjugate(), Vector3d::Zero()}, share);
  const Vector3d pivot = begin.position + share * (end.position - begin.position);
  const auto transport = [&](const Vector3d& p) -> Vector3d {
    return relativeRotation.rotation * (p - begin.position) + pivot;
  };

  std::vector<Vector3d> transported, moved(current.size()), inertia(current.size());
  for (const Vector3d& p : current) transported.push_back(transport(p));
  for (int i = 0; i < count(); ++i) {
    if (isHeld(i)) {
      moved[i] = target(end, i);
      previous[i] = i > 0 ? transported[i] : current[i];
      continue;
    }
    inertia[i] = (transported[i] - transport(previous[i])) * (force / before);
    Vector3d u = inertia[i] * s.dampingKeep + s.gravity * s.gravityStep;
    // Implicit drag: (1 + c h) u_perp = u_perp + c h (h wind)_perp, u along the fiber as it was.
    const Vector3d tangent =
        (transported[std::min(i + 1, count() - 1)] - transported[i - 1]).normalized();
    const Eigen::Matrix3d across = Eigen::Matrix3d::Identity() - tangent * tangent.transpose();
    const double ch = s.airDrag * force;
    u = (Eigen::Matrix3d::Identity() + ch * across).inverse() *
        (u + ch * force * (across * s.wind));
    if (u.norm() > s.maxSpeed * force) u *= s.maxSpeed * force / u.norm();
    moved[i] = transported[i] + u;
    if (i < s.globalRange * count()) moved[i] += s.globalStiffness * (target(end, i) - moved[i]);
    previous[i] = transported[i];
  }
  current = moved;

  for (int round = 0; round < s.localIterations; ++round) sweepLocalShape(s.localStiffness, end);
  // Forces change the displacement in a step of `force`; this step takes its share of that.
  for (int i = 0; i < count(); ++i)
    if (!isHeld(i))
      current[i] = transported[i] + inertia[i] * (h / force) +
                   s.forceShare * (current[i] - transported[i] - inertia[i]);
  if (s.lengthIterations > 0) {
    transported[0] = previous[0];
    solveTensions(transported);
  }
  for (int round = 1; round < s.lengthIterations; ++round) newtonStep();
  followLeaders();
}

void ClassicReference::sweepLocalShape(double share, const Pose& end) {
  Quaterniond frame = end.rotation;
  Vector3d direction = end.rotation * (bind_[1] - bind_[0]).normalized();
  for (int i = 1; i + 1 < count(); ++i) {
    const Vector3d correction =
        0.5 * share * (current[i] + frame * restVectors_[i] - current[i + 1]);
    if (!isHeld(i)) current[i] -= correction;
    if (!isHeld(i + 1)) current[i + 1] += correction;
    const Vector3d rotated = (current[i + 1] - current[i]).normalized();
    frame = rotationBetween(direction, rotated) * frame;
    frame.normalize();
    direction = rotated;
  }
}

void ClassicReference::solveTensions(const std::vector<Vector3d>& begin) {
  const int n = count() - 2;
  if (n <= 0) return;
  // Dense. Along the segments as they were: J W J^T lambda = J (current - begin) + stretch.
  Eigen::MatrixXd jacobian = Eigen::MatrixXd::Zero(n, 3 * count());
  Eigen::VectorXd mobility(3 * count()), displacement(3 * count()), stretch(n);
  for (int i = 0; i < count(); ++i) {
    mobility.segment<3>(3 * i).setConstant(isHeld(i) ? 0 : 1);
    displacement.segment<3>(3 * i) = current[i] - begin[i];
  }
  for (int j = 0; j < n; ++j) {
    const Vector3d edge = begin[j + 2] - begin[j + 1];
    stretch[j] = edge.norm() - lengths_[j + 1];
    jacobian.block<1, 3>(j, 3 * (j + 1)) = -edge.normalized().transpose();
    jacobian.block<1, 3>(j, 3 * (j + 2)) = edge.normalized().transpose();
  }
  const Eigen::MatrixXd system = jacobian * mobility.asDiagonal() * jacobian.transpose();
  const Eigen::VectorXd lambda =
      system.completeOrthogonalDecomposition().solve(jacobian * displacement + stretch);
  // Along the segments as they become, where they are under tension: (1 + W L) u = way - W pull.
  Eigen::MatrixXd stiffness = Eigen::MatrixXd::Identity(count(), count());
  Eigen::MatrixX3d side(count(), 3);
  for (int i = 0; i < count(); ++i) side.row(i) = (current[i] - begin[i]).transpose();
  for (int j = 0; j < n; ++j) {
    const Vector3d edge = begin[j + 2] - begin[j + 1];
    const double density = lambda[j] / edge.norm();
    for (const int sign : {1, -1}) {
      const int here = sign > 0 ? j + 1 : j + 2, there = 2 * j + 3 - here;
      if (isHeld(here)) continue;
      stiffness(here, here) += std::max(density, 0.0);
      stiffness(here, there) -= std::max(density, 0.0);
      side.row(here) += sign * density * edge.transpose();
    }
  }
  const Eigen::MatrixX3d u = stiffness.partialPivLu().solve(side);
  for (int i = 0; i < count(); ++i)
    if (!isHeld(i)) current[i] = begin[i] + u.row(i).transpose();
}

void ClassicReference::newtonStep() {
  // Dense: J is n constraints by 3 count() coordinates, with W the inverse masses.
  const int n = count() - 2;
  if (n <= 0) return;
  Eigen::MatrixXd jacobian = Eigen::MatrixXd::Zero(n, 3 * count());
  Eigen::VectorXd error(n);
  Eigen::VectorXd mobility(3 * count());
  for (int i = 0; i < count(); ++i) mobility.segment<3>(3 * i).setConstant(isHeld(i) ? 0 : 1);
  for (int j = 0; j < n; ++j) {
    const Vector3d edge = current[j + 2] - current[j + 1];
    error[j] = edge.norm() - lengths_[j + 1];
    jacobian.block<1, 3>(j, 3 * (j + 1)) = -edge.normalized().transpose();
    jacobian.block<1, 3>(j, 3 * (j + 2)) = edge.normalized().transpose();
  }
  const Eigen::MatrixXd system = jacobian * mobility.asDiagonal() * jacobian.transpose();
  const Eigen::VectorXd lambda = system.completeOrthogonalDecomposition().solve(-error);
  const Eigen::VectorXd motion = mobility.asDiagonal() * (jacobian.transpose() * lambda);
  for (int i = 0; i < count(); ++i) current[i] += motion.segment<3>(3 * i);
}

void ClassicReference::followLeaders() {
  int held = 1;
  double range = 0;
  for (int i = 2; i < count(); ++i) {
    range += lengths_[i - 1];
    if (!isHeld(i)) continue;
    const Vector3d whole = current[i] - current[held];
    if (whole.norm() >= 0.999999 * range) {
      double done = 0;
      for (int k = held + 1; k < i; ++k) {
        done += lengths_[k - 1];
        current[k] = current[held] + whole * (done / range);
      }
    } else {
      for (int round = 0; round < kSpanRounds; ++round) {
        for (int k = i - 1; k > held; --k)
          current[k] = current[k + 1] + lengths_[k] * (current[k] - current[k + 1]).normalized();
        for (int k = held + 1; k < i; ++k)
          current[k] =
              current[k - 1] + lengths_[k - 1] * (current[k] - current[k - 1]).normalized();
      }
      const Vector3d arm = current[i] - current[i - 1];
      const Vector3d lack = arm - lengths_[i - 1] * arm.normalized();
      double along = 0;
      for (int k = held + 1; k < i; ++k) {
        along += lengths_[k - 1];
        current[k] += lack * (along / range);
      }
    }
    held = i;
    range = 0;
  }
  for (int i = held + 1; i < count(); ++i)
    current[i] = current[i - 1] + lengths_[i - 1] * (current[i] - current[i - 1]).normalized();
}

std::vector<Vector3d> ClassicReference::tangents() const {
  std::vector<Vector3d> result;
  for (int i = 0; i < count(); ++i)
    result.push_back(
        (current[std::min(i + 1, count() - 1)] - current[std::max(i - 1, 0)]).normalized());
  return result;
}

}  // namespace pelage::reference
