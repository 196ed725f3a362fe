// The mesh of the ground that stage/stage.h declares.
#include <algorithm>
#include <utility>
#include <vector>

#include "pelage/collision_mesh.h"
#include "stage/stage.h"

namespace viewer {

using pelage::Result;

namespace {

constexpr int kCells = 24;           // along an edge
constexpr float kCellShare = 0.25f;  // of the width of all hair and meshes

// Returns squares of edge 1 around the origin. \param dark [vertex] 1 in every other square.
pelage::CollisionMesh squares(std::vector<float>& dark) {
  pelage::CollisionMesh mesh;
  for (int row = 0; row < kCells; ++row) {
    for (int column = 0; column < kCells; ++column) {
      const auto first = static_cast<uint32_t>(mesh.positions.size());
      for (const auto& [right, front] : {std::pair(0, 0), {0, 1}, {1, 1}, {1, 0}}) {
        mesh.positions.push_back({static_cast<float>(column + right) - kCells / 2, 0,
                                  static_cast<float>(row + front) - kCells / 2});
        mesh.normals.push_back({0, 1, 0});
        mesh.influences.emplace_back();
        dark.push_back(static_cast<float>((row + column) % 2));
      }
      for (const uint32_t corner : {0, 1, 2, 0, 2, 3}) mesh.indices.push_back(first + corner);
    }
  }
  return mesh;
}

}  // namespace

Result<void> GroundMesh::draw(const sample::DemoScene& demo, const pelage::View& view,
                              pelage::ResourceTable& resources, pelage::PassList& list) {
  if (!mesh_) {
    std::vector<float> dark;
    const pelage::CollisionMesh mesh = squares(dark);
    auto made = sample::MeshObject::create(resources, mesh, {.name = "ground", .scalp = dark});
    if (!made) return made.error();
    mesh_.emplace(*std::move(made));
    mesh_->material.skin = {0.22f, 0.22f, 0.23f};
    mesh_->material.scalp = {0.15f, 0.15f, 0.16f};
  }
  const sample::DemoScene::Extent extent = demo.extent();
  const float cell =
      kCellShare * std::max(extent.high.x - extent.low.x, extent.high.z - extent.low.z);
  pelage::AffineTransform place;
  place.rows[0] = {cell, 0, 0, (extent.low.x + extent.high.x) / 2};
  place.rows[1] = {0, cell, 0, extent.low.y};
  place.rows[2] = {0, 0, cell, (extent.low.z + extent.high.z) / 2};
  mesh_->setBones({&place, 1});
  const auto shadows = demo.hairShadowMaps();
  return mesh_->draw(view, demo.light, list, shadows ? &*shadows : nullptr);
}

}  // namespace viewer
