// Root skinning and follow strands in double precision.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "reference/classic_reference.h"

namespace pelage::reference {

using Eigen::Matrix3d;
using Matrix34d = Eigen::Matrix<double, 3, 4>;

/// A bone of a blend.
struct WeightedBone {
  Matrix34d transform;  ///< [M | t], bind space to world
  double weight;
};

/// The rotation nearest to a matrix, by singular values; a mirrored matrix is mirrored back along x
/// before. \param matrix det != 0.
Quaterniond nearestRotation(const Matrix3d& matrix);

/// Blend of matrices; the rotation is that of the strongest bone where the blend lost three
/// quarters of the volume. Weights are > 0, at least one bone.
Pose skinByMatrices(const std::vector<WeightedBone>& bones, const Vector3d& bindRoot);

/// Blend of rigid bones by dual quaternions.
Pose skinByDualQuaternions(const std::vector<WeightedBone>& bones, const Vector3d& bindRoot);

/// A dual quaternion of a rigid map: real and dual part, x y z w each.
struct DualQuaternion {
  Eigen::Vector4d real, dual;
};
DualQuaternion dualQuaternion(const Matrix34d& rigid);

/// A follow strand beside its guide. \param root rotation of the guide's root.
std::vector<Vector3d> followHair(const std::vector<Vector3d>& guide, const Quaterniond& root,
                                 const Vector3d& offset, double tipSeparation);

}  // namespace pelage::reference
