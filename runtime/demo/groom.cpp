// Hair grown on the implicit head.
#include "pelage/demo/groom.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <string>

#include "base/guard.h"
#include "base/portable_math.h"
#include "growth.h"
#include "head.h"
#include "pelage/random.h"

namespace pelage {
namespace {

using detail::HairGrower;
using detail::HairRoots;
using detail::Path;
using detail::saturate;
using detail::smoothStep;
using detail::Vector;

// Finding the locks takes time in proportion to strands times locks.
constexpr uint32_t kMaxClumpCount = 4096;

constexpr uint64_t kRootStream = 0;

// Where hair at a point is combed to; a unit vector along the head's surface.
Vector combDirection(const Vector& p, const Vector& normal, HairStyle style) {
  Vector flow;
  if (style == HairStyle::kSideParting) {
    // Away from the parting, a line from the forehead to the crown, and around its end.
    constexpr double kPartX = 0.022, kCrownZ = -0.045, kFrontZ = 0.13;
    const Vector fromParting = {p.x - kPartX, 0, p.z - std::min(std::max(p.z, kCrownZ), kFrontZ)};
    // Under the widest part of the head, outwards becomes down.
    const double top = smoothStep(0.21, 0.30, p.y);
    flow = normalizeOr(fromParting, Vector{1, 0, 0}) * (0.1 + 0.9 * top);
    flow.z -= smoothStep(-0.03, 0.07, p.z);  // off the face
    flow.y -= 0.35 + 0.65 * (1 - top);
  } else {
    // At the back of the head backwards becomes down.
    const double back = 1 - smoothStep(-0.09, 0.0, p.z);
    flow = {4.0 * p.x * (1 - back), -0.25 - back, back - 1};
  }
  return normalizeOr(flow - normal * dot(flow, normal), Vector{0, 0, -1});
}

// The scalp of the head.
class Scalp : public detail::HairGround {
 public:
  explicit Scalp(const GroomDef& def) : def_(def) {}
  double surface(const Vector& p) const override { return detail::headSurface(p); }
  Vector normal(const Vector& p) const override { return detail::headNormal(p); }
  double combedSurface(const Vector& p) const override { return detail::combedSurface(p); }
  Vector combedNormal(const Vector& p) const override { return detail::combedNormal(p); }
  Vector rootNormal(const Vector& p) const override { return detail::skullNormal(p); }
  bool grows(const Vector& p) const override {
    if (def_.stripWidth > 0 && std::abs(p.x) > def_.stripWidth / 2) return false;
    return detail::isScalp(p, def_.hairline);
  }
  double insideEdge(const Vector& root) const override {
    return detail::insideHairline(root, def_.hairline);
  }
  Vector combDirection(const Vector& p, const Vector& normal) const override {
    return ::pelage::combDirection(p, normal, def_.style);
  }
  double height(const Vector& root) const override { return smoothStep(0.15, 0.30, root.y); }

