// A head as a smooth blend of simple bodies, and its mesh.
#include "head.h"

#include <fmt/format.h>

#include <array>
#include <cstdint>
#include <limits>

#include "guard.h"
#include "pelage/groom.h"
#include "portable_math.h"

namespace pelage {
namespace detail {
namespace {

// Distances and smooth blends after I. Quilez, "Distance functions" and "Smooth minimum" (2013).
double sphere(const Vector& p, const Vector& center, double radius) {
  return length(p - center) - radius;
}

double ellipsoid(const Vector& p, const Vector& center, const Vector& radii) {
  const Vector q = p - center;
  const double k0 = length(Vector{q.x / radii.x, q.y / radii.y, q.z / radii.z});
  const double k1 = length(
      Vector{q.x / (radii.x * radii.x), q.y / (radii.y * radii.y), q.z / (radii.z * radii.z)});
  // At the centre both are 0; the nearest point is on the shortest axis.
  return k1 > 1e-9 ? k0 * (k0 - 1) / k1 : -std::min({radii.x, radii.y, radii.z});
}

// A capsule whose radius changes from a to b.
double taperedCapsule(const Vector& p, const Vector& a, const Vector& b, double radiusA,
                      double radiusB) {
  const Vector axis = b - a;
  const double t = saturate(dot(p - a, axis) / dot(axis, axis));
  return length(p - (a + axis * t)) - (radiusA + (radiusB - radiusA) * t);
}

double smoothUnion(double a, double b, double width) {
  const double h = std::max(width - std::abs(a - b), 0.0) / width;
  return std::min(a, b) - h * h * width / 4;
}

double smoothCut(double body, double hole, double width) {
  return -smoothUnion(-body, hole, width);
}

double ear(const Vector& p) {
  // Leans back and stands off the head a little.
  const Vector q = p - Vector{0.0745, 0.2055, -0.016};
  const Vector leaned = {q.x - 0.25 * q.y + 0.30 * q.z, q.y + 0.22 * q.z, q.z - 0.22 * q.y};
  const double shell = ellipsoid(leaned, {0, 0, 0}, {0.0085, 0.0315, 0.0185});
  const double bowl = ellipsoid(leaned, {0.0085, 0.004, 0.002}, {0.0065, 0.0195, 0.0105});
  return smoothCut(shell, bowl, 0.004);
}

enum class Ears { kNone, kReal, kSmoothed };

double surface(const Vector& point, Ears ears) {
  const Vector p = {std::abs(point.x), point.y, point.z};  // left and right are alike

  double d = ellipsoid(p, {0, 0.2480, -0.0130}, {0.0755, 0.0830, 0.0980});  // cranium
  const auto add = [&](double part, double width) { d = smoothUnion(d, part, width); };
  const auto carve = [&](double part, double width) { d = smoothCut(d, part, width); };
  // Forehead, face, jaw with its line to the ear, chin, cheeks.
  add(ellipsoid(p, {0, 0.2600, 0.0200}, {0.0640, 0.0560, 0.0620}), 0.030);
  add(ellipsoid(p, {0, 0.1850, 0.0260}, {0.0585, 0.0720, 0.0600}), 0.030);
  add(ellipsoid(p, {0, 0.1400, 0.0400}, {0.0430, 0.0340, 0.0420}), 0.020);
  add(taperedCapsule(p, {0.054, 0.165, -0.004}, {0.020, 0.118, 0.062}, 0.0100, 0.0120), 0.022);
  add(sphere(p, {0, 0.1160, 0.0750}, 0.0135), 0.022);
  add(sphere(p, {0.0410, 0.1900, 0.0560}, 0.0165), 0.022);
  add(sphere(p, {0.0260, 0.1600, 0.0620}, 0.0180), 0.022);
  // Brow, socket, eye, lids.
  add(taperedCapsule(p, {0.008, 0.2290, 0.0790}, {0.038, 0.2330, 0.0680}, 0.0085, 0.0075), 0.014);
  carve(ellipsoid(p, {0.0310, 0.2135, 0.0960}, {0.0185, 0.0115, 0.0215}), 0.014);
  add(sphere(p, {0.0305, 0.2120, 0.0680}, 0.0135), 0.003);
  add(taperedCapsule(p, {0.0180, 0.2165, 0.0800}, {0.0300, 0.2190, 0.0800}, 0.0022, 0.0028), 0.004);
  add(taperedCapsule(p, {0.0300, 0.2190, 0.0800}, {0.0440, 0.2150, 0.0720}, 0.0028, 0.0022), 0.004);
  // Nose: bridge, tip, wings.
  add(taperedCapsule(p, {0, 0.2260, 0.0800}, {0, 0.1900, 0.0970}, 0.0070, 0.0090), 0.014);
  add(sphere(p, {0, 0.1860, 0.1000}, 0.0105), 0.010);
  add(sphere(p, {0.0105, 0.1835, 0.0900}, 0.0080), 0.008);
  // Mouth: mound, upper and lower lip, the line between.
  add(ellipsoid(p, {0, 0.1500, 0.0770}, {0.0280, 0.0190, 0.0160}), 0.014);
  add(taperedCapsule(p, {0, 0.1560, 0.0915}, {0.0210, 0.1520, 0.0815}, 0.0052, 0.0024), 0.006);
  add(taperedCapsule(p, {0, 0.1455, 0.0905}, {0.0180, 0.1490, 0.0815}, 0.0062, 0.0026), 0.006);
  carve(taperedCapsule(p, {0, 0.1508, 0.1000}, {0.0240, 0.1508, 0.0880}, 0.0028, 0.0022), 0.007);
  if (ears == Ears::kReal) add(ear(p), 0.006);
  if (ears == Ears::kSmoothed) add(ear(p) - 0.003, 0.040);
  double neck = taperedCapsule(p, {0, -0.02, -0.034}, {0, 0.18, -0.020}, 0.0600, 0.0540);
  neck = smoothUnion(neck, ellipsoid(p, {0, -0.030, -0.040}, {0.105, 0.048, 0.075}), 0.05);
  add(neck, 0.024);
  return -smoothUnion(-d, p.y, 0.016);  // cut off at y = 0
}

// Differences along the four directions of a tetrahedron.
Vector gradient(const Vector& p, Ears ears) {
  constexpr double step = 1e-5;
  Vector sum;
  for (const Vector& k : {Vector{1, -1, -1}, Vector{-1, -1, 1}, Vector{-1, 1, -1}, Vector{1, 1, 1}})
    sum += k * surface(p + k * step, ears);
  return normalizeOr(sum, Vector{0, 1, 0});
}

}  // namespace

double headSurface(const Vector& p) { return surface(p, Ears::kReal); }
Vector headNormal(const Vector& p) { return gradient(p, Ears::kReal); }
Vector skullNormal(const Vector& p) { return gradient(p, Ears::kNone); }

double combedSurface(const Vector& p) { return surface(p, Ears::kSmoothed); }

Vector combedNormal(const Vector& p) { return gradient(p, Ears::kSmoothed); }

bool isScalp(const Vector& p, double hairline) {
  // Height of the hair's edge around the head, by the cosine of the angle from the face (1) over
  // the ear (0) to the neck (-1), seen from a vertical axis in the middle of the skull.
  struct Knot {
    double cosine, height;
  };
  constexpr std::array<Knot, 9> kEdge = {{{-1.00, 0.152},
                                          {-0.85, 0.157},
                                          {-0.55, 0.178},
                                          {-0.20, 0.232},
                                          {0.05, 0.240},
                                          {0.22, 0.226},
                                          {0.45, 0.240},
                                          {0.62, 0.272},
                                          {1.00, 0.286}}};
  constexpr double kEarClearance = 0.010;
  const double x = p.x, z = p.z + 0.010;
  const double radius = std::sqrt(x * x + z * z);
  const double cosine = radius > 1e-9 ? z / radius : 0;
  double height = kEdge.back().height;
  for (size_t i = 0; i + 1 < kEdge.size(); ++i) {
    if (cosine > kEdge[i + 1].cosine) continue;
    const double t = smoothStep(kEdge[i].cosine, kEdge[i + 1].cosine, cosine);
    height = kEdge[i].height + (kEdge[i + 1].height - kEdge[i].height) * t;
    break;
  }
  if (p.y < height + hairline) return false;
  return ear({std::abs(x), p.y, p.z}) > kEarClearance;
}

double headBoneShare(const Vector& p) {
  // The border rises from under the chin to the back of the neck.
  return smoothStep(0.050, 0.110, p.y + 0.5 * (p.z + 0.02));
}

}  // namespace detail

namespace {

using detail::Vector;

// Naive surface nets (Gibson 1998, "Constrained Elastic Surface Nets"): a vertex in each cell that
// the surface crosses, a quad around each grid edge that it crosses.
class SurfaceNet {
 public:
  explicit SurfaceNet(double cellSize) : cell_(cellSize) {
    const Vector size = kHigh - kLow;
    for (size_t axis = 0; axis < 3; ++axis) {
      const double extent = axis == 0 ? size.x : axis == 1 ? size.y : size.z;
      // The middle plane x = 0 is half-way between nodes, so that both halves are alike.
      count_[axis] = 2 * static_cast<size_t>(std::ceil(extent / (2 * cell_))) + 2;
    }
    origin_ = (kLow + kHigh) * 0.5 -
              Vector{node(count_[0] - 1), node(count_[1] - 1), node(count_[2] - 1)} * 0.5;
    sample();
    resolveAmbiguousFaces();
    makeVertices();
    makeTriangles();
  }

