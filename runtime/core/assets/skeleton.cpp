#include "pelage/skeleton.h"

#include <Eigen/Dense>
#include <cmath>

#include "pelage/assert.h"

namespace pelage {
namespace {

Eigen::Matrix3d linearPart(const AffineTransform& transform) {
  Eigen::Matrix3d m;
  for (int row = 0; row < 3; ++row) {
    const Float4& r = transform.rows[row];
    m.row(row) << r.x, r.y, r.z;
  }
  return m;
}

Eigen::Vector3d translationPart(const AffineTransform& transform) {
  return {transform.rows[0].w, transform.rows[1].w, transform.rows[2].w};
}

AffineTransform fromParts(const Eigen::Matrix3d& m, const Eigen::Vector3d& t) {
  AffineTransform result;
  for (int row = 0; row < 3; ++row)
    result.rows[row] = {static_cast<float>(m(row, 0)), static_cast<float>(m(row, 1)),
                        static_cast<float>(m(row, 2)), static_cast<float>(t(row))};
  return result;
}

Float4 toFloat4(const Eigen::Quaterniond& q) {
  return {static_cast<float>(q.x()), static_cast<float>(q.y()), static_cast<float>(q.z()),
          static_cast<float>(q.w())};
}

}  // namespace

std::optional<uint32_t> Skeleton::find(std::string_view name) const {
  for (size_t i = 0; i < bones.size(); ++i)
    if (bones[i].name == name) return static_cast<uint32_t>(i);
  return std::nullopt;
}

AffineTransform multiply(const AffineTransform& outer, const AffineTransform& inner) {
  const Eigen::Matrix3d m = linearPart(outer);
  return fromParts(m * linearPart(inner), m * translationPart(inner) + translationPart(outer));
}

std::optional<AffineTransform> inverse(const AffineTransform& transform) {
  const Eigen::Matrix3d m = linearPart(transform);
  const Eigen::Vector3d t = translationPart(transform);
  if (!m.allFinite() || !t.allFinite()) return std::nullopt;
  const Eigen::FullPivLU<Eigen::Matrix3d> lu(m);
  if (!lu.isInvertible()) return std::nullopt;
  const Eigen::Matrix3d inverted = lu.inverse();
  return fromParts(inverted, -(inverted * t));
}

AffineTransform rigidTransform(const Quaternion& rotation, const Float3& translation) {
  Eigen::Quaterniond q(rotation.w, rotation.x, rotation.y, rotation.z);
  const double norm = q.norm();
  if (norm > 0 && std::isfinite(norm)) {
    q.coeffs() /= norm;
  } else {
    q.setIdentity();
  }
  return fromParts(q.toRotationMatrix(), {translation.x, translation.y, translation.z});
}

Float3 transformPoint(const AffineTransform& transform, const Float3& point) {
  const auto row = [&](const Float4& r) {
    return r.x * point.x + r.y * point.y + r.z * point.z + r.w;
  };
  return {row(transform.rows[0]), row(transform.rows[1]), row(transform.rows[2])};
}

DualQuaternion toDualQuaternion(const AffineTransform& transform) {
  const Eigen::Matrix3d m = linearPart(transform);
  const Eigen::Vector3d t = translationPart(transform);
  if (!m.allFinite() || !t.allFinite()) return {};
  // M = U S V^T: the orthogonal polar factor is U V^T. If it mirrors, the axis of the smallest
  // singular value (the last column of U) is flipped: of all rotations that is the nearest.
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(m, Eigen::ComputeFullU | Eigen::ComputeFullV);
  Eigen::Matrix3d u = svd.matrixU();
  if ((u * svd.matrixV().transpose()).determinant() < 0) u.col(2) = -u.col(2);
  Eigen::Quaterniond real(Eigen::Matrix3d(u * svd.matrixV().transpose()));
  real.normalize();
  const Eigen::Quaterniond shift(0, t.x() / 2, t.y() / 2, t.z() / 2);
  return {toFloat4(real), toFloat4(shift * real)};
}

std::vector<AffineTransform> skinningTransforms(const Skeleton& skeleton,
                                                std::span<const AffineTransform> world) {
  PELAGE_ASSERT(world.size() == skeleton.bones.size(), "one world transform a bone");
  std::vector<AffineTransform> result(world.begin(), world.end());
  for (size_t i = 0; i < std::min(result.size(), skeleton.bones.size()); ++i)
    if (const auto fromBind = inverse(skeleton.bones[i].bind))
      result[i] = multiply(world[i], *fromBind);
  return result;
}

}  // namespace pelage
