#include "pelage/scene.h"

#include <utility>

#include "scene/scene_parts.h"

namespace pelage {

Scene::Scene() : parts_(std::make_shared<detail::SceneParts>()) {}
Scene::~Scene() = default;
Scene::Scene(Scene&& other) noexcept
    : parts_(std::exchange(other.parts_, std::make_shared<detail::SceneParts>())) {}
Scene& Scene::operator=(Scene&& other) noexcept {
  parts_ = std::exchange(other.parts_, std::make_shared<detail::SceneParts>());
  return *this;
}

Result<HairId> Scene::addHair(const HairAsset& asset, const HairDef& def) {
  return addHair(std::make_shared<const HairAsset>(asset), def);
}
Result<HairId> Scene::addHair(std::shared_ptr<const HairAsset> asset, const HairDef& def) {
  return parts_->store.addHair(std::move(asset), def);
}
HairObject& Scene::hair(HairId id) { return parts_->store.hair(id); }
const HairObject& Scene::hair(HairId id) const { return parts_->store.hair(id); }
bool Scene::isValid(HairId id) const { return parts_->store.hairSlots.find(id) != nullptr; }
bool Scene::isValid(ColliderId id) const {
  return parts_->store.sdfs.colliders.find(id) != nullptr;
}
bool Scene::isValid(SkeletonId id) const { return parts_->store.skeletonSlots.find(id) != nullptr; }
SdfCollider& Scene::collider(ColliderId id) { return parts_->store.collider(id); }
const SdfCollider& Scene::collider(ColliderId id) const { return parts_->store.collider(id); }
Result<SkeletonId> Scene::addSkeleton(const SkeletonDef& def) {
  return parts_->store.addSkeleton(def);
}
SkeletonPose& Scene::skeleton(SkeletonId id) { return parts_->store.skeleton(id); }
const SkeletonPose& Scene::skeleton(SkeletonId id) const { return parts_->store.skeleton(id); }
BufferId Scene::sdfKeys() const { return parts_->store.sdfs.keys; }
BufferId Scene::sdfSurface() const { return parts_->store.sdfs.surface; }
ResourceTable& Scene::resources() { return parts_->store.resources; }
const ResourceTable& Scene::resources() const { return parts_->store.resources; }
double Scene::time() const { return parts_->store.time; }
void Scene::setLevels(bool on) { parts_->store.hazards.setLevels(on); }

void Scene::trim() {
  parts_->journal.commit();
  parts_->journal.collectShared();
  parts_->drawing.spareFrames.clear();
  parts_->drawing.trim("Scene::trim() freed its buffers; write it again");
  parts_->store.sdfs.trim(parts_->store.factory());
}

// Frames.
Result<void> Scene::simulate(float dt, PassList& list) {
  return parts_->simulation.simulate(dt, list);
}
Result<void> Scene::interpolate(float share, PassList& list) {
  return parts_->simulation.interpolate(share, list);
}
void Scene::finish(PassList& list) { parts_->journal.finish(list); }
void Scene::abandon(const PassList& list) { parts_->journal.abandon(list); }

// Drawing.
Result<void> Scene::draw(const View& view, const Light& light, PassList& list) {
  return parts_->drawing.draw(view, light, list);
}
Result<void> Scene::draw(const View& view, std::span<const Light> lights,
                         const TransparencySettings& settings, std::vector<PassList>& lists) {
  return parts_->drawing.draw(view, lights, settings, lists);
}
Result<void> Scene::drawDepth(const View& view, const HairDepthSettings& settings, PassList& list) {
  return parts_->drawing.drawDepth(view, settings, list);
}
Result<uint32_t> Scene::castShadows(std::span<const Light> lights, PassList& list) {
  return parts_->drawing.castShadows(lights, list);
}
Result<void> Scene::drawCollider(ColliderId id, const View& view, const Light& light,
                                 const ColliderLook& look, PassList& list) {
  return parts_->drawing.drawCollider(id, view, light, look, list);
}
Result<void> Scene::drawContacts(HairId id, const View& view, const ContactLook& look,
                                 PassList& list) {
  return parts_->drawing.drawContacts(id, view, look, list);
}
TransparencyWork Scene::predictWork(const View& view) const {
  return parts_->drawing.predictWork(view);
}
DrawBytes Scene::drawBytes() const {
  const detail::ViewDrawing& drawing = parts_->drawing;
  return {drawing.oit.bytes(resources()), drawing.shadows.bytes(resources())};
}
void Scene::setTier(Tier tier) { parts_->drawing.tier = tier; }
void Scene::setShadowMemory(uint64_t maxBytes) { parts_->drawing.shadows.setMaxBytes(maxBytes); }
BufferId Scene::shadowWords() const { return parts_->drawing.shadows.words(); }
BufferId Scene::shadowViews() const { return parts_->drawing.shadows.views(); }
BufferId Scene::transparencyCounters() const { return parts_->drawing.oit.counters(); }
TransparencyTiles Scene::transparencyTiles() const { return parts_->drawing.oit.tiles(); }

}  // namespace pelage
