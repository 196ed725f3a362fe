#include "skinning/skeleton_pose.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <iterator>
#include <span>

#include "base/finite.h"
#include "passes/upload_memory.h"
#include "pelage/assert.h"
#include "pelage/constants.h"
#include "pelage/skeleton.h"
#include "skinning/gpu_bones.h"

namespace pelage {

SkeletonPose::SkeletonPose() : internals_(std::make_unique<detail::SkeletonInternals>()) {}
SkeletonPose::~SkeletonPose() = default;

uint32_t SkeletonPose::boneCount() const { return internals_->boneCount; }

std::span<const AffineTransform> SkeletonPose::bones() const {
  if (internals_->isOnGpu()) return {};
  return internals_->bones;
}

void SkeletonPose::setBones(std::span<const AffineTransform> bones) {
  PELAGE_ASSERT(internals_->source == BoneSource::kHost,
                "the skeleton's bones are on the GPU: SkeletonDef::source");
  if (internals_->isOnGpu()) return;
  HostArray<AffineTransform>& own = internals_->bones;
  PELAGE_ASSERT(bones.size() == own.size(),
                "SkeletonPose::setBones() takes boneCount() transforms");
  bool changed = false;
  for (size_t i = 0; i < std::min(bones.size(), own.size()); ++i) {
    if (bones[i] == own[i] || !detail::isFinite(bones[i])) continue;
    own[i] = bones[i];
    changed = true;
  }
  if (changed) ++internals_->version;
}

void SkeletonPose::setBones(const BoneBuffer& bones, const AffineTransform& placement) {
  PELAGE_ASSERT(internals_->source == BoneSource::kBuffer,
                "a buffer of bones is for SkeletonDef::source = BoneSource::kBuffer");
  if (internals_->source != BoneSource::kBuffer) return;
  internals_->boneBuffer = bones;
  if (detail::isFinite(placement)) internals_->bones = {placement};
  ++internals_->version;
}

void SkeletonPose::setVertices(std::span<const VertexBuffer> parts,
                               const AffineTransform& placement) {
  PELAGE_ASSERT(internals_->source == BoneSource::kSurface,
                "buffers of vertices are for SkeletonDef::source = BoneSource::kSurface");
  PELAGE_ASSERT(parts.size() == internals_->parts.size(),
                "setVertices() takes a buffer for each part of the skin table");
  if (parts.size() != internals_->parts.size()) return;
  internals_->vertices.assign(parts.begin(), parts.end());
  if (detail::isFinite(placement)) internals_->bones = {placement};
  ++internals_->version;
}

namespace detail {

bool isUsable(const Float3& v) {
  constexpr float kUsable = std::bit_cast<float>(quaternion::kUsableBits);
  return std::abs(v.x) < kUsable && std::abs(v.y) < kUsable && std::abs(v.z) < kUsable;
}

void moveOrigin(SkeletonInternals& skeleton, const SkeletonInternals::Anchor& anchor) {
  if (!skeleton.anchor) skeleton.anchor = anchor;
  moveOrigin(skeleton);
}

void moveOrigin(SkeletonInternals& skeleton) {
  if (!skeleton.anchor) return;
  const Float3 p = transformPoint(skeleton.bones[skeleton.anchor->bone], skeleton.anchor->point);
  const Float3 away = skeleton.origin.relative(p);
  const auto stays = [&](float distance) {
    return skeleton.originKnown && std::abs(distance) <= kOriginRange;
  };
  if (!isUsable(p)) return;
  if (stays(away.x) && stays(away.y) && stays(away.z)) return;
  skeleton.origin = skeleton.origin.near(p);
  skeleton.originKnown = true;
}

void shiftWorld(SkeletonInternals& skeleton, const Vector3<double>& shift,
                const Vector3<double>& shifted) {
  skeleton.origin.shifted = shifted;
  skeleton.shiftedFloats.begin();
  for (AffineTransform& bone : skeleton.bones) skeleton.shiftedFloats.shift(bone, -shift);
  skeleton.shiftedFloats.end();
}

void sendBones(std::span<const AffineTransform> bones, const LocalOrigin& origin,
               SkinningMethod method, BufferId buffer, PassList& list) {
  auto packed = uploadOf<Float4>(list, buffer, rowsOf(method) * bones.size()).begin();
  for (AffineTransform bone : bones) {
    const Float3 moved = origin.relative({bone.rows[0].w, bone.rows[1].w, bone.rows[2].w});
    bone.rows[0].w = moved.x;
    bone.rows[1].w = moved.y;
    bone.rows[2].w = moved.z;
    if (method == SkinningMethod::kMatrices) {
      packed = std::copy(std::begin(bone.rows), std::end(bone.rows), packed);
    } else {
      const DualQuaternion motion = toDualQuaternion(bone);
      *packed++ = motion.real;
      *packed++ = motion.dual;
    }
  }
}

BufferId bonesFor(SkeletonInternals& skeleton, SkinningMethod method,
                  const BufferFactory& factory) {
  SkeletonInternals::Copy& copy = skeleton.copyFor(method);
  if (copy.buffer == BufferId::kInvalid) {
    const bool dual = method == SkinningMethod::kDualQuaternions;
    copy.buffer = factory.add(
        skeleton.name + (dual ? "/dualQuaternions" : "/matrices"),
        rowsOf(method) * skeleton.boneCount, sizeof(Float4), {},
        skeleton.isOnGpu() ? BufferUsage::kStorage : BufferUsage::kStorage | BufferUsage::kUpload);
  }
  return copy.buffer;
}

Result<void> sendBones(SkeletonInternals& skeleton, SkinningMethod method,
                       const ResourceTable& resources, PassList& list) {
  SkeletonInternals::Copy& copy = skeleton.copyFor(method);
  if (copy.version == skeleton.version && copy.origin.isAt(skeleton.origin)) return {};
  if (skeleton.isOnGpu()) {
    if (Result<void> added = addBonePasses(skeleton, method, resources, list); !added) return added;
  } else {
    sendBones(skeleton.bones, skeleton.origin, method, copy.buffer, list);
  }
  copy.version = skeleton.version;
  copy.origin = skeleton.origin;
  return {};
}

}  // namespace detail
}  // namespace pelage
