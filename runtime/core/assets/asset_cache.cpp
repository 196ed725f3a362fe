// Names of the sections of a .pelage file, and the keys of its sources.
#include "pelage/asset_cache.h"

#include <algorithm>
#include <cstddef>
#include <tuple>
#include <vector>

#include "assets/asset_cache_format.h"
#include "base/file_io.h"
#include "base/guard.h"
#include "base/hash.h"

namespace pelage {
namespace detail::cache {
namespace {

struct KindFormat {
  const char* name;
  Kind kind;
  uint32_t alignment;
};
constexpr KindFormat kFormats[] = {
    {"info", Kind::kHairInfo, 16},
    {"info", Kind::kMeshInfo, 16},
    {"topology", Kind::kTopologyInfo, 16},
    {"positions", Kind::kPositions, 16},
    {"vertex colors", Kind::kVertexColor, 16},
    {"rest frames", Kind::kRestFrames, 16},
    {"strand UV", Kind::kStrandUv, 8},
    {"vertex UV", Kind::kVertexUv, 8},
    {"vertex counts", Kind::kVertexCounts, 4},
    {"strand thickness", Kind::kStrandThickness, 4},
    {"rest lengths", Kind::kRestLengths, 4},
    {"rest vectors", Kind::kRestVectors, 4},
    {"tangents", Kind::kTangents, 4},
    {"inverse masses", Kind::kInverseMasses, 4},
    {"vertex thickness", Kind::kVertexThickness, 4},
    {"bone weights", Kind::kStrandBones, 4},
    {"follow hairs", Kind::kFollowHairs, 4},
    {"positions", Kind::kMeshPositions, 4},
    {"normals", Kind::kMeshNormals, 4},
    {"bone weights", Kind::kMeshInfluences, 4},
    {"indices", Kind::kMeshIndices, 4},
    {"used indices", Kind::kUsedIndices, 4},
    {"source triangles", Kind::kSourceTriangles, 4},
    {"adjacency", Kind::kAdjacency, 4},
    {"welded vertices", Kind::kWeldedVertices, 4},
    {"vertices of points", Kind::kPointVertices, 4},
    {"offsets of points", Kind::kPointOffsets, 4},
    {"corners of points", Kind::kPointCorners, 4},
    {"sources", Kind::kSources, 1},
    {"name", Kind::kHairName, 1},
    {"bone names", Kind::kHairBones, 1},
    {"extra bytes", Kind::kHairExtras, 1},
    {"name", Kind::kMeshName, 1},
    {"bone names", Kind::kMeshBones, 1},
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
      .pointCount = topology.pointCount(),
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
