// Matrices in doubles, for Eigen.
#pragma once

#include <Eigen/Core>

#include "pelage/types.h"

namespace pelage::detail {

inline Eigen::Matrix4d toMatrix(const Matrix4& m) {
  Eigen::Matrix4d result;
  for (int row = 0; row < 4; ++row) {
    const Float4& r = m.rows[row];
    result.row(row) << double{r.x}, double{r.y}, double{r.z}, double{r.w};
  }
  return result;
}

}  // namespace pelage::detail
