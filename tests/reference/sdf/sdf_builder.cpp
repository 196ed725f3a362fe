#include "reference/sdf/sdf_builder.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <limits>
#include <map>
#include <tuple>
#include <utility>

namespace pelage::reference {
namespace {

constexpr uint32_t kNone = 0xffffffffu;    // kSdfNone
constexpr uint32_t kUnset = 0x7fffffffu;   // kSdfUnset
constexpr uint32_t kInside = 0x80000000u;  // kSdfInside
constexpr uint32_t kFar = 0x40000000u;     // kSdfFar
constexpr float kNowhere = 1e18f;          // kSdfNowhere

// Vertices of equal position are one.
std::vector<uint32_t> points(const std::vector<Float3>& positions) {
  std::map<std::tuple<float, float, float>, uint32_t> known;
  std::vector<uint32_t> point;
  for (const Float3& p : positions) {
    const auto next = static_cast<uint32_t>(known.size());
    point.push_back(known.emplace(std::tuple(p.x, p.y, p.z), next).first->second);
  }
  return point;
}

struct Surface {
  std::vector<std::array<uint32_t, 3>> neighbours;
  std::vector<std::array<Vector3d, 3>> normals;  // of the corners, angle-weighted
  std::vector<bool> usable;
};

Surface surfaceOf(const TriangleMesh& mesh) {
  const std::vector<uint32_t> point = points(mesh.positions);
  const uint32_t count = mesh.triangleCount();
  Surface surface{std::vector(count, std::array{kNone, kNone, kNone}),
                  std::vector<std::array<Vector3d, 3>>(count), std::vector<bool>(count)};
  std::map<std::pair<uint32_t, uint32_t>, std::pair<uint32_t, size_t>> edges;
  std::vector<Vector3d> sums(mesh.positions.size(), Vector3d::Zero());
  for (uint32_t t = 0; t < count; ++t) {
    std::array<Vector3d, 3> corner;
    for (size_t k = 0; k < 3; ++k) corner[k] = toDouble(mesh.positions[mesh.indices[3 * t + k]]);
    const Vector3d normal = (corner[1] - corner[0]).cross(corner[2] - corner[0]);
    surface.usable[t] = normal.allFinite() && normal.norm() > 0;
    if (!surface.usable[t]) continue;
    for (size_t k = 0; k < 3; ++k) {
      const uint32_t from = point[mesh.indices[3 * t + k]];
      edges.emplace(std::pair(from, point[mesh.indices[3 * t + (k + 1) % 3]]), std::pair(t, k));
      const Vector3d e = (corner[(k + 1) % 3] - corner[k]).normalized();
      const Vector3d f = (corner[(k + 2) % 3] - corner[k]).normalized();
      sums[from] += normal.normalized() * std::acos(std::clamp(e.dot(f), -1.0, 1.0));
    }
  }
  for (const auto& [edge, owner] : edges)
    if (const auto other = edges.find({edge.second, edge.first}); other != edges.end())
      surface.neighbours[owner.first][owner.second] = other->second.first;
  for (uint32_t t = 0; t < count; ++t)
    for (size_t k = 0; k < 3; ++k) surface.normals[t][k] = sums[point[mesh.indices[3 * t + k]]];
  return surface;
}

Uint4 record(const Vector3d& v, uint32_t w) {
  const Eigen::Vector3f f = v.cast<float>();
  return {std::bit_cast<uint32_t>(f.x()), std::bit_cast<uint32_t>(f.y()),
          std::bit_cast<uint32_t>(f.z()), w};
}

uint32_t codeOf(double distance, double range, uint32_t triangleBits) {
  const auto most = static_cast<double>((1u << (30 - triangleBits)) - 1);
  return static_cast<uint32_t>(std::clamp(distance / range * most + 0.5, 0.0, most))
         << triangleBits;
}

}  // namespace

uint32_t packDirection(const Vector3d& direction) {
  const Vector3d d = direction.norm() > 0 ? direction.normalized() : Vector3d(0, 0, 1);
  Eigen::Vector2d p = d.head<2>() / d.cwiseAbs().sum();
  if (d.z() < 0)
    p = Eigen::Vector2d(std::copysign(1 - std::abs(p.y()), p.x()),
                        std::copysign(1 - std::abs(p.x()), p.y()));
  const auto bits = [](double v) { return static_cast<uint32_t>((v + 1) * 32767 + 0.5); };
  return bits(p.x()) | bits(p.y()) << 16;
}

void addSdf(SdfBuffers& buffers, const TriangleMesh& mesh, const DistanceOracle& oracle,
            const FieldOptions& options) {
  Vector3d low = Vector3d::Constant(std::numeric_limits<double>::infinity()), high = -low;
  for (const Float3& p : mesh.positions) {
    if (!toDouble(p).allFinite()) continue;
    low = low.cwiseMin(toDouble(p));
    high = high.cwiseMax(toDouble(p));
  }
  if (!(low.x() <= high.x())) low = high = Vector3d::Zero();
  const double cell = static_cast<float>(options.cell);
  const Vector3d origin = ((low / cell).array() - options.padding).floor() * cell;
  const Eigen::Vector3f floatOrigin = origin.cast<float>();
  const Vector3d node0 = floatOrigin.cast<double>();
  uint32_t nodes[3];
  for (int axis = 0; axis < 3; ++axis)
    nodes[axis] =
        static_cast<uint32_t>(std::ceil((high[axis] - node0[axis]) / cell + options.padding) + 1);
  nodes[0] = (nodes[0] + 3) / 4 * 4;

  Sdf sdf = {};
  sdf.origin = {floatOrigin.x(), floatOrigin.y(), floatOrigin.z(), static_cast<float>(cell)};
  sdf.nodes = {nodes[0], nodes[1], nodes[2], static_cast<uint32_t>(buffers.keys.size())};
  sdf.triangleCount = mesh.triangleCount();
  sdf.triangleBits = static_cast<uint32_t>(std::bit_width(mesh.triangleCount()));
  sdf.surface = static_cast<uint32_t>(buffers.surface.size());
  sdf.surfaceStride = options.before != nullptr ? 7 : 4;
  sdf.band = static_cast<float>(options.band);
  sdf.margin = options.margin;
  sdf.friction = options.friction;
  sdf.motionScale = options.before != nullptr ? 1.0f : 0.0f;

  const std::vector<double> distances = oracle.gridDistances(node0, cell, nodes);
  double deepest = 0;
  for (const double d : distances) deepest = std::max(deepest, -d / cell);
  sdf.farRange = static_cast<float>(std::max(deepest - options.band, 1.0));
  size_t i = 0;
  for (uint32_t z = 0; z < nodes[2]; ++z)
    for (uint32_t y = 0; y < nodes[1]; ++y)
      for (uint32_t x = 0; x < nodes[0]; ++x, ++i) {
        const double distance = std::abs(distances[i]) / cell;
        const bool inside = distances[i] < 0;
        uint32_t key = kUnset;
        const uint32_t stride = options.band >= 2 ? 4 : 2;  // sdfCoarseStride()
        const bool coarse = x % stride == 0 && y % stride == 0 && z % stride == 0;
        const bool deep = inside && (options.allInside || (options.interior && coarse));
        if (distance <= options.band || deep) {
          const uint32_t triangle = oracle.closest(node0 + cell * Vector3d(x, y, z)).triangle;
          key = distance <= options.band
                    ? codeOf(distance, options.band, sdf.triangleBits) | triangle
                    : kFar | codeOf(distance - options.band, sdf.farRange, sdf.triangleBits) |
                          triangle;
        }
        buffers.keys.push_back(inside ? key | kInside : key);
      }

  const Surface surface = surfaceOf(mesh);
  for (uint32_t t = 0; t < sdf.triangleCount; ++t) {
    for (size_t k = 0; k < 3; ++k) {
      const Vector3d v = (toDouble(mesh.positions[mesh.indices[3 * t + k]]) - node0) / cell;
      buffers.surface.push_back(record(surface.usable[t] ? v : Vector3d::Constant(kNowhere),
                                       packDirection(surface.normals[t][k])));
    }
    const auto& [a, b, c] = surface.neighbours[t];
    buffers.surface.push_back({a, b, c, 0});
    for (size_t k = 0; k < 3 && options.before != nullptr; ++k) {
      const uint32_t vertex = mesh.indices[3 * t + k];
      buffers.surface.push_back(record(
          (toDouble(mesh.positions[vertex]) - toDouble((*options.before)[vertex])) / cell, 0));
    }
  }
  buffers.sdfs.push_back(sdf);
}

}  // namespace pelage::reference
