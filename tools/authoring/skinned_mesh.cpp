#include "pelage/authoring/skinned_mesh.h"

#include <fmt/format.h>

#include <limits>
#include <string>
#include <utility>

#include "assets/bone_influences.h"
#include "axes.h"
#include "base/errors.h"
#include "base/guard.h"
#include "points.h"

namespace pelage {
namespace {

using detail::invalid;
using detail::isCoordinate;

Result<void> checkPart(const SkinnedMesh& mesh, const SkinnedMeshPart& part) {
  for (uint64_t t = part.firstTriangle; t < uint64_t{part.firstTriangle} + part.triangleCount; ++t)
    for (size_t k = 0; k < 3; ++k)
      if (const uint32_t v = mesh.indices[t * 3 + k];
          v < part.firstVertex || v - part.firstVertex >= part.vertexCount)
        return invalid(
            fmt::format("mesh: triangle {} of part '{}' refers to vertex {}; the part has {} to {}",
                        t - part.firstTriangle, part.name, v, part.firstVertex,
                        uint64_t{part.firstVertex} + part.vertexCount));
  return {};
}

Result<void> checkMesh(const SkinnedMesh& mesh) {
  const size_t vertexCount = mesh.positions.size();
  if (mesh.parts.empty() || mesh.bones.empty() || vertexCount == 0 || mesh.indices.empty())
    return invalid("mesh: it needs parts, bones, vertices and triangles");
  if (mesh.normals.size() != vertexCount || mesh.influences.size() != vertexCount)
    return invalid(fmt::format("mesh: {} positions, {} normals and {} influences", vertexCount,
                               mesh.normals.size(), mesh.influences.size()));
  if (mesh.indices.size() % 3 != 0 ||
      mesh.indices.size() / 3 > std::numeric_limits<uint32_t>::max() / 3)
    return invalid(fmt::format("mesh: {} indices are no triangles", mesh.indices.size()));
  uint64_t vertex = 0, triangle = 0;
  for (const SkinnedMeshPart& part : mesh.parts) {
    if (part.firstVertex != vertex || part.firstTriangle != triangle)
      return invalid(
          fmt::format("mesh: part '{}' starts at vertex {} and triangle {}, not {} and {}",
                      part.name, part.firstVertex, part.firstTriangle, vertex, triangle));
    vertex += part.vertexCount;
    triangle += part.triangleCount;
  }
  if (vertex != vertexCount || triangle != mesh.triangleCount())
    return invalid(fmt::format("mesh: the parts have {} of {} vertices and {} of {} triangles",
                               vertex, vertexCount, triangle, mesh.triangleCount()));
  for (const SkinnedMeshPart& part : mesh.parts)
    if (auto r = checkPart(mesh, part); !r) return r;
  if (auto r = detail::checkBoneNames(mesh.bones, std::numeric_limits<size_t>::max()); !r) return r;
  for (size_t v = 0; v < vertexCount; ++v) {
    if (const Float3& p = mesh.positions[v]; !isCoordinate(p))
      return invalid(fmt::format("mesh: vertex {} is at {} {} {}; coordinates must be within +-1e6",
                                 v, p.x, p.y, p.z));
    if (auto r = detail::checkInfluences(mesh.influences[v], mesh.bones.size(), "vertex", v); !r)
      return r;
  }
  return {};
}

Result<void> prepare(SkinnedMesh& mesh, const MeshImportDef& def) {
  if (!detail::isScale(def.scale))
    return invalid(fmt::format("mesh: the scale is {}; it must be 1e-9 to 1e9", def.scale));
  if (auto r = checkMesh(mesh); !r) return r;
  for (Float3& p : mesh.positions)
    p = detail::turned({p.x * def.scale, p.y * def.scale, p.z * def.scale}, def.upAxis,
                       def.invertZ);
  for (Float3& n : mesh.normals) n = detail::turned(n, def.upAxis, def.invertZ);
  if (def.invertZ)
    for (size_t i = 0; i < mesh.indices.size(); i += 3)
      std::swap(mesh.indices[i + 1], mesh.indices[i + 2]);
  return checkMesh(mesh);
}

}  // namespace

Result<void> prepareMesh(SkinnedMesh& mesh, const MeshImportDef& def) {
  return detail::guarded([&] { return prepare(mesh, def); });
}

Result<void> validate(const SkinnedMesh& mesh) {
  return detail::guarded([&] { return checkMesh(mesh); });
}

}  // namespace pelage
