// What the sections of a .pelage file are called, and the keys of its sources.
#include "pelage/asset_cache.h"

#include <algorithm>
#include <cstddef>
#include <tuple>
#include <vector>

#include "asset_cache_format.h"
#include "file_io.h"
#include "guard.h"
#include "hash.h"

namespace pelage {
namespace detail::cache {
namespace {

struct KindFormat {
  Kind kind;
  const char* name;
  uint32_t alignment;
};
constexpr KindFormat kFormats[] = {
    {Kind::kHairInfo, "info", 16},
    {Kind::kMeshInfo, "info", 16},
    {Kind::kTopologyInfo, "topology", 16},
    {Kind::kPositions, "positions", 16},
    {Kind::kVertexColor, "vertex colours", 16},
    {Kind::kRestFrames, "rest frames", 16},
    {Kind::kStrandUv, "strand UV", 8},
    {Kind::kVertexUv, "vertex UV", 8},
    {Kind::kVertexCounts, "vertex counts", 4},
    {Kind::kStrandThickness, "strand thickness", 4},
    {Kind::kRestLengths, "rest lengths", 4},
    {Kind::kRestVectors, "rest vectors", 4},
    {Kind::kTangents, "tangents", 4},
    {Kind::kInverseMasses, "inverse masses", 4},
    {Kind::kVertexThickness, "vertex thickness", 4},
    {Kind::kStrandBones, "bone weights", 4},
    {Kind::kFollowHairs, "follow hairs", 4},
    {Kind::kMeshPositions, "positions", 4},
    {Kind::kMeshNormals, "normals", 4},
    {Kind::kMeshInfluences, "bone weights", 4},
    {Kind::kMeshIndices, "indices", 4},
    {Kind::kUsedIndices, "used indices", 4},
    {Kind::kSourceTriangles, "source triangles", 4},
    {Kind::kAdjacency, "adjacency", 4},
    {Kind::kWeldedVertices, "welded vertices", 4},
    {Kind::kPlaceVertices, "vertices of places", 4},
    {Kind::kPlaceOffsets, "offsets of places", 4},
    {Kind::kPlaceCorners, "corners of places", 4},
    {Kind::kSources, "sources", 1},
    {Kind::kHairName, "name", 1},
    {Kind::kHairBones, "bone names", 1},
    {Kind::kHairExtras, "extra bytes", 1},
    {Kind::kMeshName, "name", 1},
    {Kind::kMeshBones, "bone names", 1},
};

const KindFormat* formatOf(Kind kind) {
  for (const KindFormat& format : kFormats)
    if (format.kind == kind) return &format;
  return nullptr;
}

}  // namespace

uint64_t headerChecksum(std::span<const std::byte> headerAndTable) {
  std::vector<std::byte> bytes(headerAndTable.begin(), headerAndTable.end());
  std::fill_n(bytes.begin() + offsetof(Header, checksum), sizeof(uint64_t), std::byte{0});
  return detail::hash64(bytes);
}

const char* nameOf(Kind kind) {
  const KindFormat* format = formatOf(kind);
  return format != nullptr ? format->name : nullptr;
}

uint32_t alignmentOf(Kind kind) {
  const KindFormat* format = formatOf(kind);
  return format != nullptr ? format->alignment : 1;
}

bool belongsToMesh(Kind kind) {
  return kind == Kind::kMeshInfo || kind == Kind::kTopologyInfo ||
         (kind >= Kind::kMeshPositions && kind < Kind::kSources) || kind >= Kind::kMeshName;
}

bool isInfo(Kind kind) { return kind <= Kind::kTopologyInfo; }

TopologyInfo infoOf(const ColliderTopology& topology) {
  const MeshReport& r = topology.report;
  return {
      .counts = {r.vertexCount, r.weldedVertexCount, r.triangleCount, r.usedTriangleCount,
                 r.nonFiniteVertices, r.nonFiniteTriangles, r.degenerateTriangles,
                 r.duplicateTriangles, r.openEdges, r.nonManifoldEdges},
      .flags = (r.closed ? 1u : 0u) | (r.consistentlyOriented ? 2u : 0u) | (r.inverted ? 4u : 0u),
      .triangleCount = topology.triangleCount(),
      .placeCount = topology.placeCount(),
      .misorientedEdges = r.misorientedEdges,
      .volume = r.volume};
}

MeshReport reportOf(const TopologyInfo& info) {
  const uint32_t* c = info.counts;
  return {.vertexCount = c[0],
          .weldedVertexCount = c[1],
          .triangleCount = c[2],
          .usedTriangleCount = c[3],
          .nonFiniteVertices = c[4],
          .nonFiniteTriangles = c[5],
          .degenerateTriangles = c[6],
          .duplicateTriangles = c[7],
          .openEdges = c[8],
          .nonManifoldEdges = c[9],
          .misorientedEdges = info.misorientedEdges,
          .volume = info.volume,
          .closed = (info.flags & 1) != 0,
          .consistentlyOriented = (info.flags & 2) != 0,
          .inverted = (info.flags & 4) != 0};
}

bool comesBefore(const Section& a, const Section& b) {
  const auto key = [](const Section& s) {
    const auto kind = static_cast<Kind>(s.kind);
    // Infos of hairs before those of meshes; arrays of an item together.
    const uint32_t group = isInfo(kind) ? s.kind : 1000 - alignmentOf(kind);
    return std::tuple(group, belongsToMesh(kind), s.item, s.kind);
  };
  return key(a) < key(b);
}

}  // namespace detail::cache

SourceKey sourceKeyOf(std::span<const std::byte> bytes, std::string_view name) {
  return {.name = std::string(name), .size = bytes.size(), .hash = detail::hash64(bytes)};
}

Result<SourceKey> sourceKeyOf(const std::filesystem::path& path) {
  return detail::guarded([&]() -> Result<SourceKey> {
    const auto bytes = detail::readFile(path);
    if (!bytes) return bytes.error();
    return sourceKeyOf(*bytes, path.string());
  });
}

std::optional<SourceKey> findStaleSource(std::span<const SourceKey> sources,
                                         const std::filesystem::path& folder) {
  for (const SourceKey& source : sources) {
    const Result<SourceKey> now = sourceKeyOf(folder / source.name);
    if (!now || now->size != source.size || now->hash != source.hash) return source;
  }
  return std::nullopt;
}

}  // namespace pelage