  std::vector<Vector> vertices;
  std::vector<uint32_t> indices;

 private:
  static constexpr Vector kLow = {-0.130, -0.010, -0.135}, kHigh = {0.130, 0.345, 0.130};
  static constexpr uint32_t kNone = std::numeric_limits<uint32_t>::max();

  double node(size_t i) const { return static_cast<double>(i) * cell_; }
  size_t at(size_t i, size_t j, size_t k) const { return (k * count_[1] + j) * count_[0] + i; }
  Vector point(size_t i, size_t j, size_t k) const {
    return origin_ + Vector{node(i), node(j), node(k)};
  }

  void sample() {
    values_.resize(count_[0] * count_[1] * count_[2]);
    for (size_t k = 0; k < count_[2]; ++k)
      for (size_t j = 0; j < count_[1]; ++j)
        for (size_t i = 0; i < count_[0]; ++i)
          values_[at(i, j, k)] = detail::headSurface(point(i, j, k));
  }

  // Where the signs at a face's corners alternate, four quads would meet in one edge. The outer
  // corner nearest to the surface goes inside, until there is no such face.
  void resolveAmbiguousFaces() {
    const size_t strides[3] = {1, count_[0], count_[0] * count_[1]};
    bool changed = true;
    while (changed) {
      changed = false;
      for (size_t k = 0; k + 1 < count_[2]; ++k)
        for (size_t j = 0; j + 1 < count_[1]; ++j)
          for (size_t i = 0; i + 1 < count_[0]; ++i)
            for (size_t axis = 0; axis < 3; ++axis)
              changed |= resolveFace(at(i, j, k), strides[axis], strides[(axis + 1) % 3]);
    }
  }

