// Checks the values of cached assets: finite, in the ranges of process() and the other loaders, and
// no index beyond its array.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <initializer_list>
#include <limits>

#include "assets/asset_cache_format.h"
#include "assets/bone_influences.h"

namespace pelage::detail::cache {
namespace {

constexpr float kMaxFloat = std::numeric_limits<float>::max();
// Maximum distance of two points within +-kMaxCoordinate [m].
constexpr float kMaxDistance = 4 * kMaxCoordinate;

/// A range for each component in an array of floats.
template <size_t N>
struct Ranges {
  std::array<float, N> low, high;
};
constexpr Ranges<1> kFinite = {{-kMaxFloat}, {kMaxFloat}};
constexpr Ranges<1> kNotNegative = {{0}, {kMaxFloat}};
constexpr Ranges<1> kCoordinates = {{-kMaxCoordinate}, {kMaxCoordinate}};
constexpr Ranges<1> kDistances = {{0}, {kMaxDistance}};
constexpr Ranges<1> kVectors = {{-kMaxDistance}, {kMaxDistance}};
constexpr Ranges<1> kUnits = {{-1.001f}, {1.001f}};
constexpr Ranges<1> kThickness = {{0}, {kMaxCoordinate}};
constexpr Ranges<4> kVertices = {{-kMaxCoordinate, -kMaxCoordinate, -kMaxCoordinate, 0},
                                 {kMaxCoordinate, kMaxCoordinate, kMaxCoordinate, kMaxFloat}};

// Returns true if all are in range; NaN is not. Without a branch per value, so that compilers
// vectorize it.
template <size_t N>
bool allInside(const float* values, size_t count, const Ranges<N>& ranges) {
  int good = 1;
  for (size_t i = 0; i < count; i += N)
    for (size_t c = 0; c < N; ++c)
      good &= static_cast<int>(values[i + c] >= ranges.low[c]) &
              static_cast<int>(values[i + c] <= ranges.high[c]);
  return good != 0;
}

template <class T, size_t N>
std::optional<Fault> checkFloats(Kind kind, const std::vector<T>& array, const Ranges<N>& ranges) {
  const auto* values = reinterpret_cast<const float*>(array.data());
  const size_t count = array.size() * (sizeof(T) / sizeof(float));
  if (allInside(values, count, ranges)) return std::nullopt;
  for (size_t i = 0;; ++i) {
    const float low = ranges.low[i % N], high = ranges.high[i % N];
    if (!(values[i] >= low && values[i] <= high))
      return Fault{kind, i * sizeof(float),
                   fmt::format("a number is {}; it must be {} to {}", values[i], low, high)};
  }
}

std::optional<Fault> checkFrames(const std::vector<Quaternion>& frames) {
  for (size_t i = 0; i < frames.size(); ++i) {
    const Quaternion& q = frames[i];
    const float squared = q.x * q.x + q.y * q.y + q.z * q.z + q.w * q.w;
    if (!(std::abs(squared - 1) < 0.01f))
      return Fault{Kind::kRestFrames, i * sizeof(Quaternion), "a frame is no rotation"};
  }
  return std::nullopt;
}

std::optional<Fault> checkVertexCounts(const HairAsset& asset) {
  for (size_t i = 0; i < asset.vertexCounts.size(); ++i)
    if (asset.vertexCounts[i] < kMinVerticesPerStrand ||
        asset.vertexCounts[i] > asset.verticesPerStrand)
      return Fault{Kind::kVertexCounts, i * sizeof(uint32_t),
                   fmt::format("strand {} has {} vertices; it must be 2 to {}", i,
                               asset.vertexCounts[i], asset.verticesPerStrand)};
  return std::nullopt;
}

std::optional<Fault> checkBones(Kind names, Kind weights, const std::vector<BoneName>& bones,
                                const std::vector<BoneInfluences>& influences) {
  if (bones.empty()) return Fault{names, 0, "there are no bones"};
  if (auto r = checkBoneNames(bones, kMaxNameLength); !r) return Fault{names, 0, r.error().message};
  for (size_t i = 0; i < influences.size(); ++i)
    if (auto r = checkInfluences(influences[i], bones.size(), "entry", i); !r)
      return Fault{weights, i * sizeof(BoneInfluences), r.error().message};
  return std::nullopt;
}

// Numbers below a count; `none` is valid, too.
std::optional<Fault> checkBelow(Kind kind, const std::vector<uint32_t>& numbers, uint64_t count,
                                bool noneAllowed = false) {
  // First without a branch per number, as above.
  const auto limit = static_cast<uint32_t>(std::min<uint64_t>(count, ColliderTopology::kNone));
  const int allowNone = noneAllowed ? 1 : 0;
  int good = 1;
  for (const uint32_t n : numbers)
    good &=
        static_cast<int>(n < limit) | (static_cast<int>(n == ColliderTopology::kNone) & allowNone);
  if (good != 0) return std::nullopt;
  for (size_t i = 0; i < numbers.size(); ++i)
    if (numbers[i] >= count && !(noneAllowed && numbers[i] == ColliderTopology::kNone))
      return Fault{kind, i * sizeof(uint32_t),
                   fmt::format("a number is {}; it must be below {}", numbers[i], count)};
  return std::nullopt;
}

std::optional<Fault> checkFollowHairs(const std::vector<FollowHair>& hairs, uint32_t guides) {
  for (size_t i = 0; i < hairs.size(); ++i) {
    const FollowHair& hair = hairs[i];
    const auto fault = [&](const char* what) {
      return Fault{Kind::kFollowHairs, i * sizeof(FollowHair), what};
    };
    for (const uint32_t guide : {hair.guide, hair.otherGuides[0], hair.otherGuides[1]})
      if (guide >= guides) return fault("a guide does not exist");
    const float* weights = hair.otherWeights;
    if (!(weights[0] >= 0 && weights[1] >= 0 && weights[0] + weights[1] <= 1))
      return fault("the weights of a hair are not 0 to 1");
    for (const float value : {hair.offset.x, hair.offset.y, hair.offset.z, hair.offset.w})
      if (!(std::abs(value) <= kMaxDistance)) return fault("an offset is out of range");
  }
  return std::nullopt;
}

}  // namespace

std::optional<Fault> faultOf(const CachedHair& hair) {
  const HairAsset& a = hair.asset;
  if (auto f = checkFloats(Kind::kPositions, a.positions, kVertices)) return f;
  if (auto f = checkFloats(Kind::kVertexColor, a.vertexColor, kFinite)) return f;
  if (auto f = checkFrames(a.restFrames)) return f;
  if (auto f = checkFloats(Kind::kStrandUv, a.strandUv, kFinite)) return f;
  if (auto f = checkFloats(Kind::kVertexUv, a.vertexUv, kFinite)) return f;
  if (auto f = checkVertexCounts(a)) return f;
  if (auto f = checkFloats(Kind::kStrandThickness, a.strandThickness, kThickness)) return f;
  if (auto f = checkFloats(Kind::kRestLengths, a.restLengths, kDistances)) return f;
  if (auto f = checkFloats(Kind::kRestVectors, a.restVectors, kVectors)) return f;
  if (auto f = checkFloats(Kind::kTangents, a.tangents, kUnits)) return f;
  if (auto f = checkFloats(Kind::kInverseMasses, a.inverseMasses, kNotNegative)) return f;
  if (auto f = checkFloats(Kind::kVertexThickness, a.vertexThickness, kThickness)) return f;
  if (hair.bones)
    if (auto f = checkBones(Kind::kHairBones, Kind::kStrandBones, hair.bones->bones,
                            hair.bones->strands))
      return f;
  return checkFollowHairs(hair.followHairs, a.strandCount);
}

std::optional<Fault> faultOf(const CollisionMesh& mesh) {
  if (auto f = checkFloats(Kind::kMeshPositions, mesh.positions, kCoordinates)) return f;
  if (auto f = checkFloats(Kind::kMeshNormals, mesh.normals, kCoordinates)) return f;
  if (auto f = checkBones(Kind::kMeshBones, Kind::kMeshInfluences, mesh.bones, mesh.influences))
    return f;
  return checkBelow(Kind::kMeshIndices, mesh.indices, mesh.positions.size());
}

std::optional<Fault> faultOf(const ColliderTopology& t, uint32_t vertices, uint32_t triangles) {
  const MeshReport& report = t.report;
  // An edge has at least one triangle, a triangle three edges.
  const uint64_t edges = uint64_t{3} * triangles;
  const auto allBelow = [](std::initializer_list<uint32_t> counts, uint64_t most) {
    return std::all_of(counts.begin(), counts.end(), [&](uint32_t c) { return c <= most; });
  };
  if (report.vertexCount != vertices || report.weldedVertexCount != t.pointCount() ||
      report.triangleCount != triangles || report.usedTriangleCount != t.triangleCount() ||
      !allBelow({report.nonFiniteVertices}, vertices) ||
      !allBelow({report.nonFiniteTriangles, report.degenerateTriangles, report.duplicateTriangles,
                 report.usedTriangleCount},
                triangles) ||
      !allBelow({report.openEdges, report.nonManifoldEdges, report.misorientedEdges}, edges) ||
      !std::isfinite(report.volume))
    return Fault{Kind::kTopologyInfo, 0, "a number of the report is out of range"};
  if (auto f = checkBelow(Kind::kUsedIndices, t.indices, vertices)) return f;
  if (auto f = checkBelow(Kind::kSourceTriangles, t.sourceTriangles, triangles)) return f;
  if (auto f = checkBelow(Kind::kAdjacency, t.adjacency, t.triangleCount(), true)) return f;
  if (auto f = checkBelow(Kind::kWeldedVertices, t.weldedVertices, t.pointCount())) return f;
  if (auto f = checkBelow(Kind::kPointVertices, t.pointVertices, vertices)) return f;
  if (auto f = checkBelow(Kind::kPointCorners, t.pointCorners, t.indices.size())) return f;
  const std::vector<uint32_t>& offsets = t.pointOffsets;
  if (offsets.front() != 0 || offsets.back() != t.pointCorners.size() ||
      !std::is_sorted(offsets.begin(), offsets.end()))
    return Fault{Kind::kPointOffsets, 0, "the offsets do not ascend from 0 to the last corner"};
  return std::nullopt;
}

}  // namespace pelage::detail::cache
