// Brows and lashes of the implicit head.
#include <algorithm>
#include <array>
#include <cstdint>
#include <numeric>
#include <vector>

#include "base/guard.h"
#include "base/portable_math.h"
#include "growth.h"
#include "head.h"
#include "pelage/demo/groom.h"
#include "pelage/random.h"

namespace pelage {
namespace {

using detail::smoothStep;
using detail::Vector;

constexpr uint32_t kBrowHairs = 190;  // of a side
constexpr uint32_t kLashes = 48;      // of a side
constexpr uint32_t kVertices = 7;

// The point of the face that is seen from the front at x and y.
Vector onFace(double x, double y) {
  Vector p = {x, y, 0.13};
  for (int step = 0; step < 64; ++step) p.z -= 0.8 * detail::headSurface(p);
  return p;
}

Vector tangent(const Vector& direction, const Vector& normal) {
  return normalizeOr(direction - normal * dot(direction, normal), Vector{1, 0, 0});
}

double between(Random& random, double low, double high) {
  return low + (high - low) * random.uniformDouble();
}

// Appends a hair of the left side, or its mirror image, that turns from one direction to another.
void addHair(HairAsset& hair, bool mirror, const Vector& root, const Vector& from, const Vector& to,
             double length) {
  const double step = length / (kVertices - 1);
  Vector p = root;
  for (uint32_t k = 0; k < kVertices; ++k) {
    const auto x = static_cast<float>(mirror ? -p.x : p.x);
    hair.positions.push_back(
        {x, static_cast<float>(p.y), static_cast<float>(p.z), k < 2 ? 0.0f : 1.0f});
    const double share = static_cast<double>(k) / (kVertices - 1);
    p += normalizeOr(detail::lerp(from, to, share), from) * step;
    const double inside = detail::kHairClearance - detail::headSurface(p);
    if (inside > 0) p += detail::headNormal(p) * inside;
  }
  ++hair.strandCount;
}

// From the bridge of the nose over an arch to the temple: hairs stand up where it begins, and lie
// along it where it ends.
void addBrowHair(HairAsset& hair, Random& random, bool mirror) {
  const double t = random.uniformDouble();
  const double width = 0.0042 * smoothStep(-0.35, 0.2, t) * (1 - 0.75 * t * t);
  const double arch = 0.2305 + 0.0065 * detail::sinCos(2.2 * t).sine - 0.0035 * t * t;
  const Vector root = onFace(0.0115 + 0.0335 * t, arch + width * between(random, -1, 1));
  const Vector normal = detail::headNormal(root);
  const double scatter = between(random, -0.25, 0.25);
  const Vector along = tangent({0.25 + 0.9 * t, 1.0 - 1.35 * t + scatter, 0}, normal);
  const double length = between(random, 0.006, 0.009) * (1 - 0.3 * t);
  addHair(hair, mirror, root, along + normal * 0.5, along + normal * 0.05, length);
}

// Along the upper lid, outwards and up.
void addLash(HairAsset& hair, Random& random, bool mirror, double t) {
  constexpr std::array<double, 3> kLid = {0.2150, 0.2172, 0.2135};  // height: corners and middle
  const double x = 0.0185 + 0.0245 * t;
  const double y = t < 0.5 ? kLid[0] + (kLid[1] - kLid[0]) * smoothStep(0, 0.5, t)
                           : kLid[1] + (kLid[2] - kLid[1]) * smoothStep(0.5, 1, t);
  const Vector root = onFace(x, y);
  const double out = 0.9 * (t - 0.4) + between(random, -0.12, 0.12);
  const Vector from = normalizeOr(Vector{out, -0.35, 1}, Vector{0, 0, 1});
  const Vector to = normalizeOr(Vector{1.2 * out, 1.1, 0.8}, Vector{0, 1, 0});
  const double length = between(random, 0.0055, 0.0075) * (0.7 + 0.3 * smoothStep(0, 0.5, t));
  addHair(hair, mirror, root, from, to, length);
}

}  // namespace

Result<HairAsset> generateFaceHair(uint64_t seed) {
  return detail::guarded([&]() -> Result<HairAsset> {
    HairAsset hair;
    hair.verticesPerStrand = kVertices;
    for (const bool mirror : {false, true}) {
      Random random(seed, mirror ? 1 : 0);
      for (uint32_t i = 0; i < kBrowHairs; ++i) addBrowHair(hair, random, mirror);
      for (uint32_t i = 0; i < kLashes; ++i)
        addLash(hair, random, mirror, (i + random.uniformDouble()) / kLashes);
    }
    // So that the first strands alone stand on both sides.
    std::vector<uint32_t> all(hair.strandCount);
    std::iota(all.begin(), all.end(), 0u);
    const std::vector<Float4> inOrder = hair.positions;
    auto to = hair.positions.begin();
    for (const uint32_t s : spreadOrder(all, hair.strandCount))
      to = std::copy_n(&inOrder[size_t{s} * kVertices], kVertices, to);
    return hair;
  });
}

}  // namespace pelage