  bool resolveFace(size_t corner, size_t u, size_t v) {
    const size_t corners[4] = {corner, corner + u, corner + u + v, corner + v};
    for (size_t c = 0; c < 4; ++c)
      if ((values_[corners[c]] < 0) == (values_[corners[(c + 1) % 4]] < 0)) return false;
    // Always from outside to inside, so that this ends.
    const size_t first = values_[corners[0]] < 0 ? 1 : 0;
    const bool second = values_[corners[first + 2]] < values_[corners[first]];
    values_[corners[first + (second ? 2 : 0)]] = -1e-6 * cell_;
    return true;
  }

  void makeVertices() {
    cellVertex_.assign(values_.size(), kNone);
    for (size_t k = 0; k + 1 < count_[2]; ++k)
      for (size_t j = 0; j + 1 < count_[1]; ++j)
        for (size_t i = 0; i + 1 < count_[0]; ++i) makeVertex(i, j, k);
  }

  void makeVertex(size_t i, size_t j, size_t k) {
    Vector sum;
    int crossings = 0;
    for (size_t a = 0; a < 8; ++a) {
      for (size_t axis = 0; axis < 3; ++axis) {
        const size_t b = a | size_t{1} << axis;
        if (b == a) continue;
        const double va = values_[at(i + (a & 1), j + (a >> 1 & 1), k + (a >> 2))];
        const double vb = values_[at(i + (b & 1), j + (b >> 1 & 1), k + (b >> 2))];
        if ((va < 0) == (vb < 0)) continue;
        const Vector pa = point(i + (a & 1), j + (a >> 1 & 1), k + (a >> 2));
        const Vector pb = point(i + (b & 1), j + (b >> 1 & 1), k + (b >> 2));
        sum += lerp(pa, pb, va / (va - vb));
        ++crossings;
      }
    }
    if (crossings == 0) return;
    Vector p = sum * (1.0 / crossings);
    // The mean lies beside the surface where that is curved; walk to it, but not out of the cell.
    for (int step = 0; step < 4; ++step) {
      const double d = detail::headSurface(p);
      const double limit = 0.2 * cell_;
      p -= detail::headNormal(p) * std::min(std::max(d, -limit), limit);
    }
    cellVertex_[at(i, j, k)] = static_cast<uint32_t>(vertices.size());
    vertices.push_back(p);
  }

