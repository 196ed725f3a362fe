// Skeletons of a scene, and what is given back.
#include <algorithm>
#include <string>

#include "base/ids.h"
#include "scene/scene_impl.h"
#include "sdf/sdf_collider.h"
#include "skinning/skeleton_pose.h"

namespace pelage::detail {

Result<SkeletonId> SceneImpl::addSkeleton(const SkeletonDef& def) {
  const auto refuse = [&](const std::string& what) {
    return Error{ErrorCode::kInvalidArgument, "skeleton '" + def.name + "': " + what};
  };
  if (const std::string fault = faultOf(def); !fault.empty()) return refuse(fault);
  if (skeletons_.isFull()) return refuse("the scene has as many skeletons as ids");
  auto skeleton = std::unique_ptr<SkeletonPose>(new SkeletonPose);
  skeleton->name_ = def.name;
  SkeletonInternals& internals = *skeleton->internals_;
  internals.name = def.name;
  internals.source = def.source;
  internals.boneCount = def.boneCount;
  if (internals.isOnGpu()) internals.deviation = def.deviation;
  if (def.surface != nullptr) addSurface(internals, *def.surface, room());
  internals.bones.resize(internals.isOnGpu() ? 1 : internals.boneCount);
  internals.origin.shifted = shifted();
  return skeletons_.add(std::move(skeleton));
}

Result<void> SceneImpl::removeSkeleton(SkeletonId id) {
  if (!isValid(id)) return noSuchThing("removeSkeleton()", skeletons_.whyNot(id));
  const SkeletonPose& removed = skeleton(id);
  const auto refuse = [&](const std::string& what) {
    return Error{ErrorCode::kInvalidArgument,
                 "skeleton '" + removed.name() + "': " + what + " follows it; remove that first"};
  };
  for (const auto& object : objects_) {
    if (object != nullptr && object->internals_->skeleton == removed.internals_.get())
      return refuse("hair '" + object->name() + "'");
  }
  for (const auto& held : sdfs_.colliders) {
    if (held != nullptr && held->internals_->skeleton == removed.internals_.get())
      return refuse("collider '" + held->name() + "'");
  }
  forgetOwner(&removed);
  room().remove(skeleton(id).internals_->surfaceBones);
  skeletons_.remove(id);
  return {};
}

SkeletonPose& SceneImpl::skeleton(SkeletonId id) {
  SkeletonPose* found = skeletons_.find(id);
  if (found == nullptr) endForId("skeleton()", skeletons_.whyNot(id));
  return *found;
}

const SkeletonPose& SceneImpl::skeleton(SkeletonId id) const {
  return const_cast<SceneImpl*>(this)->skeleton(id);
}

// What a def means: nullptr for bones of its own. The errors do not name the object.
Result<SkeletonPose*> SceneImpl::findSkeleton(SkeletonId id, uint32_t boneCount) const {
  const auto refuse = [](const std::string& what) {
    return Error{ErrorCode::kInvalidArgument, what};
  };
  if (boneCount == 0) return refuse("boneCount must be at least 1");
  if (id == SkeletonId::kInvalid) return static_cast<SkeletonPose*>(nullptr);
  SkeletonPose* skeleton = skeletons_.find(id);
  if (skeleton == nullptr)
    return refuse(std::string("the id of its skeleton ") + skeletons_.whyNot(id));
  if (boneCount != 1 && boneCount != skeleton->boneCount()) {
    return refuse("boneCount is " + std::to_string(boneCount) + ", but skeleton '" +
                  skeleton->name() + "' has " + std::to_string(skeleton->boneCount()) + " bones");
  }
  return skeleton;
}

// Those that nothing reads any more.
void SceneImpl::removeUnusedCopies() {
  for (const auto& skeleton : skeletons_) {
    if (skeleton == nullptr) continue;
    for (SkeletonInternals::Copy& copy : skeleton->internals_->copies) {
      const auto reads = [&](BufferId buffer) { return buffer == copy.buffer; };
      const bool read =
          std::any_of(objects_.begin(), objects_.end(),
                      [&](const auto& object) {
                        return object != nullptr && reads(object->buffers_.boneTransforms);
                      }) ||
          std::any_of(sdfs_.colliders.begin(), sdfs_.colliders.end(), [&](const auto& held) {
            return held != nullptr && reads(held->buffers_.bones);
          });
      if (read) continue;
      room().remove(copy.buffer);
      copy = {};
    }
  }
}

// What an engine has got wrong of bones on the GPU that something follows.
Result<void> SceneImpl::checkSkeletons() const {
  for (const auto& skeleton : skeletons_) {
    if (skeleton == nullptr) continue;
    const SkeletonInternals& internals = *skeleton->internals_;
    const bool followed =
        std::any_of(internals.copies.begin(), internals.copies.end(),
                    [](const auto& copy) { return copy.buffer != BufferId::kInvalid; });
    if (!followed) continue;
    if (const std::string fault = faultOfSource(internals, resources_); !fault.empty())
      return Error{ErrorCode::kInvalidArgument, "skeleton '" + skeleton->name() + "': " + fault};
  }
  return {};
}

// Takes over the bones that have changed.
void SceneImpl::followSkeletons() {
  for (const auto& skeleton : skeletons_)
    if (skeleton != nullptr) moveOrigin(*skeleton->internals_);
  for (const auto& object : objects_) {
    if (object == nullptr || object->internals_->skeleton == nullptr) continue;
    HairInternals& internals = *object->internals_;
    if (internals.skeletonVersion == internals.skeleton->version) continue;
    internals.skeletonVersion = internals.skeleton->version;
    internals.bones = internals.skeleton->bones;
    internals.bonesChanged = true;
  }
  for (const auto& held : sdfs_.colliders)
    if (held != nullptr && held->internals_->skeleton != nullptr)
      held->internals_->bones = held->internals_->skeleton->bones;
}

void SceneImpl::removeDrawBuffers(const char* reason) { draws_.trim(room(), reason); }

void SceneImpl::trim() {
  commitFrames();
  collectShared();
  removeDrawBuffers("Scene::trim() freed its buffers; write it again");
  sdfs_.trim(room());
}

}  // namespace pelage::detail
