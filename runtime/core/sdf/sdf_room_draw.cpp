// Drawing of a collider's field, for debugging.
#include "pelage/assert.h"
#include "sdf/iso_surface.h"
#include "sdf/sdf_room.h"

namespace pelage::detail {

Result<void> SdfRoom::draw(ColliderId id, const View& view, const Light& light,
                           const ColliderLook& look, const BufferFactory& factory, PassList& list) {
  SdfCollider& drawn = *colliders.find(id);
  SdfColliderInternals& c = *drawn.internals_;
  // Relative to the collider's own origin, where floats are fine.
  const Sdf sdf = sdfOf(c, c.origin);
  const GridSize nodes = {sdf.nodes.x, sdf.nodes.y, sdf.nodes.z};
  const uint64_t keyBytes = factory.bytesOf(keys);
  if (keyBytes == 0 || nodes[0] == 0) return {};  // no frame has planned a grid yet
  if (!c.isoSurface || !c.isoSurface->hasRoomFor(nodes)) {
    removeIsoSurface(drawn, factory);
    auto made = IsoSurface::create(factory.resources, drawn.name(), nodes,
                                   defaultIsoSurfaceCapacity(nodes));
    if (!made) return made.error();
    c.isoSurface = *made;
    drawn.buffers_.isoCounts = made->counts();
  }
  const auto keyCount = static_cast<uint32_t>(keyBytes / sizeof(uint32_t));
  if (Result<void> added = c.isoSurface->addPasses(sdf, keys, keyCount, look.isoLevel, list);
      !added)
    return added;
  IsoSurface::Look isoLook;
  isoLook.color = look.color;
  isoLook.opacity = look.opacity;
  const Float3 origin = c.origin.world();
  isoLook.sdfToWorld.rows[0].w = origin.x;
  isoLook.sdfToWorld.rows[1].w = origin.y;
  isoLook.sdfToWorld.rows[2].w = origin.z;
  return c.isoSurface->addDraw(view, light, isoLook, list);
}

Result<void> SdfRoom::checkDraw(ColliderId id, std::span<const std::byte> counts) const {
  const SdfColliderInternals& c = *colliders.find(id)->internals_;
  PELAGE_ASSERT(c.isoSurface.has_value(), "checkColliderDraw() of a collider that was not drawn");
  const auto size = c.isoSurface->checkCounts(counts);
  if (!size) return size.error();
  return {};
}

void SdfRoom::removeIsoSurface(SdfCollider& collider, const BufferFactory& factory) {
  SdfColliderInternals& c = *collider.internals_;
  if (!c.isoSurface) return;
  for (BufferId buffer : c.isoSurface->buffers()) factory.remove(buffer);
  c.isoSurface.reset();
  collider.buffers_.isoCounts = BufferId::kInvalid;
}

}  // namespace pelage::detail
