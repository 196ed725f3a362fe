#include "shadow/strand_shadow.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <vector>

#include "base/finite.h"
#include "base/vector3.h"
#include "passes/dispatch_rows.h"
#include "pelage/assert.h"
#include "pelage/bindings.h"
#include "pelage/constants.h"
#include "pelage/kernels.h"
#include "shading/light_numbers.h"

namespace pelage::detail {
namespace {

using Vector = Vector3<double>;

constexpr uint32_t kVolumeCells = 16;
// The layers end where light would be down to e^-8 in hair of mean density.
constexpr double kLayerDepths = 8;
// Finer quanta than this add nothing to what a float reads.
constexpr double kFinestQuantum = 0x1p20;
// Sine of the largest half angle under which one map looks at the ball, and that of a spot light's
// cone [rad]: wider ones would have small texels at the edge and large ones in the middle.
constexpr double kWidestBall = 0.7, kWidestCone = 1.05;
// Fibers nearer than this to a light at a point are not in its map [m], and as a share of the
// ball's radius. strand_lighting.hlsli takes a light for no smaller than this.
constexpr double kNearest = 0.01, kNearestShare = 1.0 / 32;
constexpr uint32_t kCubeFaces = 6;
// Half a texel on both sides of a map's ball for the interpolation, half of one for snapping.
constexpr double kEdgeTexels = 3;
// The radius up to which a fiber near a light is as wide as it is [texel]: sums keep small quanta.
constexpr double kWidestFiber = 4;

Float4 toRow(const Vector& v, double w) {
  return {static_cast<float>(v.x), static_cast<float>(v.y), static_cast<float>(v.z),
          static_cast<float>(w)};
}

uint64_t segmentsOf(const ShadowedHair& hair) {
  return uint64_t{hair.strandCount} * (hair.vertexCount > 0 ? hair.vertexCount - 1 : 0);
}

// Area that a fiber shows on average over all directions [m2] (Cauchy: a quarter of its surface).
double areaOf(const ShadowedHair& hair) {
  const double radius = toDouble(hair.fiberRadius) * (1 + toDouble(hair.tipRadiusRatio)) / 2 *
                        toDouble(hair.meanThickness);
  return std::numbers::pi / 2 * radius * toDouble(hair.strandLength) * hair.strandCount;
}

// Strands whose vertices are in the buffer of positions.
uint32_t storedOf(const ShadowedHair& hair) {
  return hair.storesFollows ? hair.strandCount : std::min(hair.strandCount, hair.guideCount);
}

uint64_t texelsOf(const StrandShadowView& view) {
  return uint64_t{view.width} * view.height * view.faceCount;
}

// Returns what is wrong with a map, or nothing.
std::string faultOf(const StrandShadowDef& def) {
  if (def.size < kMinShadowSize || def.size > kMaxShadowSize)
    return fmt::format("a map of {} texels; it has to be {} to {}", def.size, kMinShadowSize,
                       kMaxShadowSize);
  if (def.layers > kMaxShadowLayers)
    return fmt::format("{} layers, at most {} are possible", def.layers, kMaxShadowLayers);
  if (!(def.radius > 0) || !std::isfinite(def.radius) || !isFinite(def.center))
    return fmt::format("a ball of radius {} m around ({}, {}, {})", def.radius, def.center.x,
                       def.center.y, def.center.z);
  if (!isFinite(def.position) || !(def.coneAngle >= 0))
    return fmt::format("a light at ({}, {}, {}) with a cone of {} rad", def.position.x,
                       def.position.y, def.position.z, def.coneAngle);
  if (!(def.biasTexels >= 0) || !(def.layerRange >= 0) || !(def.volume >= 0))
    return fmt::format("a bias of {} texels, a range of {} m or a volume of {} m3 is below 0",
                       def.biasTexels, def.layerRange, def.volume);
  return {};
}

// A map's projection, the constants that depend on it, and the size of a fiber in it.
struct Projection {
  StrandShadowView view = {};
  double smallestTexel = 0;  // edge of a texel where hair is nearest to the light [m]
};

// Unit vectors at right angles to an axis and to each other.
struct MapAxes {
  Vector x, y;
};
MapAxes axesAround(const Vector& axis) {
  const Vector up = std::abs(axis.y) < 0.9 ? Vector{0, 1, 0} : Vector{1, 0, 0};
  const Vector x = normalizeOr(cross(up, axis), {1, 0, 0});
  return {x, cross(axis, x)};
}

Projection parallelTo(const StrandShadowDef& def) {
  const double texel = 2 * toDouble(def.radius) / (def.size - kEdgeTexels);
  const Vector light = normalizeOr(toVector(def.toLight), {0, 1, 0});
  const auto [x, y] = axesAround(light);
  const Vector center = toVector(def.center);
  const auto lowest = [&](const Vector& along) {
    const double shift = dot(along, def.shifted) / texel;
    return std::round(dot(along, center) / texel + shift - 0.5 * def.size) - shift;
  };

  StrandShadowView view = {};
  view.mapX = toRow(x * (1 / texel), -lowest(x));
  view.mapY = toRow(y * (1 / texel), -lowest(y));
  // Two texels of room, so that what the snapping moves and the ball's own rounding stay behind 0.
  view.mapZ = toRow(-light, dot(light, center) + toDouble(def.radius) + 2 * texel);
  view.mapW = {0, 0, 0, 1};
  view.nearW = 0.5f;
  view.width = view.height = def.size;
  view.faceCount = 1;
  view.texelSize = static_cast<float>(texel);
  return {view, texel};
}

// The cone or cube that a map of a light at a point covers.
struct Sight {
  bool around = false;  // a cube
  Vector axis = {0, 0, 1};
  double halfAngle = std::numbers::pi / 4;
};

// Texels keep their place around the light while the ball moves a little: its direction is one of a
// grid, and its size a power of 1.25.
Sight sightOf(const StrandShadowDef& def) {
  const Vector toBall = toVector(def.center) - toVector(def.position);
  const double distance = length(toBall);
  Sight ball = {.around = true};
  const double sine = toDouble(def.radius) / distance;
  if (const double steps = std::ceil(std::log(sine) / std::log(1.25) - 1e-6);
      std::pow(1.25, steps) <= kWidestBall) {
    const double steady = std::pow(1.25, steps);
    const double step = std::exp2(std::floor(std::log2(steady / 4)));
    const Vector unit = toBall * (1 / distance);
    const Vector snapped = {std::round(unit.x / step), std::round(unit.y / step),
                            std::round(unit.z / step)};
    ball = {.axis = normalizeOr(snapped, {0, 0, 1}),
            .halfAngle = std::asin(steady) + std::asin(std::sqrt(0.75) * step)};
  }
  const double cone = toDouble(def.coneAngle);
  if (cone > 0 && cone <= kWidestCone && (ball.around || cone < ball.halfAngle))
    return {.axis = -normalizeOr(toVector(def.toLight), {0, 1, 0}), .halfAngle = cone};
  return ball;
}

Projection fromPoint(const StrandShadowDef& def) {
  const Sight sight = sightOf(def);
  const Vector position = toVector(def.position);
  const double radius = toDouble(def.radius);
  StrandShadowView view = {};
  view.faceCount = sight.around ? kCubeFaces : 1;
  view.width = view.height = sight.around ? std::max(def.size / 2, kMinShadowSize) : def.size;
  const double texel = 2 * std::tan(sight.halfAngle) / (view.width - kEdgeTexels);
  double nearest = std::min(kNearest, radius * kNearestShare);
  if (sight.around) {
    view.mapX = toRow({1, 0, 0}, -position.x);
    view.mapY = toRow({0, 1, 0}, -position.y);
    view.mapW = toRow({0, 0, 1}, -position.z);
  } else {
    const auto [x, y] = axesAround(sight.axis);
    const auto rowOf = [&](const Vector& along) {
      const Vector row = along * (1 / texel) + sight.axis * (0.5 * view.width);
      return toRow(row, -dot(row, position));
    };
    const double toBall = dot(sight.axis, toVector(def.center) - position);
    nearest = std::max(nearest, 0.99 * (toBall - radius));
    view.mapX = rowOf(x);
    view.mapY = rowOf(y);
    view.mapW = toRow(sight.axis, -dot(sight.axis, position));
    view.mapZ = toRow(sight.axis, -dot(sight.axis, position) - nearest);
  }
  view.nearW = static_cast<float>(nearest);
  view.texelSize = static_cast<float>(texel);
  // A fiber's image is wider off the middle: by 1 / cos in a corner.
  const double corner = 0.5 * texel * view.width;
  return {view, texel * nearest / std::sqrt(1 + 2 * corner * corner)};
}

// Sets the members of a view that describe its texels.
void setContent(StrandShadowView& view, const StrandShadowDef& def) {
  view.firstWord = def.firstWord;
  view.layerCount = def.layers;
  view.bias = static_cast<float>(toDouble(view.texelSize) * toDouble(def.biasTexels));
}

struct HairSums {
  double area = 0, opaqueArea = 0;  // [m2]
  double segments = 0;              // weighted with their opacity
  double widest = 0;                // radius [texels]
  double known = 0;                 // volume [m3]
  bool allKnown = true;
};

HairSums sumsOf(std::span<const ShadowedHair> hairs, double texel) {
  HairSums sums;
  for (const ShadowedHair& hair : hairs) {
    const double opacity = std::clamp(toDouble(hair.opacity), 0.0, 1.0);
    sums.area += areaOf(hair);
    sums.opaqueArea += opacity * areaOf(hair);
    sums.known += toDouble(hair.volume);
    sums.allKnown = sums.allKnown && hair.volume > 0;
    sums.segments += opacity * static_cast<double>(segmentsOf(hair));
    sums.widest =
        std::max(sums.widest, toDouble(hair.fiberRadius) * toDouble(hair.maxThickness) / texel);
  }
  return sums;
}

}  // namespace

double hairVolume(std::span<const Float4> positions, uint32_t vertexCount) {
  PELAGE_ASSERT(vertexCount > 0, "strands without vertices");
  const auto toPoint = [](const Float4& p) { return toVector({p.x, p.y, p.z}); };
  const auto isKnown = [](const Float4& p) { return isFinite(Float3{p.x, p.y, p.z}); };
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  Vector low = {kInfinity, kInfinity, kInfinity}, high = -low;
  for (const Float4& position : positions) {
    if (!isKnown(position)) continue;
    const Vector p = toPoint(position);
    low = {std::min(low.x, p.x), std::min(low.y, p.y), std::min(low.z, p.z)};
    high = {std::max(high.x, p.x), std::max(high.y, p.y), std::max(high.z, p.z)};
  }
  const Vector box = high - low;
  const double cell = std::max({box.x, box.y, box.z}) / kVolumeCells;
  if (!(cell > 0)) return 0;
  std::vector<double> lengths(kVolumeCells * kVolumeCells * kVolumeCells);
  const auto index = [&](double p, double from) {
    return std::min(static_cast<uint32_t>(std::max((p - from) / cell, 0.0)), kVolumeCells - 1);
  };
  for (size_t i = 1; i < positions.size(); ++i) {
    if (i % vertexCount == 0 || !isKnown(positions[i]) || !isKnown(positions[i - 1])) continue;
    const Vector from = toPoint(positions[i - 1]), to = toPoint(positions[i]);
    const double offset = length(to - from);
    const auto steps = static_cast<uint32_t>(std::ceil(4 * offset / cell));
    for (uint32_t step = 0; step < steps; ++step) {
      const Vector p = lerp(from, to, (step + 0.5) / steps);
      const uint32_t row = index(p.z, low.z) * kVolumeCells + index(p.y, low.y);
      lengths[row * kVolumeCells + index(p.x, low.x)] += offset / steps;
    }
  }
  double sum = 0, squares = 0;
  for (const double length : lengths) {
    sum += length;
    squares += length * length;
  }
  return squares > 0 ? sum * sum / squares * cell * cell * cell : 0;
}

Result<StrandShadowPlan> planStrandShadow(const StrandShadowDef& def,
                                          std::span<const ShadowedHair> hairs) {
  const auto error = [](std::string message) {
    return Error{ErrorCode::kInvalidArgument, "strand shadow: " + std::move(message)};
  };
  if (std::string fault = faultOf(def); !fault.empty()) return error(std::move(fault));
  for (const ShadowedHair& hair : hairs) {
    if (!std::isfinite(areaOf(hair) * toDouble(hair.opacity) * toDouble(hair.maxThickness)))
      return error(
          fmt::format("hair with fibers of radius {} m, thickness {}, length {} m and opacity {}",
                      hair.fiberRadius, hair.maxThickness, hair.strandLength, hair.opacity));
  }
  const Projection projection = def.hasPosition ? fromPoint(def) : parallelTo(def);
  StrandShadowPlan plan;
  plan.view = projection.view;
  StrandShadowView& view = plan.view;
  setContent(view, def);
  const uint64_t words = texelsOf(view) * (1 + def.layers);
  if (words + def.firstWord > std::numeric_limits<uint32_t>::max())
    return error(fmt::format("{} words from word {} on do not fit into 2^32; use fewer layers",
                             words, def.firstWord));
  plan.words = static_cast<uint32_t>(words);
  const double radius = toDouble(def.radius);
  const HairSums sums = sumsOf(hairs, projection.smallestTexel);
  const double ball = 4.0 / 3 * std::numbers::pi * radius * radius * radius;
  double volume = sums.allKnown && !hairs.empty() ? sums.known : ball;
  if (def.volume > 0) volume = toDouble(def.volume);
  plan.spacing = static_cast<float>(volume / sums.area);
  // A ray meets fibers at random, on average every `spacing`: it is not the power of 1 - opacity
  // that the mean of the light has, but that of exp(-opacity).
  view.extinction = static_cast<float>(sums.opaqueArea / volume);
  view.across =
      volume > 0 ? static_cast<float>(std::min(2 * radius * sums.opaqueArea / volume, 1e6)) : 0;
  const double depths = sums.opaqueArea > 0 ? kLayerDepths * volume / sums.opaqueArea
                                            : std::numeric_limits<double>::infinity();
  view.layerRange =
      def.layerRange > 0 ? def.layerRange : static_cast<float>(std::min(2 * radius, depths));
  // Room for the rounding of the ratio, which the kernel does in floats.
  view.maxRadius = static_cast<float>(def.hasPosition ? std::min(1.001 * sums.widest, kWidestFiber)
                                                      : 1.001 * sums.widest);
  // splat_strand_opacity says what a segment adds to a texel at most. The last quarter of 2^32 is
  // for rounding.
  const double most = 2 * std::numbers::sqrt2 * toDouble(view.maxRadius) * sums.segments;
  const double scale = std::min(kFinestQuantum, most > 0 ? 0x1.8p31 / most : kFinestQuantum);
  view.tauScale = static_cast<float>(std::exp2(std::floor(std::log2(scale))));
  view.tauQuantum = 1 / view.tauScale;
  if (!(sums.segments < 0x1p29))
    return error(
        fmt::format("{:.4g} segments of strands, fewer than 2^29 are possible", sums.segments));
  return plan;
}

namespace {

void setHair(StrandShadowConstants& constants, const ShadowedHair& hair) {
  constants.shadowVertexCount = hair.vertexCount;
  constants.shadowStrandCount = hair.strandCount;
  constants.shadowGuideCount = storedOf(hair);
  constants.shadowTipSeparation = hair.tipSeparation;
  constants.shadowFiberRadius = hair.fiberRadius;
  constants.shadowTipRatio = hair.tipRadiusRatio;
  constants.shadowOpacity = hair.opacity;
  constants.shadowFade = hair.fade;
  constants.shadowFadingCount = hair.fadingCount;
  constants.shadowHasThickness = hair.thickness != BufferId::kInvalid ? 1 : 0;
}

StrandShadowBindings bindingsOf(const StrandShadowConstants& constants,
                                const StrandShadowBuffers& buffers, const ShadowedHair& hair) {
  const uint64_t guides = hair.guideCount, follows = hair.strandCount - storedOf(hair);
  const uint64_t stored = uint64_t{storedOf(hair)} * hair.vertexCount * sizeof(Float4);
  // Stand-ins that are not read, where no strand is placed and all have one thickness.
  const BufferRange positions = {hair.positions,
                                 uint64_t{hair.vertexCount} * sizeof(Float4) *
                                     (hair.storesFollows ? hair.strandCount : guides)};
  const BufferRange standIn = {hair.positions, stored};
  const BufferRange evaluated = hair.rootTransforms;
  const BufferRange thickness = {hair.thickness, uint64_t{hair.strandCount} * sizeof(float)};
  const BufferRange followHairRecords = {hair.followHairRecords,
                                         follows * sizeof(FollowHairRecord)};
  const BufferRange orPlaced = evaluated.isBound() ? evaluated : standIn;
  return {
      .strandShadowConstants = constants,
      .shadowPositions = positions,
      .shadowViews = {buffers.views, uint64_t{buffers.viewCount} * sizeof(StrandShadowView)},
      .shadowThickness = thickness.isBound() ? thickness : standIn,
      .shadowFollowHairRecords =
          follows > 0 && followHairRecords.isBound() ? followHairRecords : orPlaced,
      .shadowRoots = orPlaced,
      .shadowWords = {buffers.words, buffers.wordCount * sizeof(uint32_t)},
  };
}

}  // namespace

Result<void> addStrandShadow(PassList& list, const StrandShadowPlan& plan,
                             const StrandShadowBuffers& buffers,
                             std::span<const ShadowedHair> hairs) {
  PELAGE_ASSERT(buffers.view < buffers.viewCount, "no such view");
  PELAGE_ASSERT(buffers.wordCount >= uint64_t{plan.view.firstWord} + plan.words,
                "the buffer of the maps ends before the map does");
  addUpload(list, buffers.views, std::as_bytes(std::span(&plan.view, 1)),
            uint64_t{buffers.view} * sizeof(StrandShadowView));

  StrandShadowConstants constants = {};
  constants.shadowView = buffers.view;
  const auto dispatch = [&](const KernelVariant& variant, uint64_t threads, uint64_t bytes,
                            const ShadowedHair& hair) {
    PassBuilder builder(list);
    dispatchRows(builder, variant, threads).bytes(bytes);
    return builder.finish(bindingsOf(constants, buffers, hair));
  };
  const uint64_t texels = texelsOf(plan.view), depthBytes = texels * sizeof(uint32_t);
  if (Result<void> done = dispatch(clearStrandShadowVariant({}), texels, depthBytes, {}); !done)
    return done;

  const auto eachHair = [&](const KernelVariant& variant) -> Result<void> {
    for (const ShadowedHair& hair : hairs) {
      const uint32_t evaluated = hair.strandCount - storedOf(hair);
      setHair(constants, hair);
      const uint64_t bytes =
          uint64_t{storedOf(hair)} * hair.vertexCount * sizeof(Float4) +
          evaluated * sizeof(FollowHairRecord) +
          (evaluated > 0 ? uint64_t{hair.guideCount} * sizeof(RootTransform) : 0);
      Result<void> added = dispatch(variant, segmentsOf(hair), bytes + plan.bytes(), hair);
      if (!added) return added;
    }
    return {};
  };
  Result<void> added = eachHair(splatStrandDepthsVariant());
  if (!added || plan.view.layerCount == 0) return added;
  added = eachHair(splatStrandOpacityVariant());
  if (!added) return added;
  return dispatch(accumulateStrandShadowVariant({}), texels, 2 * plan.bytes() - depthBytes, {});
}

}  // namespace pelage::detail
