#include "sdf/sdf_shapes.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "pelage/collision_mesh.h"

namespace bench {

using pelage::Float3;
using pelage::Float4;
using pelage::Result;
namespace reference = pelage::reference;

namespace {

struct Corners {
  Float3 a, b, c;
};

Corners cornersOf(const reference::TriangleMesh& mesh, size_t triangle) {
  const auto at = [&](size_t k) { return mesh.positions[mesh.indices[triangle * 3 + k]]; };
  return {at(0), at(1), at(2)};
}

// Normal times twice the area.
Float3 areaNormal(const Corners& t) {
  const Float3 u = {t.b.x - t.a.x, t.b.y - t.a.y, t.b.z - t.a.z};
  const Float3 v = {t.c.x - t.a.x, t.c.y - t.a.y, t.c.z - t.a.z};
  return {u.y * v.z - u.z * v.y, u.z * v.x - u.x * v.z, u.x * v.y - u.y * v.x};
}

float length(const Float3& v) { return std::sqrt(v.x * v.x + v.y * v.y + v.z * v.z); }

}  // namespace

float cellSizeOf(const SdfShape& shape, uint32_t cells) {
  float low = shape.mesh.positions.front().x, high = low;
  for (const Float3& p : shape.mesh.positions) {
    low = std::min(low, p.x);
    high = std::max(high, p.x);
  }
  return (high - low) / static_cast<float>(cells);
}

std::vector<SdfShape> generatedShapes() {
  const std::vector<uint32_t> one = {50};
  return {{"sphere", reference::sphere(0.5f, 96, 128), {25, 50, 100}, true},
          {"torus", reference::torus(0.37f, 0.13f, 160, 64), one},
          {"plate_1.2", reference::plate(1, 0.024f, 40, 0.4f), one, true},
          {"plate_0.3", reference::plate(1, 0.006f, 40, 0.4f), one, true},
          {"cube", reference::rotated(reference::cube(1), {1, 2, 3}, 0.4f), one},
          {"holes", reference::sphereWithHoles(0.5f, 48, 64, 37), one},
          {"overlaps", reference::overlappingSpheres(0.3f, 0.4f, 48, 64), one}};
}

Result<std::vector<SdfShape>> realShapes(const std::filesystem::path& data) {
  const std::pair<const char*, SdfShape> all[] = {
      {"Ratboy_body.tfxmesh", {"body", {}, {25, 50, 100}, true}},
      {"Ratboy_left_hand.tfxmesh", {"left_hand", {}, {18, 36}}}};
  std::vector<SdfShape> shapes;
  for (const auto& [file, shape] : all) {
    const std::filesystem::path path = data / "ratboy" / file;
    if (!std::filesystem::exists(path)) {
      fmt::print("{}: skipped, there is no {}\n", shape.name, path.string());
      continue;
    }
    auto mesh = pelage::loadTfxMesh(path);
    if (!mesh) return mesh.error();
    shapes.push_back(shape);
    shapes.back().mesh = {std::move(mesh->positions), std::move(mesh->indices)};
  }
  return shapes;
}

std::vector<Float4> hairVertices(const SdfShape& shape, uint32_t count, float from, float to) {
  constexpr uint32_t kVertices = 32;
  const reference::TriangleMesh& mesh = shape.mesh;
  const uint32_t strands = count / kVertices;
  double whole = 0;
  for (size_t t = 0; t < mesh.triangleCount(); ++t)
    whole += static_cast<double>(length(areaNormal(cornersOf(mesh, t))));
  std::vector<Float4> vertices;
  vertices.reserve(size_t{strands} * kVertices);
  double area = 0;
  uint32_t made = 0;
  for (size_t t = 0; t < mesh.triangleCount(); ++t) {
    const Corners corners = cornersOf(mesh, t);
    const Float3 normal = areaNormal(corners);
    const float size = length(normal);
    area += static_cast<double>(size);
    for (; made < strands && (made + 0.5) * whole <= area * strands; ++made) {
      // Spread by the golden ratio and its square: low discrepancy without a generator.
      float u = std::fmod(static_cast<float>(made % 1024) * 0.618034f, 1.0f);
      float v = std::fmod(static_cast<float>(made % 1024) * 0.754878f, 1.0f);
      if (u + v > 1) u = 1 - u, v = 1 - v;
      const float w = 1 - u - v;
      for (uint32_t i = 0; i < kVertices; ++i) {
        const float off = (from + (to - from) * static_cast<float>(i) / (kVertices - 1)) / size;
        vertices.push_back({w * corners.a.x + u * corners.b.x + v * corners.c.x + normal.x * off,
                            w * corners.a.y + u * corners.b.y + v * corners.c.y + normal.y * off,
                            w * corners.a.z + u * corners.b.z + v * corners.c.z + normal.z * off,
                            1});
      }
    }
  }
  return vertices;
}

}  // namespace bench
