#include "pelage/camera.h"

#include <Eigen/Dense>
#include <cmath>

namespace pelage {

Matrix4 lookAt(Float3 eye, Float3 target, Float3 up, float verticalFov, float aspect, float near,
               float far, bool reversedDepth) {
  using Vector = Eigen::Vector3d;
  const Vector from(eye.x, eye.y, eye.z);
  const Vector forward = (Vector(target.x, target.y, target.z) - from).normalized();
  const Vector right = forward.cross(Vector(up.x, up.y, up.z)).normalized();
  const Vector above = right.cross(forward);

  Eigen::Matrix4d view = Eigen::Matrix4d::Identity();
  view.row(0) << right.transpose(), -right.dot(from);
  view.row(1) << above.transpose(), -above.dot(from);
  view.row(2) << -forward.transpose(), forward.dot(from);  // looks along -z

  const double scale = 1.0 / std::tan(0.5 * static_cast<double>(verticalFov));
  const double n = near;
  const double f = far;
  Eigen::Matrix4d projection = Eigen::Matrix4d::Zero();
  projection(0, 0) = scale / static_cast<double>(aspect);
  projection(1, 1) = scale;
  if (reversedDepth) {
    projection(2, 3) = n;  // depth n / distance: 1 at the near plane, 0 at infinity
  } else {
    projection(2, 2) = f / (n - f);
    projection(2, 3) = n * f / (n - f);
  }
  projection(3, 2) = -1;

  const Eigen::Matrix4f all = (projection * view).cast<float>();
  Matrix4 result;
  for (int row = 0; row < 4; ++row) {
    result.rows[row] = {all(row, 0), all(row, 1), all(row, 2), all(row, 3)};
  }
  return result;
}

}  // namespace pelage
