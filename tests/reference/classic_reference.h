// The classic strand step in double precision, one strand at a time, written from its formulas
// (head of kernels/simulation/classic/simulate_classic.hlsl): what the kernel is compared with.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <limits>
#include <vector>

namespace pelage::reference {

using Eigen::Quaterniond;
using Eigen::Vector3d;

/// Rigid frame of a root: p -> rotation (p - bindRoot) + position.
struct Pose {
  Quaterniond rotation = Quaterniond::Identity();
  Vector3d position = Vector3d::Zero();
};

/// nlerp on the shorter arc, and lerp.
Pose interpolate(const Pose& from, const Pose& to, double share);

/// The shortest step that forces are found for, as the kernel has it [s].
inline constexpr double kReferenceStep = 1.0f / 60;

/// Constants of one sub-step, as in SimulationConstants; what a permutation leaves out is 0 here.
struct ClassicStep {
  double timeStep = 1.0 / 60;
  double timeStepRatio = 1;
  double dampingKeep = 1;
  double gravityStep = 1.0 / 3600;
  double forceShare = 1;
  Vector3d gravity = Vector3d::Zero();
  Vector3d wind = Vector3d::Zero();
  double airDrag = 0;
  double localStiffness = 0;
  double globalStiffness = 0;
  double globalRange = 0;
  double vspCoefficient = 0;
  double vspThreshold = std::numeric_limits<double>::infinity();
  double maxSpeed = 1e9;
  int localIterations = 0;
  int lengthIterations = 0;
};

class ClassicReference {
 public:
  /// \param bind bind positions [m], at least 2; neighbours may not coincide.
  /// \param held indices beyond 1 that follow the root too.
  explicit ClassicReference(std::vector<Vector3d> bind, std::vector<int> held = {});

  void reset(const Pose& pose);
  void step(const ClassicStep& step, const Pose& begin, const Pose& end);

  int count() const { return static_cast<int>(bind_.size()); }
  Vector3d target(const Pose& pose, int vertex) const;
  std::vector<Vector3d> tangents() const;
  double restLength(int segment) const { return lengths_[segment]; }

  std::vector<Vector3d> current;
  std::vector<Vector3d> previous;

 private:
  bool isHeld(int vertex) const { return held_[vertex]; }
  void sweepLocalShape(double share, const Pose& end);
  void solveTensions(const std::vector<Vector3d>& begin);
  void newtonStep();
  void followLeaders();

  std::vector<Vector3d> bind_;
  std::vector<bool> held_;
  std::vector<double> lengths_;
  std::vector<Vector3d> restVectors_;
};

/// Bind frame of the first segment is the identity here; rest vectors are seen from the frame of
/// the segment before, carried without twist.
std::vector<Vector3d> restVectors(const std::vector<Vector3d>& bind);

}  // namespace pelage::reference
