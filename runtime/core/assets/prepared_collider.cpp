#include "assets/prepared_collider.h"

#include <memory>
#include <span>

#include "base/guard.h"
#include "base/hash.h"

namespace pelage {
namespace detail {
namespace {

uint64_t positionsHashOf(const CollisionMesh& mesh) {
  return hash64(std::as_bytes(std::span(mesh.positions)));
}
uint64_t indicesHashOf(const CollisionMesh& mesh) {
  return hash64(std::as_bytes(std::span(mesh.indices)));
}

}  // namespace

bool isPrepared(const CollisionMesh& mesh) {
  return mesh.prepared != nullptr && mesh.prepared->positionsHash == positionsHashOf(mesh) &&
         mesh.prepared->indicesHash == indicesHashOf(mesh);
}

Result<ColliderTopology> topologyOf(const CollisionMesh& mesh) {
  if (isPrepared(mesh)) return mesh.prepared->topology;
  return makeColliderTopology(mesh.indices, static_cast<uint32_t>(mesh.positions.size()),
                              mesh.positions);
}

}  // namespace detail

Result<void> prepareCollider(CollisionMesh& mesh) {
  return detail::guarded([&]() -> Result<void> {
    if (detail::isPrepared(mesh)) return {};
    auto topology = detail::topologyOf(mesh);
    if (!topology) return topology.error();
    mesh.prepared = std::make_shared<const detail::PreparedCollider>(detail::PreparedCollider{
        detail::positionsHashOf(mesh), detail::indicesHashOf(mesh), *std::move(topology)});
    return {};
  });
}

}  // namespace pelage