 private:
  const GroomDef& def_;
};

Result<void> check(const GroomDef& def) {
  const auto outside = [](const char* field, auto value, auto low, auto high) {
    return Error{ErrorCode::kInvalidArgument,
                 fmt::format("GroomDef::{} is {}; it must be {} to {}", field, value, low, high)};
  };
  const auto bad = [](float value, float low, float high) {
    return !(value >= low && value <= high);  // true for NaN
  };
  if (def.strandCount < 1 || def.strandCount > 1'000'000)
    return outside("strandCount", def.strandCount, 1, 1'000'000);
  if (def.verticesPerStrand < kMinVerticesPerStrand ||
      def.verticesPerStrand > kMaxVerticesPerStrand)
    return outside("verticesPerStrand", def.verticesPerStrand, 2, 256);
  if (def.clumpCount > kMaxClumpCount)
    return outside("clumpCount", def.clumpCount, 0u, kMaxClumpCount);
  struct Range {
    const char* field;
    float value, low, high;
  };
  for (const Range& r : {Range{"length", def.length, 0.002f, 2},
                         {"lengthVariation", def.lengthVariation, 0, 0.95f},
                         {"lift", def.lift, 0, 1.5f},
                         {"volume", def.volume, 0, 0.1f},
                         {"comb", def.comb, 0, 1000},
                         {"droop", def.droop, 0, 1000},
                         {"curlRadius", def.curlRadius, 0, 0.1f},
                         {"curlFrequency", def.curlFrequency, 0, 500},
                         {"clumpStrength", def.clumpStrength, 0, 1},
                         {"clumpLengthVariation", def.clumpLengthVariation, 0, 0.95f},
                         {"clumpTaper", def.clumpTaper, 0, 0.95f},
                         {"noise", def.noise, 0, 0.1f},
                         {"hairline", def.hairline, -0.03f, 0.05f},
                         {"hairlineFade", def.hairlineFade, 0, 0.05f},
                         {"stripWidth", def.stripWidth, 0, 0.3f},
                         {"thicknessVariation", def.thicknessVariation, 0, 1}})
    if (bad(r.value, r.low, r.high)) return outside(r.field, r.value, r.low, r.high);
  if (def.style != HairStyle::kSideParting && def.style != HairStyle::kSweptBack)
    return outside("style", static_cast<int>(def.style), 0, 1);
  return {};
}

Result<Groom> generate(const GroomDef& def) {
  if (auto r = check(def); !r) return r.error();
  Groom groom;
  auto head = generateHead(def.headCellSize);
  if (!head) return head.error();
  groom.head = std::move(*head);
  groom.skeleton = headSkeleton();
  groom.bones.bones = groom.head.bones;

  const Scalp scalp(def);
  Random random(def.seed, kRootStream);
  const HairRoots sample = detail::sampleRoots(groom.head, scalp, def.strandCount, random);
  if (sample.roots.empty())
    return Error{ErrorCode::kInvalidArgument,
                 "no scalp is left; lower GroomDef::hairline or widen GroomDef::stripWidth"};
  // Roots are rounded to float: keep the promise all the same.
  groom.rootSpacing = static_cast<float>(sample.spacing - 1e-7);

  const HairGrower grower(def, scalp, sample.roots);
  HairAsset& hair = groom.hair;
  hair.strandCount = def.strandCount;
  hair.verticesPerStrand = def.verticesPerStrand;
  hair.positions.reserve(size_t{def.strandCount} * def.verticesPerStrand);
  for (uint32_t i = 0; i < def.strandCount; ++i) {
    const Path vertices = grower.strand(i);
    for (uint32_t k = 0; k < def.verticesPerStrand; ++k) {
      const Vector& p = vertices[k];
      hair.positions.push_back({static_cast<float>(p.x), static_cast<float>(p.y),
                                static_cast<float>(p.z), k < 2 ? 0.0f : 1.0f});
    }
    const Vector& root = sample.roots[i].position;
    // The scalp from above, the forehead at v = 1.
    hair.strandUv.push_back({static_cast<float>(saturate(0.5 + root.x / 0.18)),
                             static_cast<float>(saturate(0.5 + (root.z + 0.012) / 0.24))});
    if (def.thicknessVariation > 0 || def.hairlineFade > 0)
      hair.strandThickness.push_back(grower.thickness(i));
    const auto share = static_cast<float>(detail::headBoneShare(root));
    groom.bones.strands.push_back({{1, 0, 0, 0}, {share, 1 - share, 0, 0}});
  }
  return groom;
}

}  // namespace

Result<Groom> generateGroom(const GroomDef& def) {
  return detail::guarded([&] { return generate(def); });
}

Result<void> writeGroom(const Groom& groom, const std::filesystem::path& directory,
                        std::string_view name) {
  return detail::guarded([&]() -> Result<void> {
    const auto path = [&](const char* extension) {
      return directory / (std::string(name) + extension);
    };
    if (auto r = saveTfx(groom.hair, path(".tfx")); !r) return r;
    if (auto r = saveTfxBone(groom.bones, path(".tfxbone")); !r) return r;
    return saveTfxMesh(groom.head, path(".tfxmesh"));
  });
}

}  // namespace pelage
