// Matrices of the library as those of Eigen.
#pragma once

#include <Eigen/Core>

#include "pelage/skeleton.h"
#include "pelage/types.h"

namespace pelage::test {

template <int count>
Eigen::Matrix<double, count, 4> rowsOf(const Float4 (&rows)[count]) {
  Eigen::Matrix<double, count, 4> result;
  for (int row = 0; row < count; ++row)
    result.row(row) << double{rows[row].x}, double{rows[row].y}, double{rows[row].z},
        double{rows[row].w};
  return result;
}

inline Eigen::Matrix4d toMatrix(const Matrix4& m) { return rowsOf(m.rows); }
inline Eigen::Matrix4d toMatrix(const AffineTransform& m) {
  Eigen::Matrix4d result = Eigen::Matrix4d::Identity();
  result.topRows<3>() = rowsOf(m.rows);
  return result;
}

}  // namespace pelage::test
