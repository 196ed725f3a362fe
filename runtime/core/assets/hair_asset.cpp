#include "pelage/hair_asset.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <limits>
#include <numeric>
#include <optional>
#include <utility>

#include "assets/groom.h"
#include "base/errors.h"
#include "base/guard.h"
#include "base/portable_math.h"
#include "base/vector3.h"
#include "pelage/assert.h"
#include "pelage/random.h"

namespace pelage {
namespace {

using detail::invalid;
using detail::isCoordinate;
using FloatVector = detail::Vector3<float>;
using RestFrame = detail::UnitQuaternion<float>;

constexpr uint32_t kMaxFollowHairsPerGuide = 64;

FloatVector xyz(const Float4& p) { return {p.x, p.y, p.z}; }

// Direction of the first segment that has one: the kernel starts from it, too.
FloatVector rootTangent(const Float4* strand, uint32_t count) {
  for (uint32_t i = 0; i + 1 < count; ++i) {
    const FloatVector direction =
        detail::normalizeOr(xyz(strand[i + 1]) - xyz(strand[i]), FloatVector{});
    if (dot(direction, direction) > 0) return direction;
  }
  return {1, 0, 0};
}

float segmentLength(const Float4& a, const Float4& b) {
  const detail::Vector3<double> d = {double{b.x} - a.x, double{b.y} - a.y, double{b.z} - a.z};
  return static_cast<float>(detail::length(d));
}

Result<void> checkSizes(const HairAsset& asset) {
  if (asset.strandCount == 0) return invalid("the hair asset has no strands");
  if (asset.verticesPerStrand < kMinVerticesPerStrand ||
      asset.verticesPerStrand > kMaxVerticesPerStrand)
    return invalid(fmt::format("the hair asset has {} vertices a strand; it must be 2 to 256",
                               asset.verticesPerStrand));
  const uint64_t strandCount = asset.strandCount;
  const uint64_t vertexCount = strandCount * asset.verticesPerStrand;
  const auto checkSize = [](const char* name, uint64_t size, uint64_t wanted,
                            bool optional) -> Result<void> {
    if (size == wanted || (optional && size == 0)) return {};
    return invalid(fmt::format("HairAsset::{} has {} elements instead of {}", name, size, wanted));
  };
  if (auto r = checkSize("positions", asset.positions.size(), vertexCount, false); !r) return r;
  if (auto r = checkSize("vertexCounts", asset.vertexCounts.size(), strandCount, true); !r)
    return r;
  for (uint64_t i = 0; i < asset.vertexCounts.size(); ++i) {
    const uint32_t count = asset.vertexCounts[i];
    if (count < kMinVerticesPerStrand || count > asset.verticesPerStrand)
      return invalid(
          fmt::format("strand {} has {} vertices in HairAsset::vertexCounts; it must be "
                      "2 to verticesPerStrand, which is {}",
                      i, count, asset.verticesPerStrand));
  }
  if (auto r = checkSize("strandUv", asset.strandUv.size(), strandCount, true); !r) return r;
  if (auto r = checkSize("vertexUv", asset.vertexUv.size(), vertexCount, true); !r) return r;
  if (auto r = checkSize("strandThickness", asset.strandThickness.size(), strandCount, true); !r)
    return r;
  return checkSize("vertexColor", asset.vertexColor.size(), vertexCount, true);
}

Result<void> checkPositions(const HairAsset& asset) {
  for (uint64_t i = 0; i < asset.positions.size(); ++i) {
    const Float4& p = asset.positions[i];
    const uint64_t strand = i / asset.verticesPerStrand, vertex = i % asset.verticesPerStrand;
    if (!isCoordinate(p.x) || !isCoordinate(p.y) || !isCoordinate(p.z))
      return invalid(
          fmt::format("position of strand {}, vertex {} is ({}, {}, {}); it must be "
                      "finite and within +-1e6 m",
                      strand, vertex, p.x, p.y, p.z));
    if (!std::isfinite(p.w) || p.w < 0)
      return invalid(
          fmt::format("inverse mass of strand {}, vertex {} is {}; it must be finite and "
                      "not negative",
                      strand, vertex, p.w));
  }
  return {};
}

Result<void> checkAsset(const HairAsset& asset) {
  if (auto r = checkSizes(asset); !r) return r;
  if (auto r = checkPositions(asset); !r) return r;
  for (uint64_t i = 0; i < asset.strandThickness.size(); ++i)
    if (!(asset.strandThickness[i] >= 0 && asset.strandThickness[i] <= kMaxCoordinate))
      return invalid(fmt::format("thickness of strand {} is {}; it must be 0 to 1e6", i,
                                 asset.strandThickness[i]));
  const auto checkFinite = [](const char* name, const float* values, uint64_t count,
                              uint64_t perElement) -> Result<void> {
    for (uint64_t i = 0; i < count * perElement; ++i)
      if (!std::isfinite(values[i]))
        return invalid(fmt::format("HairAsset::{}[{}] is not finite", name, i / perElement));
    return {};
  };
  static_assert(sizeof(Float2) == 2 * sizeof(float) && sizeof(Float4) == 4 * sizeof(float));
  const auto floats = [](const auto& v) { return reinterpret_cast<const float*>(v.data()); };
  if (auto r = checkFinite("strandUv", floats(asset.strandUv), asset.strandUv.size(), 2); !r)
    return r;
  if (auto r = checkFinite("vertexUv", floats(asset.vertexUv), asset.vertexUv.size(), 2); !r)
    return r;
  return checkFinite("vertexColor", floats(asset.vertexColor), asset.vertexColor.size(), 4);
}

// Rest data of one strand; `first` is the index of its vertex 0.
void processStrand(HairAsset& asset, uint64_t first, float thickness, float tipThickness) {
  const uint32_t count = asset.verticesPerStrand;
  const Float4* positions = asset.positions.data() + first;

  double arcLength = 0;
  for (uint32_t i = 0; i + 1 < count; ++i) {
    const float length = segmentLength(positions[i], positions[i + 1]);
    asset.restLengths[first + i] = length;
    arcLength += length;
    if (length < kMinSegmentLength) ++asset.degenerateSegmentCount;
  }

  // Parallel transport (Bergou et al. 2008, "Discrete Elastic Rods", section 4.2.2): each frame is
  // the previous one, rotated by the shortest arc between the two directions.
  const FloatVector rootDirection = rootTangent(positions, count);
  FloatVector direction = rootDirection;
  RestFrame frame = detail::shortestArc(FloatVector{1, 0, 0}, direction);
  for (uint32_t i = 0; i < count; ++i) {
    // The frame is still that of the edge that ends here (vertex 0: of edge 0).
    asset.restFrames[first + i] = {frame.x, frame.y, frame.z, frame.w};
    if (i + 1 == count) break;
    const FloatVector edge = xyz(positions[i + 1]) - xyz(positions[i]);
    const FloatVector rest = detail::rotateInverse(frame, edge);
    asset.restVectors[first + i] = {rest.x, rest.y, rest.z};
    const FloatVector next = detail::normalizeOr(edge, direction);
    if (i > 0) frame = detail::normalized(detail::shortestArc(direction, next) * frame);
    direction = next;
  }

  direction = rootDirection;
  for (uint32_t i = 0; i < count; ++i) {
    const FloatVector before = xyz(positions[i > 0 ? i - 1 : 0]);
    const FloatVector here = xyz(positions[i]);
    const FloatVector after = xyz(positions[i + 1 < count ? i + 1 : i]);
    direction = detail::normalizeOr(after - here, direction);
    const FloatVector tangent = detail::normalizeOr(after - before, direction);
    asset.tangents[first + i] = {tangent.x, tangent.y, tangent.z};
  }

  double distance = 0;
  for (uint32_t i = 0; i < count; ++i) {
    const double share = arcLength > 0 ? std::min(distance / arcLength, 1.0) : 0.0;
    asset.vertexThickness[first + i] =
        static_cast<float>(thickness * (1.0 + (double{tipThickness} - 1.0) * share));
    asset.inverseMasses[first + i] = i < 2 ? 0.0f : positions[i].w;
    distance += asset.restLengths[first + i];
  }
}

Result<void> processAsset(HairAsset& asset, const ProcessDef& def) {
  if (!(def.tipThickness >= 0 && def.tipThickness <= 1))
    return invalid(fmt::format("the tip thickness is {}; it must be 0 to 1", def.tipThickness));
  if (auto r = checkAsset(asset); !r) return r;
  const uint64_t vertexCount = uint64_t{asset.strandCount} * asset.verticesPerStrand;
  for (uint64_t strand = 0; strand < asset.vertexCounts.size(); ++strand) {
    Float4* positions = asset.positions.data() + strand * asset.verticesPerStrand;
    const uint32_t count = asset.vertexCounts[strand];
    std::fill(positions + count, positions + asset.verticesPerStrand, positions[count - 1]);
  }
  asset.restLengths.assign(vertexCount, 0.0f);
  asset.restFrames.assign(vertexCount, {});
  asset.restVectors.assign(vertexCount, {});
  asset.tangents.assign(vertexCount, {});
  asset.inverseMasses.assign(vertexCount, 0.0f);
  asset.vertexThickness.assign(vertexCount, 0.0f);
  asset.degenerateSegmentCount = 0;
  for (uint64_t strand = 0; strand < asset.strandCount; ++strand)
    processStrand(asset, strand * asset.verticesPerStrand,
                  asset.strandThickness.empty() ? 1.0f : asset.strandThickness[strand],
                  def.tipThickness);
  return {};
}

// Finds the roots nearest to a point; roots are sorted along one axis.
class NearestRoots {
 public:
  explicit NearestRoots(const HairAsset& asset) {
    for (uint32_t i = 0; i < asset.strandCount; ++i)
      roots_.push_back({asset.positions[uint64_t{i} * asset.verticesPerStrand], i});
    std::sort(roots_.begin(), roots_.end(), [](const Root& a, const Root& b) {
      return a.position.x != b.position.x ? a.position.x < b.position.x : a.guide < b.guide;
    });
  }

