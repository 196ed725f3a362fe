#include "reference/sdf/mesh_shapes.h"

#include <cmath>
#include <limits>
#include <numbers>
#include <utility>

namespace pelage::reference {
namespace {

using std::numbers::pi;

Float3 point(double x, double y, double z) {
  return {static_cast<float>(x), static_cast<float>(y), static_cast<float>(z)};
}

void addTriangle(TriangleMesh& mesh, uint32_t a, uint32_t b, uint32_t c) {
  mesh.indices.insert(mesh.indices.end(), {a, b, c});
}

void addQuad(TriangleMesh& mesh, uint32_t a, uint32_t b, uint32_t c, uint32_t d) {
  addTriangle(mesh, a, b, c);
  addTriangle(mesh, a, c, d);
}

// Poles on the z axis, `shape` gives the point of the polar angle and the azimuth.
template <class Shape>
TriangleMesh sphereLike(uint32_t rings, uint32_t segments, const Shape& shape) {
  TriangleMesh mesh;
  mesh.positions.push_back(shape(0, 0));
  for (uint32_t ring = 1; ring < rings; ++ring)
    for (uint32_t segment = 0; segment < segments; ++segment)
      mesh.positions.push_back(shape(pi * ring / rings, 2 * pi * segment / segments));
  mesh.positions.push_back(shape(pi, 0));
  const auto last = static_cast<uint32_t>(mesh.positions.size() - 1);
  const auto at = [&](uint32_t ring, uint32_t segment) {
    return 1 + (ring - 1) * segments + segment % segments;
  };
  for (uint32_t s = 0; s < segments; ++s) addTriangle(mesh, 0, at(1, s), at(1, s + 1));
  for (uint32_t r = 1; r + 1 < rings; ++r)
    for (uint32_t s = 0; s < segments; ++s)
      addQuad(mesh, at(r, s), at(r + 1, s), at(r + 1, s + 1), at(r, s + 1));
  for (uint32_t s = 0; s < segments; ++s)
    addTriangle(mesh, last, at(rings - 1, s + 1), at(rings - 1, s));
  return mesh;
}

}  // namespace

TriangleMesh sphere(float radius, uint32_t rings, uint32_t segments, Float3 centre) {
  return sphereLike(rings, segments, [&](double polar, double azimuth) {
    return point(centre.x + radius * std::sin(polar) * std::cos(azimuth),
                 centre.y + radius * std::sin(polar) * std::sin(azimuth),
                 centre.z + radius * std::cos(polar));
  });
}

TriangleMesh torus(float majorRadius, float minorRadius, uint32_t around, uint32_t across) {
  TriangleMesh mesh;
  for (uint32_t i = 0; i < around; ++i)
    for (uint32_t k = 0; k < across; ++k) {
      const double u = 2 * pi * i / around, v = 2 * pi * k / across;
      const double r = majorRadius + minorRadius * std::cos(v);
      mesh.positions.push_back(point(r * std::cos(u), r * std::sin(u), minorRadius * std::sin(v)));
    }
  const auto at = [&](uint32_t i, uint32_t k) { return (i % around) * across + k % across; };
  for (uint32_t i = 0; i < around; ++i)
    for (uint32_t k = 0; k < across; ++k)
      addQuad(mesh, at(i, k), at(i + 1, k), at(i + 1, k + 1), at(i, k + 1));
  return mesh;
}

TriangleMesh box(Float3 lowest, Float3 highest) {
  TriangleMesh mesh;
  for (uint32_t i = 0; i < 8; ++i)
    mesh.positions.push_back({(i & 1) != 0 ? highest.x : lowest.x,
                              (i & 2) != 0 ? highest.y : lowest.y,
                              (i & 4) != 0 ? highest.z : lowest.z});
  addQuad(mesh, 0, 2, 3, 1);
  addQuad(mesh, 4, 5, 7, 6);
  addQuad(mesh, 0, 1, 5, 4);
  addQuad(mesh, 2, 6, 7, 3);
  addQuad(mesh, 0, 4, 6, 2);
  addQuad(mesh, 1, 3, 7, 5);
  return mesh;
}

TriangleMesh cube(float edge) {
  return box({-edge / 2, -edge / 2, -edge / 2}, {edge / 2, edge / 2, edge / 2});
}

TriangleMesh plate(float width, float thickness, uint32_t cells, float angle) {
  TriangleMesh mesh;
  const uint32_t row = cells + 1, side = row * row;
  for (const double z : {-0.5, 0.5})
    for (uint32_t y = 0; y < row; ++y)
      for (uint32_t x = 0; x < row; ++x)
        mesh.positions.push_back(point(width * (double(x) / cells - 0.5),
                                       width * (double(y) / cells - 0.5), thickness * z));
  const auto at = [&](uint32_t top, uint32_t x, uint32_t y) { return top * side + y * row + x; };
  for (uint32_t y = 0; y < cells; ++y)
    for (uint32_t x = 0; x < cells; ++x) {
      addQuad(mesh, at(0, x, y), at(0, x, y + 1), at(0, x + 1, y + 1), at(0, x + 1, y));
      addQuad(mesh, at(1, x, y), at(1, x + 1, y), at(1, x + 1, y + 1), at(1, x, y + 1));
    }
  for (uint32_t i = 0; i < cells; ++i) {
    addQuad(mesh, at(0, i, 0), at(0, i + 1, 0), at(1, i + 1, 0), at(1, i, 0));
    addQuad(mesh, at(0, i + 1, cells), at(0, i, cells), at(1, i, cells), at(1, i + 1, cells));
    addQuad(mesh, at(0, 0, i + 1), at(0, 0, i), at(1, 0, i), at(1, 0, i + 1));
    addQuad(mesh, at(0, cells, i), at(0, cells, i + 1), at(1, cells, i + 1), at(1, cells, i));
  }
  return angle == 0 ? mesh : rotated(std::move(mesh), {1, 2, 3}, angle);
}

TriangleMesh sphereWithHoles(float radius, uint32_t rings, uint32_t segments, uint32_t period) {
  TriangleMesh whole = sphere(radius, rings, segments);
  TriangleMesh mesh;
  mesh.positions = std::move(whole.positions);
  for (uint32_t t = 0; t < whole.indices.size() / 3; ++t)
    if (t % period != period / 2)
      addTriangle(mesh, whole.indices[t * 3], whole.indices[t * 3 + 1], whole.indices[t * 3 + 2]);
  return mesh;
}

TriangleMesh overlappingSpheres(float radius, float distance, uint32_t rings, uint32_t segments) {
  return joined(sphere(radius, rings, segments, {-distance / 2, 0, 0}),
                sphere(radius, rings, segments, {distance / 2, 0, 0}));
}

TriangleMesh blob(uint32_t rings, uint32_t segments) {
  return sphereLike(rings, segments, [&](double polar, double azimuth) {
    const double x = std::sin(polar) * std::cos(azimuth), y = std::sin(polar) * std::sin(azimuth);
    const double z = std::cos(polar);
    const double r = 1 + 0.12 * std::sin(5 * x + 1) + 0.09 * std::cos(7 * y - 2 * z);
    return point(0.9 * r * x, 0.65 * r * y, 0.45 * r * z);
  });
}

TriangleMesh joined(const TriangleMesh& a, const TriangleMesh& b) {
  TriangleMesh mesh = a;
  mesh.positions.insert(mesh.positions.end(), b.positions.begin(), b.positions.end());
  for (const uint32_t index : b.indices)
    mesh.indices.push_back(index + static_cast<uint32_t>(a.positions.size()));
  return mesh;
}

TriangleMesh moved(TriangleMesh mesh, Float3 offset) {
  for (Float3& p : mesh.positions) p = {p.x + offset.x, p.y + offset.y, p.z + offset.z};
  return mesh;
}

TriangleMesh scaled(TriangleMesh mesh, float factor) {
  for (Float3& p : mesh.positions) p = {p.x * factor, p.y * factor, p.z * factor};
  return mesh;
}

// Rodrigues' formula.
TriangleMesh rotated(TriangleMesh mesh, Float3 axis, float angle) {
  const double length =
      std::sqrt(double(axis.x) * axis.x + double(axis.y) * axis.y + double(axis.z) * axis.z);
  const double x = axis.x / length, y = axis.y / length, z = axis.z / length;
  const double c = std::cos(angle), s = std::sin(angle);
  for (Float3& p : mesh.positions) {
    const double along = (x * p.x + y * p.y + z * p.z) * (1 - c);
    p = point(c * p.x + s * (y * p.z - z * p.y) + along * x,
              c * p.y + s * (z * p.x - x * p.z) + along * y,
              c * p.z + s * (x * p.y - y * p.x) + along * z);
  }
  return mesh;
}

TriangleMesh mirroredMesh(TriangleMesh mesh) {
  for (size_t t = 0; t < mesh.indices.size(); t += 3)
    std::swap(mesh.indices[t + 1], mesh.indices[t + 2]);
  return mesh;
}

TriangleMesh unwelded(const TriangleMesh& mesh) {
  TriangleMesh result;
  for (const uint32_t index : mesh.indices) {
    result.indices.push_back(static_cast<uint32_t>(result.positions.size()));
    result.positions.push_back(mesh.positions[index]);
  }
  return result;
}

TriangleMesh withDuplicates(TriangleMesh mesh, uint32_t period) {
  const uint32_t count = mesh.triangleCount();
  for (uint32_t t = 0; t < count; t += period) {
    const uint32_t a = mesh.indices[t * 3], b = mesh.indices[t * 3 + 1];
    addTriangle(mesh, b, mesh.indices[t * 3 + 2], a);
  }
  return mesh;
}

TriangleMesh withZeroArea(TriangleMesh mesh, uint32_t period) {
  const uint32_t count = mesh.triangleCount();
  for (uint32_t t = 0; t < count; t += period) {
    const uint32_t a = mesh.indices[t * 3], b = mesh.indices[t * 3 + 1];
    const Float3 p = mesh.positions[a];
    const auto extra = static_cast<uint32_t>(mesh.positions.size());
    mesh.positions.push_back({p.x + 0.5f, p.y, p.z});
    mesh.positions.push_back({p.x + 0.25f, p.y, p.z});
    addTriangle(mesh, a, a, a);
    addTriangle(mesh, a, b, a);
    addTriangle(mesh, a, extra, extra + 1);
  }
  return mesh;
}

TriangleMesh withNaN(TriangleMesh mesh) {
  const auto extra = static_cast<uint32_t>(mesh.positions.size());
  const float nan = std::numeric_limits<float>::quiet_NaN();
  mesh.positions.push_back({nan, 0, 0});
  mesh.positions.push_back({0, std::numeric_limits<float>::infinity(), 0});
  addTriangle(mesh, mesh.indices.empty() ? extra : mesh.indices[0], extra, extra + 1);
  return mesh;
}

}  // namespace pelage::reference
