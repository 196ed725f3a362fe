// Bones for the kernels that skin.
#pragma once

#include <Eigen/Geometry>
#include <vector>

#include "reference/skinning_reference.h"
#include "support/strand_run.h"

namespace pelage::test {

inline reference::Matrix34d rigidMatrix(const Eigen::Quaterniond& rotation,
                                        const Vector3d& translation) {
  reference::Matrix34d m;
  m << rotation.toRotationMatrix(), translation;
  return m;
}

/// The values that the device gets, so that reference and kernel see the same input.
inline reference::Matrix34d rounded(const reference::Matrix34d& m) {
  return m.cast<float>().cast<double>();
}
inline Vector3d rounded(const Vector3d& v) { return v.cast<float>().cast<double>(); }

/// Rows of matrices, or dual quaternions with either sign: both are the same motion.
inline std::vector<Float4> toBones(const std::vector<reference::Matrix34d>& bones,
                                   bool dual = false) {
  std::vector<Float4> rows;
  for (size_t i = 0; i < bones.size(); ++i) {
    if (dual) {
      const auto q = reference::dualQuaternion(bones[i]);
      const double side = i % 2 == 1 ? -1 : 1;
      rows.push_back(toFloat4(side * q.real.head<3>(), side * q.real.w()));
      rows.push_back(toFloat4(side * q.dual.head<3>(), side * q.dual.w()));
    } else {
      for (int row = 0; row < 3; ++row)
        rows.push_back(toFloat4(bones[i].row(row).head<3>().transpose(), bones[i](row, 3)));
    }
  }
  return rows;
}

}  // namespace pelage::test
