// A head as a smooth blend of simple bodies, and its mesh.
#include "head.h"

#include <fmt/format.h>

#include <array>
#include <cstdint>

#include "base/guard.h"
#include "base/portable_math.h"
#include "implicit_shapes.h"
#include "pelage/demo/groom.h"
#include "surface_net.h"

namespace pelage {
namespace detail {
namespace {

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

Vector gradient(const Vector& point, Ears ears) {
  return gradientOf(point, [ears](const Vector& p) { return surface(p, ears); });
}

// Height of the edge of the hair at a point of the surface [m].
double hairEdgeHeight(const Vector& p) {
  // By the cosine of the angle from the face (1) over the ear (0) to the neck (-1), seen from a
  // vertical axis in the middle of the skull.
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
  return height;
}

}  // namespace

double headSurface(const Vector& p) { return surface(p, Ears::kReal); }
Vector headNormal(const Vector& p) { return gradient(p, Ears::kReal); }
Vector skullNormal(const Vector& p) { return gradient(p, Ears::kNone); }

double combedSurface(const Vector& p) { return surface(p, Ears::kSmoothed); }

Vector combedNormal(const Vector& p) { return gradient(p, Ears::kSmoothed); }

bool isScalp(const Vector& p, double hairline) {
  constexpr double kEarClearance = 0.010;
  if (p.y < hairEdgeHeight(p) + hairline) return false;
  return ear({std::abs(p.x), p.y, p.z}) > kEarClearance;
}

double insideHairline(const Vector& p, double hairline) {
  const double behind = 1 - smoothStep(-0.04, 0.0, p.z);
  return p.y - hairEdgeHeight(p) - hairline + 0.1 * behind;
}

double headBoneShare(const Vector& p) {
  // The border rises from under the chin to the back of the neck.
  return smoothStep(0.050, 0.110, p.y + 0.5 * (p.z + 0.02));
}

}  // namespace detail

namespace {

using detail::Vector;

class Head : public detail::Solid {
 public:
  double distance(const Vector& p) const override { return detail::headSurface(p); }
  Vector normal(const Vector& p) const override { return detail::headNormal(p); }
};

constexpr detail::SolidBox kHeadBox = {{-0.130, -0.010, -0.135}, {0.130, 0.345, 0.130}};

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
    const detail::SurfaceMesh net = detail::meshSolid(Head(), kHeadBox, cellSize);
    CollisionMesh mesh;
    mesh.bones = {{0, "neck"}, {1, "head"}};
    mesh.indices = net.indices;
    for (const Vector& p : net.vertices) {
      mesh.positions.push_back(detail::toFloat3(p));
      mesh.normals.push_back(detail::toFloat3(detail::headNormal(p)));
      const auto share = static_cast<float>(detail::headBoneShare(p));
      mesh.influences.push_back({{0, 1, 0, 0}, {1 - share, share, 0, 0}});
    }
    return mesh;
  });
}

}  // namespace pelage
