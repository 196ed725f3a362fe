#include <algorithm>
#include <cmath>
#include <memory>
#include <string_view>

#include "obj_mesh.h"
#include "point_cache.h"
#include "targets.h"

namespace pelage::fuzz {
namespace {

constexpr float kMaxCoordinate = 1e6f;

bool isInRange(const std::vector<Float3>& positions) {
  return std::all_of(positions.begin(), positions.end(), [](const Float3& p) {
    return std::abs(p.x) <= kMaxCoordinate && std::abs(p.y) <= kMaxCoordinate &&
           std::abs(p.z) <= kMaxCoordinate;
  });
}

}  // namespace

Outcome pc2(std::span<const std::byte> bytes) {
  auto cache = bake::PointCache::open(std::make_unique<MemorySource>(bytes), kName);
  if (!cache) return refused(cache.error());
  for (const double frames : {0.0, -1.0, 0.5, 1.25, 1e6, 1e300}) {
    const auto positions = cache->positionsAt(frames);
    if (!positions) return refused(positions.error());
    if (positions->size() != cache->pointCount()) return broken("another number of points");
    if (!isInRange(*positions)) return broken("a point is out of range");
  }
  return {true, {}};
}

Outcome skinobj(std::span<const std::byte> bytes) {
  const std::string_view text(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  const auto mesh = bake::readObjMesh(text, kName);
  if (!mesh) return refused(mesh.error());
  if (!isInRange(mesh->positions)) return broken("a vertex is out of range");
  if (mesh->indices.empty() || mesh->indices.size() % 3 != 0) return broken("no triangles");
  for (const uint32_t index : mesh->indices)
    if (index >= mesh->positions.size()) return broken("a corner is no vertex");
  return {true, {}};
}

}  // namespace pelage::fuzz
