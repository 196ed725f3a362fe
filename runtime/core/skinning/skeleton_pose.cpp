#include "skinning/skeleton_pose.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <span>

#include "pelage/assert.h"
#include "pelage/skeleton.h"

namespace pelage {

SkeletonPose::SkeletonPose() : internals_(std::make_unique<detail::SkeletonInternals>()) {}
SkeletonPose::~SkeletonPose() = default;

uint32_t SkeletonPose::boneCount() const { return static_cast<uint32_t>(internals_->bones.size()); }

std::span<const AffineTransform> SkeletonPose::bones() const { return internals_->bones; }

void SkeletonPose::setBones(std::span<const AffineTransform> bones) {
  std::vector<AffineTransform>& own = internals_->bones;
  PELAGE_ASSERT(bones.size() == own.size(),
                "SkeletonPose::setBones() takes boneCount() transforms");
  bool changed = false;
  for (size_t i = 0; i < std::min(bones.size(), own.size()); ++i) {
    if (bones[i] == own[i] || !detail::isFiniteBone(bones[i])) continue;
    own[i] = bones[i];
    changed = true;
  }
  if (changed) ++internals_->version;
}

namespace detail {
namespace {

// The origin follows when the anchor is further away from it [m].
constexpr float kOriginRange = 1.5f;
// Larger coordinates [m] the kernels take for broken: isUsable() in common/quaternion.hlsli.
constexpr float kUsable = 1e18f;

}  // namespace

bool isFiniteBone(const AffineTransform& bone) {
  return std::all_of(std::begin(bone.rows), std::end(bone.rows), [](const Float4& r) {
    return std::isfinite(r.x) && std::isfinite(r.y) && std::isfinite(r.z) && std::isfinite(r.w);
  });
}

void moveOrigin(SkeletonInternals& skeleton, const SkeletonInternals::Anchor& anchor) {
  if (!skeleton.anchor) skeleton.anchor = anchor;
  moveOrigin(skeleton);
}

void moveOrigin(SkeletonInternals& skeleton) {
  if (!skeleton.anchor) return;
  const Float3 p = transformPoint(skeleton.bones[skeleton.anchor->bone], skeleton.anchor->point);
  Float3& origin = skeleton.origin;
  const auto stays = [&](float at, float from) {
    return skeleton.originKnown && std::abs(at - from) <= kOriginRange;
  };
  const auto isUsable = [](float at) { return std::abs(at) < kUsable; };
  if (!isUsable(p.x) || !isUsable(p.y) || !isUsable(p.z)) return;
  if (stays(p.x, origin.x) && stays(p.y, origin.y) && stays(p.z, origin.z)) return;
  origin = {std::round(p.x), std::round(p.y), std::round(p.z)};
  skeleton.originKnown = true;
}

std::vector<Float4> packBones(std::span<const AffineTransform> bones, const Float3& origin,
                              SkinningMethod method) {
  std::vector<Float4> packed;
  packed.reserve(rowsOf(method) * bones.size());
  for (AffineTransform bone : bones) {
    bone.rows[0].w -= origin.x;
    bone.rows[1].w -= origin.y;
    bone.rows[2].w -= origin.z;
    if (method == SkinningMethod::kMatrices) {
      packed.insert(packed.end(), std::begin(bone.rows), std::end(bone.rows));
    } else {
      const DualQuaternion motion = toDualQuaternion(bone);
      packed.insert(packed.end(), {motion.real, motion.dual});
    }
  }
  return packed;
}

void uploadBones(SkeletonInternals& skeleton, SkinningMethod method, PassList& list) {
  SkeletonInternals::Copy& copy = skeleton.copyFor(method);
  if (copy.version == skeleton.version && copy.origin == skeleton.origin) return;
  const std::vector<Float4> packed = packBones(skeleton.bones, skeleton.origin, method);
  addUpload(list, copy.buffer, std::as_bytes(std::span(packed)));
  copy.version = skeleton.version;
  copy.origin = skeleton.origin;
}

}  // namespace detail
}  // namespace pelage
