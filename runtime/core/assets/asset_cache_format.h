// The .pelage file: header, table of sections, sections without gaps, little endian. The format is
// private to a version of the library; docs/assets_formats.md says what a file holds.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>

#include "assets/collider_topology.h"
#include "pelage/asset_cache.h"

namespace pelage::detail::cache {

// The last bytes detect that a program treated the file as text.
inline constexpr std::array<char, 8> kMagic = {'P', 'E', 'L', 'A', 'G', 'E', '\r', '\n'};
inline constexpr uint32_t kByteOrder = 0x0a0b0c0d;
inline constexpr uint32_t kMaxItems = 4096;  ///< maximum number of hairs, and of meshes
inline constexpr uint32_t kMaxNameLength = 4095;
inline constexpr uint32_t kMaxFollowHairs = 0x7fffffff;
/// An upper bound: a hair has fewer than 24 sections, as has a mesh.
inline constexpr uint32_t kMaxSections = 2 * 24 * kMaxItems;

struct Header {
  std::array<char, 8> magic = kMagic;
  uint32_t version = kAssetCacheVersion;
  uint32_t byteOrder = kByteOrder;
  uint64_t fileSize = 0;
  uint32_t sectionCount = 0;
  uint32_t hairCount = 0;
  uint32_t meshCount = 0;
  uint32_t reserved = 0;  ///< 0
  uint64_t checksum = 0;  ///< see headerChecksum()
};
static_assert(sizeof(Header) == 48);
/// Checksum of header and table, at the start of `bytes`, without the field itself.
uint64_t headerChecksum(std::span<const std::byte> headerAndTable);

/// The contents of a section. The file has the infos first, then the others by decreasing
/// alignment, so that it has no gaps; within these, by item and kind.
enum class Kind : uint32_t {
  kHairInfo = 1,      ///< HairInfo
  kMeshInfo = 2,      ///< MeshInfo
  kTopologyInfo = 3,  ///< TopologyInfo of a mesh
  // HairAsset
  kPositions = 10,
  kVertexColor,
  kRestFrames,
  kStrandUv,
  kVertexUv,
  kVertexCounts,
  kStrandThickness,
  kRestLengths,
  kRestVectors,
  kTangents,
  kInverseMasses,
  kVertexThickness,
  kStrandBones,  ///< BoneInfluences [strand]
  kFollowHairs,
  // CollisionMesh
  kMeshPositions = 40,
  kMeshNormals,
  kMeshInfluences,
  kMeshIndices,
  // ColliderTopology
  kUsedIndices,
  kSourceTriangles,
  kAdjacency,
  kWeldedVertices,
  kPointVertices,
  kPointOffsets,
  kPointCorners,
  // Bytes
  kSources = 60,
  kHairName,
  kHairBones,   ///< names
  kHairExtras,  ///< TfxFileLayout::extras
  kMeshName,
  kMeshBones,
};

/// Name of a kind in errors; nullptr if there is no such kind.
const char* nameOf(Kind kind);
/// Alignment of the section in the file, 16, 8, 4 or 1; its size is a multiple of it.
uint32_t alignmentOf(Kind kind);
bool belongsToMesh(Kind kind);
bool isInfo(Kind kind);

struct Section {
  uint32_t kind = 0;
  uint32_t item = 0;  ///< hair or mesh that it belongs to
  uint64_t offset = 0, size = 0;
  uint32_t alignment = 0;
  uint32_t reserved = 0;  ///< 0
  uint64_t checksum = 0;
  uint64_t reserved2 = 0;  ///< 0
};
static_assert(sizeof(Section) == 48);
/// Returns true if a section comes before another one; a file has no two equal ones.
bool comesBefore(const Section& a, const Section& b);

struct HairInfo {
  uint32_t strandCount = 0, verticesPerStrand = 0;
  uint32_t followCount = 0;
  uint32_t boneCount = 0;  ///< 0: without bone weights
  uint32_t repairedStrandCount = 0;
  uint32_t layoutExtraCount = 0;
  uint64_t degenerateSegmentCount = 0;
  // TfxFileLayout
  uint32_t layoutStrandCount = 0, layoutVerticesPerStrand = 0;
  uint64_t layoutFileSize = 0;
  uint32_t layoutOffsets[5] = {};
  uint32_t layoutReserved[32] = {};
  uint32_t reserved[3] = {};  ///< 0
};
static_assert(sizeof(HairInfo) == 208 && sizeof(HairInfo) % alignof(HairInfo) == 0);

struct MeshInfo {
  uint32_t vertexCount = 0, triangleCount = 0, boneCount = 0, repairedVertexCount = 0;
};
static_assert(sizeof(MeshInfo) == 16);

/// MeshReport, and the sizes of the arrays.
struct TopologyInfo {
  uint32_t counts[10] = {};  ///< the first of MeshReport, in its order
  uint32_t flags = 0;        ///< bit 0 closed, 1 consistently oriented, 2 inverted
  uint32_t triangleCount = 0, pointCount = 0;
  uint32_t misorientedEdges = 0;
  double volume = 0;
};
static_assert(sizeof(TopologyInfo) == 64);
TopologyInfo infoOf(const ColliderTopology& topology);
MeshReport reportOf(const TopologyInfo& info);

/// Calls f(kind, vector, elements) for every array of a topology.
template <class Topology, class Function>
void forEachTopologyArray(Topology& topology, uint64_t vertices, uint64_t triangles, uint64_t slots,
                          Function&& f) {
  f(Kind::kUsedIndices, topology.indices, 3 * triangles);
  f(Kind::kSourceTriangles, topology.sourceTriangles, triangles);
  f(Kind::kAdjacency, topology.adjacency, 3 * triangles);
  f(Kind::kWeldedVertices, topology.weldedVertices, vertices);
  f(Kind::kPointVertices, topology.pointVertices, slots);
  f(Kind::kPointOffsets, topology.pointOffsets, slots + 1);
  f(Kind::kPointCorners, topology.pointCorners, 3 * triangles);
}

/// Calls f(kind, vector, elements a full array has, optional) for every array of hair whose
/// elements are plain.
template <class Asset, class Function>
void forEachArray(Asset& asset, uint64_t strands, uint64_t vertices, Function&& f) {
  f(Kind::kPositions, asset.positions, vertices, false);
  f(Kind::kVertexColor, asset.vertexColor, vertices, true);
  f(Kind::kRestFrames, asset.restFrames, vertices, false);
  f(Kind::kStrandUv, asset.strandUv, strands, true);
  f(Kind::kVertexUv, asset.vertexUv, vertices, true);
  f(Kind::kVertexCounts, asset.vertexCounts, strands, true);
  f(Kind::kStrandThickness, asset.strandThickness, strands, true);
  f(Kind::kRestLengths, asset.restLengths, vertices, false);
  f(Kind::kRestVectors, asset.restVectors, vertices, false);
  f(Kind::kTangents, asset.tangents, vertices, false);
  f(Kind::kInverseMasses, asset.inverseMasses, vertices, false);
  f(Kind::kVertexThickness, asset.vertexThickness, vertices, false);
}

/// An invalid value of a section.
struct Fault {
  Kind kind = Kind::kPositions;
  uint64_t offset = 0;  ///< of its bytes in the section
  std::string what;
};
/// Returns the error in the values of an item whose arrays have their sizes; nothing if there is
/// none.
std::optional<Fault> faultOf(const CachedHair& hair);
std::optional<Fault> faultOf(const CollisionMesh& mesh);
/// \param vertices, triangles numbers of the mesh.
std::optional<Fault> faultOf(const ColliderTopology& topology, uint32_t vertices,
                             uint32_t triangles);

}  // namespace pelage::detail::cache