  void makeTriangles() {
    for (size_t k = 1; k + 1 < count_[2]; ++k)
      for (size_t j = 1; j + 1 < count_[1]; ++j)
        for (size_t i = 1; i + 1 < count_[0]; ++i) {
          const bool inside = values_[at(i, j, k)] < 0;
          // The four cells around the edge that leaves this node, in turn about the axis.
          if (inside != (values_[at(i + 1, j, k)] < 0))
            makeQuad(at(i, j - 1, k - 1), at(i, j, k - 1), at(i, j, k), at(i, j - 1, k), inside);
          if (inside != (values_[at(i, j + 1, k)] < 0))
            makeQuad(at(i - 1, j, k - 1), at(i - 1, j, k), at(i, j, k), at(i, j, k - 1), inside);
          if (inside != (values_[at(i, j, k + 1)] < 0))
            makeQuad(at(i - 1, j - 1, k), at(i, j - 1, k), at(i, j, k), at(i - 1, j, k), inside);
        }
  }

  void makeQuad(size_t a, size_t b, size_t c, size_t d, bool inside) {
    uint32_t quad[4] = {cellVertex_[a], cellVertex_[b], cellVertex_[c], cellVertex_[d]};
    if (!inside) std::swap(quad[1], quad[3]);
    const double ac = length(vertices[quad[0]] - vertices[quad[2]]);
    const double bd = length(vertices[quad[1]] - vertices[quad[3]]);
    const size_t first = ac <= bd ? 0 : 1;  // cut along the shorter diagonal
    for (const size_t corner : {size_t{0}, size_t{1}, size_t{2}, size_t{0}, size_t{2}, size_t{3}})
      indices.push_back(quad[(first + corner) % 4]);
  }

  double cell_;
  size_t count_[3] = {};
  Vector origin_;
  std::vector<double> values_;
  std::vector<uint32_t> cellVertex_;  // by the cell's lowest node
};

Float3 toFloat3(const Vector& v) {
  return {static_cast<float>(v.x), static_cast<float>(v.y), static_cast<float>(v.z)};
}

}  // namespace

float headDistance(const Float3& point) {
  return static_cast<float>(detail::headSurface({point.x, point.y, point.z}));
}

Skeleton headSkeleton() {
  const auto joint = [](const char* name, int32_t parent, const Float3& position) {
    return Bone{name, parent, rigidTransform(Quaternion{}, position)};
  };
  return {{joint("neck", -1, {0, 0.03f, -0.035f}), joint("head", 0, {0, 0.15f, -0.02f})}};
}

Result<CollisionMesh> generateHead(float cellSize) {
  return detail::guarded([&]() -> Result<CollisionMesh> {
    if (!(cellSize >= 0.002f && cellSize <= 0.007f))
      return Error{
          ErrorCode::kInvalidArgument,
          fmt::format("the head's cell size is {} m; it must be 0.002 to 0.007 m", cellSize)};
    const SurfaceNet net(cellSize);
    CollisionMesh mesh;
    mesh.bones = {{0, "neck"}, {1, "head"}};
    mesh.indices = net.indices;
    for (const Vector& p : net.vertices) {
      mesh.positions.push_back(toFloat3(p));
      mesh.normals.push_back(toFloat3(detail::headNormal(p)));
      const auto share = static_cast<float>(detail::headBoneShare(p));
      mesh.influences.push_back({{0, 1, 0, 0}, {1 - share, share, 0, 0}});
    }
    return mesh;
  });
}

}  // namespace pelage