  struct Found {
    double squared = std::numeric_limits<double>::infinity();
    uint32_t guide = 0;
    bool operator<(const Found& other) const {
      return squared != other.squared ? squared < other.squared : guide < other.guide;
    }
  };
  /// The nearest two except `own`; a distance is infinite if there are fewer.
  std::array<Found, 2> find(const std::array<double, 3>& p, uint32_t own) const {
    std::array<Found, 2> nearest;
    const auto start = std::lower_bound(
        roots_.begin(), roots_.end(), p[0],
        [](const Root& root, double x) { return static_cast<double>(root.position.x) < x; });
    // False if no further root in this direction can be nearer.
    const auto visit = [&](const Root& root) {
      const double dx = static_cast<double>(root.position.x) - p[0];
      if (dx * dx > nearest[1].squared) return false;
      if (root.guide == own) return true;
      const double dy = static_cast<double>(root.position.y) - p[1];
      const double dz = static_cast<double>(root.position.z) - p[2];
      const Found found = {dx * dx + dy * dy + dz * dz, root.guide};
      if (found < nearest[1]) nearest[1] = found;
      if (nearest[1] < nearest[0]) std::swap(nearest[0], nearest[1]);
      return true;
    };
    for (auto up = start; up != roots_.end() && visit(*up); ++up) {
    }
    for (auto down = start; down != roots_.begin() && visit(*std::prev(down)); --down) {
    }
    return nearest;
  }

