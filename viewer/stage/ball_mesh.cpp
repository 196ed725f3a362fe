// The mesh of the ball that stage/stage.h declares.
#include <cmath>
#include <numbers>
#include <utility>

#include "pelage/collision_mesh.h"
#include "stage/stage.h"

namespace viewer {

using pelage::Result;

namespace {

constexpr uint32_t kColumns = 48, kRows = 24;

// Returns a sphere of radius 1 with its poles along y.
pelage::CollisionMesh unitSphere() {
  pelage::CollisionMesh mesh;
  for (uint32_t row = 0; row <= kRows; ++row) {
    for (uint32_t column = 0; column <= kColumns; ++column) {
      const float down = std::numbers::pi_v<float> * static_cast<float>(row) / kRows;
      const float around = 2 * std::numbers::pi_v<float> * static_cast<float>(column) / kColumns;
      const pelage::Float3 p = {std::sin(down) * std::sin(around), std::cos(down),
                                std::sin(down) * std::cos(around)};
      mesh.positions.push_back(p);
      mesh.normals.push_back(p);
      mesh.influences.emplace_back();
    }
  }
  for (uint32_t row = 0; row < kRows; ++row) {
    for (uint32_t column = 0; column < kColumns; ++column) {
      const uint32_t a = row * (kColumns + 1) + column, b = a + kColumns + 1;
      for (const uint32_t index : {a, b, a + 1, a + 1, b, b + 1}) mesh.indices.push_back(index);
    }
  }
  return mesh;
}

}  // namespace

Result<void> BallMesh::draw(const pelage::Float3& center, float radius, const pelage::View& view,
                            const pelage::Light& light, pelage::ResourceTable& resources,
                            pelage::PassList& list) {
  if (!mesh_) {
    auto made = sample::MeshObject::create(resources, unitSphere(), {.name = "ball"});
    if (!made) return made.error();
    mesh_.emplace(*std::move(made));
    mesh_->material.skin = {0.55f, 0.16f, 0.07f};
  }
  pelage::AffineTransform place;
  place.rows[0] = {radius, 0, 0, center.x};
  place.rows[1] = {0, radius, 0, center.y};
  place.rows[2] = {0, 0, radius, center.z};
  mesh_->setBones({&place, 1});
  return mesh_->draw(view, light, list);
}

}  // namespace viewer
