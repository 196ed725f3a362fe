// Drawing of a collider's field, for debugging.
#include "pelage/scene.h"
#include "sdf/iso_surface.h"
#include "sdf/sdf_collider.h"

namespace pelage {

Result<void> Scene::drawCollider(ColliderId id, const View& view, const Light& light,
                                 const ColliderLook& look, PassList& list) {
  settleFrames(false);
  SdfCollider& drawn = collider(id);
  detail::SdfColliderInternals& c = *drawn.internals_;
  // Relative to the collider's own origin, where floats are fine.
  const SdfField field = detail::fieldOf(c, c.origin);
  const detail::GridSize nodes = {field.nodes.x, field.nodes.y, field.nodes.z};
  const BufferDesc* keys = resources_.find(sdfKeys_);
  if (keys == nullptr || nodes[0] == 0) return {};  // no frame has planned a grid yet
  if (!c.isoSurface || !c.isoSurface->hasRoomFor(nodes)) {
    removeIsoSurface(drawn);
    auto made = detail::IsoSurface::create(resources_, drawn.name(), nodes,
                                           detail::defaultIsoSurfaceCapacity(nodes));
    if (!made) return made.error();
    c.isoSurface = *made;
    drawn.buffers_.isoCounts = made->counts();
  }
  const auto keyCount = static_cast<uint32_t>(keys->size / sizeof(uint32_t));
  if (Result<void> added = c.isoSurface->addPasses(field, sdfKeys_, keyCount, look.isoLevel, list);
      !added)
    return added;
  detail::IsoSurface::Look surface;
  surface.color = look.color;
  surface.opacity = look.opacity;
  const Float3 origin = c.origin.world();
  surface.fieldToWorld.rows[0].w = origin.x;
  surface.fieldToWorld.rows[1].w = origin.y;
  surface.fieldToWorld.rows[2].w = origin.z;
  return c.isoSurface->addDraw(view, light, surface, list);
}

Result<void> Scene::checkColliderDraw(ColliderId id, std::span<const std::byte> counts) const {
  const detail::SdfColliderInternals& c = *collider(id).internals_;
  PELAGE_ASSERT(c.isoSurface.has_value(), "checkColliderDraw() of a collider that was not drawn");
  const auto size = c.isoSurface->checkCounts(counts);
  if (!size) return size.error();
  return {};
}

void Scene::removeIsoSurface(SdfCollider& collider) {
  detail::SdfColliderInternals& c = *collider.internals_;
  if (!c.isoSurface) return;
  for (BufferId buffer : c.isoSurface->buffers()) removeBuffer(buffer);
  c.isoSurface.reset();
  collider.buffers_.isoCounts = BufferId::kInvalid;
}

}  // namespace pelage