 private:
  struct Root {
    Float4 position;
    uint32_t guide;
  };
  std::vector<Root> roots_;
};

// Adds the nearest guides to a hair that only copies its own one.
void addGuides(FollowHair& hair, const HairAsset& asset, const NearestRoots& roots,
               const FollowDef& def) {
  const auto rootOf = [&](uint32_t guide) -> std::array<double, 3> {
    const Float4& p = asset.positions[uint64_t{guide} * asset.verticesPerStrand];
    return {static_cast<double>(p.x), static_cast<double>(p.y), static_cast<double>(p.z)};
  };
  const std::array<double, 3> offset = {static_cast<double>(hair.offset.x),
                                        static_cast<double>(hair.offset.y),
                                        static_cast<double>(hair.offset.z)};
  const std::array<double, 3> own = rootOf(hair.guide);
  std::array<double, 3> point = {};
  for (size_t axis = 0; axis < 3; ++axis) point[axis] = own[axis] + offset[axis];
  // Not 0, so that guides at one position share a hair.
  const double soft = std::max(static_cast<double>(def.maxRadius), 1e-6);
  const auto weightAt = [&](double squared) { return 1 / (squared + soft * soft); };
  const std::array<NearestRoots::Found, 2> nearest = roots.find(point, hair.guide);
  double sum = weightAt(offset[0] * offset[0] + offset[1] * offset[1] + offset[2] * offset[2]);
  const uint32_t others = def.guidesPerHair - 1;
  for (uint32_t k = 0; k < others; ++k) sum += weightAt(nearest[k].squared);
  std::array<double, 3> rest = offset;
  for (uint32_t k = 0; k < others; ++k) {
    const auto weight = static_cast<float>(weightAt(nearest[k].squared) / sum);
    hair.otherGuides[k] = nearest[k].guide;
    hair.otherWeights[k] = weight;
    const std::array<double, 3> other = rootOf(nearest[k].guide);
    for (size_t axis = 0; axis < 3; ++axis)
      rest[axis] -= static_cast<double>(weight) * (other[axis] - own[axis]);
  }
  hair.offset.x = static_cast<float>(rest[0]);
  hair.offset.y = static_cast<float>(rest[1]);
  hair.offset.z = static_cast<float>(rest[2]);
}

Result<std::vector<FollowHair>> makeFollowHairs(const HairAsset& asset, const FollowDef& def) {
  if (def.countPerGuide > kMaxFollowHairsPerGuide)
    return invalid(fmt::format("the number of follow hairs per guide is {}; it must be 0 to {}",
                               def.countPerGuide, kMaxFollowHairsPerGuide));
  if (def.guidesPerHair < 1 || def.guidesPerHair > 3)
    return invalid(
        fmt::format("the number of guides per hair is {}; it must be 1 to 3", def.guidesPerHair));
  if (!(def.maxRadius >= 0 && def.maxRadius <= 1))
    return invalid(
        fmt::format("the radius of follow hairs around their guide is {} m; it must be 0 to 1 m",
                    def.maxRadius));
  if (!(def.tipSeparation >= 0 && def.tipSeparation <= 100))
    return invalid(fmt::format("the tip separation of follow hairs is {}; it must be 0 to 100",
                               def.tipSeparation));
  if (!(def.flyaways >= 0 && def.flyaways <= 1))
    return invalid(fmt::format("the share of flyaways among follow hairs is {}; it must be 0 to 1",
                               def.flyaways));
  if (auto r = checkAsset(asset); !r) return r.error();
  const uint64_t total = uint64_t{asset.strandCount} * def.countPerGuide;
  if (total + asset.strandCount > std::numeric_limits<uint32_t>::max())
    return invalid(fmt::format("{} guides with {} follow hairs each are more than 2^32 strands",
                               asset.strandCount, def.countPerGuide));

  if (total == 0) return std::vector<FollowHair>();
  std::optional<NearestRoots> roots;
  if (def.guidesPerHair > 1) roots.emplace(asset);
  std::vector<FollowHair> hairs;
  hairs.reserve(total);
  for (uint32_t guide = 0; guide < asset.strandCount; ++guide) {
    Random random(def.seed, guide), stray(def.seed, uint64_t{asset.strandCount} + guide);
    const RestFrame frame = detail::shortestArc(
        FloatVector{1, 0, 0},
        rootTangent(asset.positions.data() + uint64_t{guide} * asset.verticesPerStrand,
                    asset.verticesPerStrand));
    for (uint32_t k = 0; k < def.countPerGuide; ++k) {
      // The square root makes the density uniform over the disc's area.
      const double radius = def.maxRadius * std::sqrt(random.uniformDouble());
      const detail::SinCos angle = detail::sinCos(detail::kTwoPi * random.uniformDouble());
      const FloatVector offset =
          detail::rotate(frame, FloatVector{0, static_cast<float>(radius * angle.cosine),
                                            static_cast<float>(radius * angle.sine)});
      FollowHair hair = {.guide = guide,
                         .offset = {offset.x, offset.y, offset.z, def.tipSeparation}};
      if (stray.uniform() < def.flyaways) hair.offset.w += 4 * stray.uniform();
      if (roots) addGuides(hair, asset, *roots, def);
      hairs.push_back(hair);
    }
  }
  std::vector<uint32_t> guides;
  guides.reserve(total);
  for (const FollowHair& hair : hairs) guides.push_back(hair.guide);
  std::vector<FollowHair> spread;
  spread.reserve(total);
  for (const uint32_t i : spreadOrder(guides, asset.strandCount)) spread.push_back(hairs[i]);
  return spread;
}

}  // namespace

std::vector<uint32_t> spreadOrder(std::span<const uint32_t> guides, uint32_t guideCount) {
  // `next` has a guide's next hair, and `after` the hair that follows one at the same guide.
  constexpr uint32_t kNone = 0xffffffffu;
  std::vector<uint32_t> next(guideCount, kNone), after(guides.size());
  for (auto i = static_cast<uint32_t>(guides.size()); i-- > 0;) {
    PELAGE_ASSERT(guides[i] < guideCount, "spreadOrder() needs guides below guideCount");
    if (guides[i] >= guideCount) return {};
    after[i] = std::exchange(next[guides[i]], i);
  }
  uint64_t step = std::max(static_cast<uint64_t>(0.6180339887 * guideCount), uint64_t{1});
  while (std::gcd(step, uint64_t{guideCount}) > 1) ++step;
  std::vector<uint32_t> left;  // guides that have hairs
  for (uint64_t i = 0, guide = 0; i < guideCount; ++i, guide = (guide + step) % guideCount)
    left.push_back(static_cast<uint32_t>(guide));
  std::vector<uint32_t> order;
  order.reserve(guides.size());
  while (!left.empty()) {
    std::erase_if(left, [&](uint32_t guide) { return next[guide] == kNone; });
    for (const uint32_t guide : left) {
      order.push_back(next[guide]);
      next[guide] = after[next[guide]];
    }
  }
  return order;
}

Result<void> validate(const HairAsset& asset) {
  return detail::guarded([&] { return checkAsset(asset); });
}

Result<void> HairAsset::process(const ProcessDef& def) {
  Result<void> processed = detail::guarded([&] { return processAsset(*this, def); });
  // Rest data of other positions, or a part of it, would be wrong.
  if (!processed) detail::clearRestData(*this);
  return processed;
}

Result<std::vector<FollowHair>> HairAsset::generateFollowHairs(const FollowDef& def) const {
  return detail::guarded([&] { return makeFollowHairs(*this, def); });
}

Result<std::vector<Float4>> packRest(const HairAsset& asset) {
  return detail::guarded([&]() -> Result<std::vector<Float4>> {
    const uint64_t strandCount = asset.strandCount, count = asset.verticesPerStrand;
    const uint64_t vertexCount = strandCount * count;
    if (vertexCount == 0 || asset.positions.size() != vertexCount ||
        asset.restVectors.size() != vertexCount || asset.restLengths.size() != vertexCount ||
        asset.restFrames.size() != vertexCount || asset.inverseMasses.size() != vertexCount) {
      return invalid("packRest() needs an asset on which process() succeeded");
    }
    std::vector<Float4> packed(2 * vertexCount);
    for (uint64_t strand = 0; strand < strandCount; ++strand) {
      for (uint64_t i = 0; i < count; ++i) {
        const uint64_t from = strand * count + i, to = i * strandCount + strand;
        const Float4& p = asset.positions[from];
        const Float3& rest = asset.restVectors[from];
        packed[to] = {p.x, p.y, p.z, asset.inverseMasses[from] > 0 ? 1.0f : 0.0f};
        packed[vertexCount + to] = {rest.x, rest.y, rest.z, asset.restLengths[from]};
      }
      const Quaternion& frame = asset.restFrames[strand * count];
      packed[vertexCount + (count - 1) * strandCount + strand] = {frame.x, frame.y, frame.z,
                                                                  frame.w};
    }
    return packed;
  });
}

}  // namespace pelage
