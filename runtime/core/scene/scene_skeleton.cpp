// Skeletons of a scene.
#include <algorithm>
#include <string>

#include "base/ids.h"
#include "scene/scene_parts.h"
#include "sdf/sdf_collider.h"
#include "skinning/skeleton_pose.h"

namespace pelage::detail {

Result<SkeletonId> HairStore::addSkeleton(const SkeletonDef& def) {
  const auto refuse = [&](const std::string& what) {
    return Error{ErrorCode::kInvalidArgument, "skeleton '" + def.name + "': " + what};
  };
  if (const std::string fault = faultOf(def); !fault.empty()) return refuse(fault);
  if (skeletonSlots.isFull()) return refuse("the scene has as many skeletons as ids");
  auto skeleton = std::unique_ptr<SkeletonPose>(new SkeletonPose);
  skeleton->name_ = def.name;
  SkeletonInternals& internals = *skeleton->internals_;
  internals.name = def.name;
  internals.source = def.source;
  internals.boneCount = def.boneCount;
  if (internals.isOnGpu()) internals.deviation = def.deviation;
  if (def.surface != nullptr) addSurface(internals, *def.surface, factory());
  internals.bones.resize(internals.isOnGpu() ? 1 : internals.boneCount);
  internals.origin.shifted = shifted;
  return skeletonSlots.add(std::move(skeleton));
}

Result<void> HairStore::checkUnused(SkeletonPose& skeleton) const {
  const SkeletonInternals* const internals = &of(skeleton);
  const auto refuse = [&](const std::string& what) {
    return Error{ErrorCode::kInvalidArgument,
                 "skeleton '" + skeleton.name() + "': " + what + " follows it; remove that first"};
  };
  for (HairObject& object : hairs())
    if (of(object).skeleton == internals) return refuse("hair '" + object.name() + "'");
  for (SdfCollider& held : colliders())
    if (of(held).skeleton == internals) return refuse("collider '" + held.name() + "'");
  return {};
}

SkeletonPose& HairStore::skeleton(SkeletonId id) const {
  SkeletonPose* found = skeletonSlots.find(id);
  if (found == nullptr) endForId("skeleton()", skeletonSlots.whyNot(id));
  return *found;
}

Result<SkeletonPose*> HairStore::findSkeleton(SkeletonId id, uint32_t boneCount) const {
  const auto refuse = [](const std::string& what) {
    return Error{ErrorCode::kInvalidArgument, what};
  };
  if (boneCount == 0) return refuse("boneCount must be at least 1");
  if (id == SkeletonId::kInvalid) return static_cast<SkeletonPose*>(nullptr);
  SkeletonPose* skeleton = skeletonSlots.find(id);
  if (skeleton == nullptr)
    return refuse(std::string("the id of its skeleton ") + skeletonSlots.whyNot(id));
  if (boneCount != 1 && boneCount != skeleton->boneCount()) {
    return refuse("boneCount is " + std::to_string(boneCount) + ", but skeleton '" +
                  skeleton->name() + "' has " + std::to_string(skeleton->boneCount()) + " bones");
  }
  return skeleton;
}

void HairStore::removeUnusedCopies() {
  for (SkeletonPose& skeleton : skeletons()) {
    for (SkeletonInternals::Copy& copy : of(skeleton).copies) {
      const auto reads = [&](BufferId buffer) { return buffer == copy.buffer; };
      const bool read =
          std::ranges::any_of(
              hairs(), [&](const HairObject& o) { return reads(o.buffers().boneTransforms); }) ||
          std::ranges::any_of(colliders(),
                              [&](const SdfCollider& c) { return reads(c.buffers().bones); });
      if (read) continue;
      factory().remove(copy.buffer);
      copy = {};
    }
  }
}

Result<void> HairStore::checkSkeletons() const {
  for (SkeletonPose& skeleton : skeletons()) {
    const SkeletonInternals& internals = of(skeleton);
    const bool followed = std::ranges::any_of(
        internals.copies, [](const auto& copy) { return copy.buffer != BufferId::kInvalid; });
    if (!followed) continue;
    if (const std::string fault = faultOfSource(internals, resources); !fault.empty())
      return Error{ErrorCode::kInvalidArgument, "skeleton '" + skeleton.name() + "': " + fault};
  }
  return {};
}

void HairStore::followSkeletons() {
  for (SkeletonPose& skeleton : skeletons()) moveOrigin(of(skeleton));
  for (HairObject& object : hairs()) {
    HairInternals& hair = of(object);
    if (hair.skeleton == nullptr || hair.skeletonVersion == hair.skeleton->version) continue;
    hair.skeletonVersion = hair.skeleton->version;
    hair.bones = hair.skeleton->bones;
    hair.bonesChanged = true;
  }
  for (SdfCollider& held : colliders())
    if (of(held).skeleton != nullptr) of(held).bones = of(held).skeleton->bones;
}

}  // namespace pelage::detail

namespace pelage {

Result<void> Scene::removeSkeleton(SkeletonId id) {
  detail::HairStore& store = parts_->store;
  if (!isValid(id)) return detail::noSuchThing("removeSkeleton()", store.skeletonSlots.whyNot(id));
  SkeletonPose& removed = store.skeleton(id);
  if (Result<void> unused = store.checkUnused(removed); !unused) return unused;
  parts_->journal.forgetOwner(&removed);
  store.factory().remove(detail::HairStore::of(removed).surfaceBones);
  store.skeletonSlots.remove(id);
  return {};
}

}  // namespace pelage
