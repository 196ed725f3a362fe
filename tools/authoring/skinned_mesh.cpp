#include "pelage/authoring/skinned_mesh.h"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>
#include <limits>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "axes.h"
#include "common/errors.h"
#include "points.h"

namespace pelage {
namespace {

using detail::isCoordinate;
using tools::invalid;

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

Result<void> checkBones(std::span<const BoneName> bones) {
  std::vector<bool> seen(bones.size());
  for (const auto& [index, name] : bones) {
    if (index >= bones.size() || seen[index])
      return invalid(fmt::format("bone '{}' has the index {}; each of 0 to {} must occur once",
                                 name, index, bones.size() - 1));
    if (name.find('\0') != std::string::npos)
      return invalid(fmt::format("the name of bone {} is too long or has a NUL inside", index));
    seen[index] = true;
  }
  return {};
}

Result<void> checkInfluences(const SkinnedMesh& mesh, size_t vertex) {
  const auto& [bones, weights] = mesh.influences[vertex];
  for (int k = 0; k < 4; ++k) {
    if (bones[k] >= mesh.bones.size())
      return invalid(
          fmt::format("vertex {} follows bone {} of {}", vertex, bones[k], mesh.bones.size()));
    if (!(weights[k] >= 0 && weights[k] <= 1e6f))
      return invalid(
          fmt::format("vertex {} has the bone weight {}; it must be 0 to 1e6", vertex, weights[k]));
  }
  if (std::all_of(std::begin(weights), std::end(weights), [](float weight) { return weight == 0; }))
    return invalid(fmt::format("the bone weights of vertex {} are all zero", vertex));
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
  if (auto r = checkBones(mesh.bones); !r) return r;
  for (size_t v = 0; v < vertexCount; ++v) {
    if (const Float3& p = mesh.positions[v]; !isCoordinate(p))
      return invalid(fmt::format("mesh: vertex {} is at {} {} {}; coordinates must be within +-1e6",
                                 v, p.x, p.y, p.z));
    if (auto r = checkInfluences(mesh, v); !r) return r;
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
  return tools::guarded([&] { return prepare(mesh, def); });
}

Result<void> validate(const SkinnedMesh& mesh) {
  return tools::guarded([&] { return checkMesh(mesh); });
}

}  // namespace pelage
