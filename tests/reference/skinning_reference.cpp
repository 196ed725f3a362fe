#include "reference/skinning_reference.h"

#include <Eigen/Geometry>
#include <Eigen/SVD>
#include <algorithm>
#include <cmath>

namespace pelage::reference {
namespace {

const WeightedBone& strongest(const std::vector<WeightedBone>& bones) {
  return *std::max_element(bones.begin(), bones.end(),
                           [](const auto& a, const auto& b) { return a.weight < b.weight; });
}

}  // namespace

Quaterniond nearestRotation(const Matrix3d& matrix) {
  Matrix3d m = matrix;
  if (m.determinant() < 0) m.col(0) = -m.col(0);
  const Eigen::JacobiSVD<Matrix3d> svd(m, Eigen::ComputeFullU | Eigen::ComputeFullV);
  return Quaterniond(Matrix3d(svd.matrixU() * svd.matrixV().transpose()));
}

Pose skinByMatrices(const std::vector<WeightedBone>& bones, const Vector3d& bindRoot) {
  Matrix34d sum = Matrix34d::Zero();
  double weights = 0, volume = 0;
  for (const WeightedBone& bone : bones) {
    sum += bone.weight * bone.transform;
    weights += bone.weight;
    volume += bone.weight * std::abs(bone.transform.leftCols<3>().determinant());
  }
  sum /= weights;
  volume /= weights;
  Pose pose;
  pose.position = sum * bindRoot.homogeneous();
  const Matrix3d blended = sum.leftCols<3>();
  const bool lost = std::abs(blended.determinant()) < 0.25 * volume;
  pose.rotation =
      nearestRotation(lost ? Matrix3d(strongest(bones).transform.leftCols<3>()) : blended);
  return pose;
}

DualQuaternion dualQuaternion(const Matrix34d& rigid) {
  const Quaterniond real(Matrix3d(rigid.leftCols<3>()));
  const Vector3d t = rigid.col(3);
  const Quaterniond dual = Quaterniond(0, t.x(), t.y(), t.z()) * real;
  return {real.coeffs(), 0.5 * dual.coeffs()};
}

Pose skinByDualQuaternions(const std::vector<WeightedBone>& bones, const Vector3d& bindRoot) {
  const Eigen::Vector4d pivot = dualQuaternion(strongest(bones).transform).real;
  Eigen::Vector4d real = Eigen::Vector4d::Zero(), dual = Eigen::Vector4d::Zero();
  for (const WeightedBone& bone : bones) {
    const DualQuaternion q = dualQuaternion(bone.transform);
    const double weight = q.real.dot(pivot) < 0 ? -bone.weight : bone.weight;
    real += weight * q.real;
    dual += weight * q.dual;
  }
  // As a matrix: translation 2 d r* / |r|^2, rotation r / |r|.
  const Quaterniond r(real);
  const Quaterniond d(dual);
  Pose pose;
  pose.rotation = r.normalized();
  pose.position = pose.rotation * bindRoot + 2 * (d * r.conjugate()).vec() / real.squaredNorm();
  return pose;
}

std::vector<Vector3d> followHair(const std::vector<Vector3d>& guide, const Quaterniond& root,
                                 const Vector3d& offset, double tipSeparation) {
  std::vector<Vector3d> strand;
  const double last = static_cast<double>(guide.size()) - 1;
  for (size_t i = 0; i < guide.size(); ++i) {
    const double along = static_cast<double>(i) / last;
    strand.push_back(guide[i] + root * offset * ((1 - along) + along * tipSeparation));
  }
  return strand;
}

}  // namespace pelage::reference
