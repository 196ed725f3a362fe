// Mesh colliders of a scene.
#include <string>

#include "base/ids.h"
#include "scene/scene_impl.h"
#include "sdf/dense_sdf.h"

namespace pelage::detail {

Result<ColliderId> SceneImpl::addCollider(const CollisionMesh& mesh, const SdfColliderDef& def) {
  const auto refuse = [&](const std::string& what) {
    return Error{ErrorCode::kInvalidArgument, "collider '" + def.name + "': " + what};
  };
  if (Result<void> valid = checkSdfColliderDef(def); !valid) return refuse(valid.error().message);
  if (sdfs_.colliders.isFull()) return refuse("the scene has as many colliders as ids");
  const Result<SkeletonPose*> skeleton = findSkeleton(def.skeleton, def.boneCount);
  if (!skeleton) return refuse(skeleton.error().message);
  ColliderBones bones = {.count = def.boneCount};
  if (*skeleton != nullptr) {
    if (def.vertices != BufferId::kInvalid)
      return refuse("has a vertex buffer, which follows no skeleton");
    bones = {(*skeleton)->internals_.get(), (*skeleton)->boneCount()};
  }
  const Result<ColliderId> id = sdfs_.add(mesh, def, bones, shifted(), room());
  if (id) relayFrames();
  return id;
}

Result<ColliderId> SceneImpl::addCollider(const SdfData& data, const SdfColliderDef& def) {
  const auto refuse = [&](const std::string& what) {
    return Error{ErrorCode::kInvalidArgument, "collider '" + def.name + "': " + what};
  };
  if (Result<void> valid = checkSdfColliderDef(def); !valid) return refuse(valid.error().message);
  if (sdfs_.colliders.isFull()) return refuse("the scene has as many colliders as ids");
  if (def.skeleton != SkeletonId::kInvalid)
    return refuse("a field that was built before never moves, and follows no skeleton");
  const Result<ColliderId> id = sdfs_.add(data, def, shifted(), room());
  if (id) relayFrames();
  return id;
}

Result<ColliderId> SceneImpl::addCollider(const DenseSdf& sdf, const SdfColliderDef& def) {
  const auto refuse = [&](const std::string& what) {
    return Error{ErrorCode::kInvalidArgument, "collider '" + def.name + "': " + what};
  };
  if (const std::string fault = faultOf(sdf, resources_); !fault.empty()) return refuse(fault);
  if (sdfs_.colliders.isFull()) return refuse("the scene has as many colliders as ids");
  const ColliderId id = sdfs_.add(sdf, def, shifted(), room());
  relayFrames();
  return id;
}

Result<void> SceneImpl::removeCollider(ColliderId id) {
  if (!isValid(id)) return noSuchThing("removeCollider()", sdfs_.colliders.whyNot(id));
  settleFrames(false);
  forgetOwner(&collider(id));
  sdfs_.remove(id, room());
  removeUnusedCopies();
  relayFrames();
  return {};
}

ObjectBytes SceneImpl::objectBytes(ColliderId id) {
  static_cast<void>(collider(id));
  const SdfRoom::Bytes bytes = sdfs_.bytesOf(id, room());
  return {bytes.own, bytes.shared};
}

SdfCollider& SceneImpl::collider(ColliderId id) {
  SdfCollider* found = sdfs_.colliders.find(id);
  if (found == nullptr) endForId("collider()", sdfs_.colliders.whyNot(id));
  return *found;
}

const SdfCollider& SceneImpl::collider(ColliderId id) const {
  return const_cast<SceneImpl*>(this)->collider(id);
}

Result<SdfData> SceneImpl::copySdf(ColliderId id, std::span<const std::byte> keys,
                                   std::span<const std::byte> surface) const {
  static_cast<void>(collider(id));
  return sdfs_.copy(id, keys, surface);
}

Result<void> SceneImpl::drawCollider(ColliderId id, const View& view, const Light& light,
                                     const ColliderLook& look, PassList& list) {
  settleFrames(false);
  static_cast<void>(collider(id));
  if (const Result<DrawnView> frame = beginDraw(view, {&light, 1}, &list); !frame)
    return frame.error();
  Result<void> added = sdfs_.draw(id, view, light, look, room(), list);
  setArea({&list, 1}, view);
  return added;
}

Result<void> SceneImpl::checkColliderDraw(ColliderId id, std::span<const std::byte> counts) const {
  static_cast<void>(collider(id));
  return sdfs_.checkDraw(id, counts);
}

}  // namespace pelage::detail
