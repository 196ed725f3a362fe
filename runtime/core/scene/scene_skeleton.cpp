// Skeletons of a scene, and what is given back.
#include <algorithm>
#include <string>

#include "base/ids.h"
#include "scene/scene_frame.h"
#include "sdf/sdf_collider.h"
#include "skinning/skeleton_pose.h"

namespace pelage {

Result<SkeletonId> Scene::addSkeleton(const SkeletonDef& def) {
  const auto refuse = [&](const char* what) {
    return Error{ErrorCode::kInvalidArgument, "skeleton '" + def.name + "': " + what};
  };
  if (def.boneCount == 0) return refuse("boneCount must be at least 1");
  if (skeletons_.isFull()) return refuse("the scene has as many skeletons as ids");
  auto skeleton = std::unique_ptr<SkeletonPose>(new SkeletonPose);
  skeleton->name_ = def.name;
  skeleton->internals_->name = def.name;
  skeleton->internals_->bones.resize(def.boneCount);
  skeleton->internals_->origin.shifted = shifted();
  return skeletons_.add(std::move(skeleton));
}

Result<void> Scene::removeSkeleton(SkeletonId id) {
  if (!isValid(id)) return detail::noSuchThing("removeSkeleton()", skeletons_.whyNot(id));
  const SkeletonPose& removed = skeleton(id);
  const auto refuse = [&](const std::string& what) {
    return Error{ErrorCode::kInvalidArgument,
                 "skeleton '" + removed.name() + "': " + what + " follows it; remove that first"};
  };
  for (const auto& object : objects_) {
    if (object != nullptr && object->internals_->skeleton == removed.internals_.get())
      return refuse("hair '" + object->name() + "'");
  }
  for (const auto& held : colliders_) {
    if (held != nullptr && held->internals_->skeleton == removed.internals_.get())
      return refuse("collider '" + held->name() + "'");
  }
  forgetOwner(&removed);
  skeletons_.remove(id);
  return {};
}

SkeletonPose& Scene::skeleton(SkeletonId id) {
  SkeletonPose* found = skeletons_.find(id);
  if (found == nullptr) detail::endForId("skeleton()", skeletons_.whyNot(id));
  return *found;
}

const SkeletonPose& Scene::skeleton(SkeletonId id) const {
  return const_cast<Scene*>(this)->skeleton(id);
}

// What a def means: nullptr for bones of its own. The errors do not name the object.
Result<SkeletonPose*> Scene::findSkeleton(SkeletonId id, uint32_t boneCount) const {
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

// The transforms that a method reads.
BufferId Scene::skeletonBuffer(detail::SkeletonInternals& skeleton, SkinningMethod method) {
  detail::SkeletonInternals::Copy& copy = skeleton.copyFor(method);
  if (copy.buffer == BufferId::kInvalid) {
    const bool dual = method == SkinningMethod::kDualQuaternions;
    copy.buffer =
        resources_.add({.name = skeleton.name + (dual ? "/dualQuaternions" : "/matrices"),
                        .size = detail::rowsOf(method) * skeleton.bones.size() * detail::kVector,
                        .stride = detail::kVector,
                        .usage = BufferUsage::kStorage | BufferUsage::kUpload});
  }
  return copy.buffer;
}

// Those that nothing reads any more.
void Scene::removeUnusedCopies() {
  for (const auto& skeleton : skeletons_) {
    if (skeleton == nullptr) continue;
    for (detail::SkeletonInternals::Copy& copy : skeleton->internals_->copies) {
      const auto reads = [&](BufferId buffer) { return buffer == copy.buffer; };
      const bool read =
          std::any_of(objects_.begin(), objects_.end(),
                      [&](const auto& object) {
                        return object != nullptr && reads(object->buffers_.boneTransforms);
                      }) ||
          std::any_of(colliders_.begin(), colliders_.end(), [&](const auto& held) {
            return held != nullptr && reads(held->buffers_.bones);
          });
      if (read) continue;
      removeBuffer(copy.buffer);
      copy = {};
    }
  }
}

// Takes over the bones that have changed.
void Scene::followSkeletons() {
  for (const auto& skeleton : skeletons_)
    if (skeleton != nullptr) detail::moveOrigin(*skeleton->internals_);
  for (const auto& object : objects_) {
    if (object == nullptr || object->internals_->skeleton == nullptr) continue;
    detail::HairInternals& internals = *object->internals_;
    if (internals.skeletonVersion == internals.skeleton->version) continue;
    internals.skeletonVersion = internals.skeleton->version;
    internals.bones = internals.skeleton->bones;
    internals.bonesChanged = true;
  }
  for (const auto& held : colliders_)
    if (held != nullptr && held->internals_->skeleton != nullptr)
      held->internals_->bones = held->internals_->skeleton->bones;
}

void Scene::removeDrawBuffers() {
  for (BufferId* buffer :
       {&lists_.heads,     &lists_.nodes,     &lists_.counters,    &lists_.tiles,
        &lists_.tail,      &tiles_.records,   &tiles_.tiles,       &tiles_.references,
        &tiles_.sums,      &tiles_.picture,   &hybrid_.depths,     &hybrid_.colors,
        &hybrid_.tail,     &hybrid_.counters, &hybrid_.tiles,      &shortCut_.depths,
        &shortCut_.colors, &shortCut_.tail,   &shortCut_.counters, &shortCut_.tiles,
        &shadowWords_,     &shadowViews_})
    removeBuffer(*buffer);
}

void Scene::trim() {
  commitFrames();
  removeDrawBuffers();
  for (const auto& held : colliders_)
    if (held != nullptr) removeIsoSurface(*held);
}

}  // namespace pelage
