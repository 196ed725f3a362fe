#include "pelage/scene.h"

#include <utility>

#include "scene/scene_impl.h"

namespace pelage {

Scene::Scene() : impl_(std::make_shared<detail::SceneImpl>()) {}
Scene::~Scene() = default;
Scene::Scene(Scene&& other) noexcept
    : impl_(std::exchange(other.impl_, std::make_shared<detail::SceneImpl>())) {}
Scene& Scene::operator=(Scene&& other) noexcept {
  impl_ = std::exchange(other.impl_, std::make_shared<detail::SceneImpl>());
  return *this;
}

Result<HairId> Scene::addHair(const HairAsset& asset, const HairDef& def) {
  return impl_->addHair(std::make_shared<const HairAsset>(asset), def);
}
Result<HairId> Scene::addHair(std::shared_ptr<const HairAsset> asset, const HairDef& def) {
  return impl_->addHair(std::move(asset), def);
}
Result<void> Scene::removeHair(HairId id) { return impl_->removeHair(id); }
HairObject& Scene::hair(HairId id) { return impl_->hair(id); }
const HairObject& Scene::hair(HairId id) const { return impl_->hair(id); }
bool Scene::isValid(HairId id) const { return impl_->isValid(id); }
bool Scene::isValid(ColliderId id) const { return impl_->isValid(id); }
bool Scene::isValid(SkeletonId id) const { return impl_->isValid(id); }
uint32_t Scene::hairCount() const { return impl_->hairCount(); }
Result<ColliderId> Scene::addCollider(const CollisionMesh& mesh, const SdfColliderDef& def) {
  return impl_->addCollider(mesh, def);
}
Result<ColliderId> Scene::addCollider(const SdfData& data, const SdfColliderDef& def) {
  return impl_->addCollider(data, def);
}
Result<ColliderId> Scene::addCollider(const DenseSdf& sdf, const SdfColliderDef& def) {
  return impl_->addCollider(sdf, def);
}
Result<void> Scene::removeCollider(ColliderId id) { return impl_->removeCollider(id); }
SdfCollider& Scene::collider(ColliderId id) { return impl_->collider(id); }
const SdfCollider& Scene::collider(ColliderId id) const { return impl_->collider(id); }
Result<SkeletonId> Scene::addSkeleton(const SkeletonDef& def) { return impl_->addSkeleton(def); }
Result<void> Scene::removeSkeleton(SkeletonId id) { return impl_->removeSkeleton(id); }
SkeletonPose& Scene::skeleton(SkeletonId id) { return impl_->skeleton(id); }
const SkeletonPose& Scene::skeleton(SkeletonId id) const { return impl_->skeleton(id); }
void Scene::trim() { impl_->trim(); }
Result<SdfData> Scene::copySdf(ColliderId id, std::span<const std::byte> keys,
                               std::span<const std::byte> surface) const {
  return impl_->copySdf(id, keys, surface);
}
BufferId Scene::sdfKeys() const { return impl_->sdfKeys(); }
BufferId Scene::sdfSurface() const { return impl_->sdfSurface(); }
ResourceTable& Scene::resources() { return impl_->resources(); }
const ResourceTable& Scene::resources() const { return impl_->resources(); }
ObjectBytes Scene::bytesOf(HairId id) const { return impl_->objectBytes(id); }
ObjectBytes Scene::bytesOf(ColliderId id) const { return impl_->objectBytes(id); }
DrawBytes Scene::drawBytes() const { return impl_->drawBytes(); }
Result<void> Scene::simulate(float dt, PassList& list) { return impl_->simulate(dt, list); }
Result<void> Scene::draw(const View& view, const Light& light, PassList& list) {
  return impl_->draw(view, light, list);
}
Result<void> Scene::draw(const View& view, std::span<const Light> lights,
                         const TransparencySettings& settings, std::vector<PassList>& lists) {
  return impl_->draw(view, lights, settings, lists);
}
Result<void> Scene::drawDepth(const View& view, const HairDepthSettings& settings, PassList& list) {
  return impl_->drawDepth(view, settings, list);
}
Result<void> Scene::interpolate(float share, PassList& list) {
  return impl_->interpolate(share, list);
}
float Scene::shareForView(HairId id, const View& view, float pixels) const {
  return impl_->shareForView(id, view, pixels);
}
TransparencyWork Scene::predictWork(const View& view) const { return impl_->predictWork(view); }
Result<uint32_t> Scene::castShadows(std::span<const Light> lights, PassList& list) {
  return impl_->castShadows(lights, list);
}
void Scene::setTier(Tier tier) { impl_->setTier(tier); }
void Scene::setLevels(bool on) { impl_->setLevels(on); }
void Scene::setShadowMemory(uint64_t maxBytes) { impl_->setShadowMemory(maxBytes); }
BufferId Scene::shadowWords() const { return impl_->shadowWords(); }
BufferId Scene::shadowViews() const { return impl_->shadowViews(); }
BufferId Scene::transparencyCounters() const { return impl_->transparencyCounters(); }
TransparencyTiles Scene::transparencyTiles() const { return impl_->transparencyTiles(); }
Result<void> Scene::drawCollider(ColliderId id, const View& view, const Light& light,
                                 const ColliderLook& look, PassList& list) {
  return impl_->drawCollider(id, view, light, look, list);
}
Result<void> Scene::checkColliderDraw(ColliderId id, std::span<const std::byte> counts) const {
  return impl_->checkColliderDraw(id, counts);
}
Result<void> Scene::drawContacts(HairId id, const View& view, const ContactLook& look,
                                 PassList& list) {
  return impl_->drawContacts(id, view, look, list);
}
Result<float> Scene::deepestContact(HairId id, std::span<const std::byte> contacts,
                                    std::span<const std::byte> contactWords,
                                    std::span<const std::byte> positions) const {
  return impl_->deepestContact(id, contacts, contactWords, positions);
}
void Scene::finish(PassList& list) { impl_->finish(list); }
void Scene::abandon(const PassList& list) { impl_->abandon(list); }
Result<void> Scene::shiftOrigin(Float3 shift) { return impl_->shiftOrigin(shift); }
Result<void> Scene::teleport(HairId id, const AffineTransform& motion) {
  return impl_->teleport(id, motion);
}
double Scene::time() const { return impl_->time(); }

}  // namespace pelage
