// Mesh colliders of a scene.
#include <string>

#include "base/ids.h"
#include "scene/scene_parts.h"
#include "sdf/dense_sdf.h"

namespace pelage {

namespace {

Error refuseCollider(const SdfColliderDef& def, const std::string& what) {
  return {ErrorCode::kInvalidArgument, "collider '" + def.name + "': " + what};
}

}  // namespace

Result<ColliderId> Scene::addCollider(const CollisionMesh& mesh, const SdfColliderDef& def) {
  detail::HairStore& store = parts_->store;
  if (Result<void> valid = detail::checkSdfColliderDef(def); !valid)
    return refuseCollider(def, valid.error().message);
  if (store.sdfs.colliders.isFull())
    return refuseCollider(def, "the scene has as many colliders as ids");
  const Result<SkeletonPose*> skeleton = store.findSkeleton(def.skeleton, def.boneCount);
  if (!skeleton) return refuseCollider(def, skeleton.error().message);
  detail::ColliderBones bones = {.count = def.boneCount};
  if (*skeleton != nullptr) {
    if (def.vertices != BufferId::kInvalid)
      return refuseCollider(def, "has a vertex buffer, which follows no skeleton");
    bones = {&detail::HairStore::of(**skeleton), (*skeleton)->boneCount()};
  }
  const Result<ColliderId> id = store.sdfs.add(mesh, def, bones, store.shifted, store.factory());
  if (id) parts_->journal.relayFrames();
  return id;
}

Result<ColliderId> Scene::addCollider(const SdfData& data, const SdfColliderDef& def) {
  detail::HairStore& store = parts_->store;
  if (Result<void> valid = detail::checkSdfColliderDef(def); !valid)
    return refuseCollider(def, valid.error().message);
  if (store.sdfs.colliders.isFull())
    return refuseCollider(def, "the scene has as many colliders as ids");
  if (def.skeleton != SkeletonId::kInvalid)
    return refuseCollider(def,
                          "a field that was built before never moves, and follows no skeleton");
  const Result<ColliderId> id = store.sdfs.add(data, def, store.shifted, store.factory());
  if (id) parts_->journal.relayFrames();
  return id;
}

Result<ColliderId> Scene::addCollider(const DenseSdf& sdf, const SdfColliderDef& def) {
  detail::HairStore& store = parts_->store;
  if (const std::string fault = detail::faultOf(sdf, store.resources); !fault.empty())
    return refuseCollider(def, fault);
  if (store.sdfs.colliders.isFull())
    return refuseCollider(def, "the scene has as many colliders as ids");
  const ColliderId id = store.sdfs.add(sdf, def, store.shifted, store.factory());
  parts_->journal.relayFrames();
  return id;
}

Result<void> Scene::removeCollider(ColliderId id) {
  detail::HairStore& store = parts_->store;
  if (!isValid(id)) return detail::noSuchThing("removeCollider()", store.sdfs.colliders.whyNot(id));
  parts_->journal.settle(false);
  parts_->journal.forgetOwner(&store.collider(id));
  store.sdfs.remove(id, store.factory());
  store.removeUnusedCopies();
  parts_->journal.relayFrames();
  return {};
}

ObjectBytes Scene::bytesOf(ColliderId id) const {
  static_cast<void>(collider(id));
  const detail::SdfRoom::Bytes bytes = parts_->store.sdfs.bytesOf(id, parts_->store.factory());
  return {bytes.own, bytes.shared};
}

Result<SdfData> Scene::copySdf(ColliderId id, std::span<const std::byte> keys,
                               std::span<const std::byte> surface) const {
  static_cast<void>(collider(id));
  return parts_->store.sdfs.copy(id, keys, surface);
}

Result<void> Scene::checkColliderDraw(ColliderId id, std::span<const std::byte> counts) const {
  static_cast<void>(collider(id));
  return parts_->store.sdfs.checkDraw(id, counts);
}

namespace detail {

SdfCollider& HairStore::collider(ColliderId id) const {
  SdfCollider* found = sdfs.colliders.find(id);
  if (found == nullptr) endForId("collider()", sdfs.colliders.whyNot(id));
  return *found;
}

}  // namespace detail
}  // namespace pelage
