// The .pelage file: header, table of sections, sections without gaps. Little endian;
// docs/formats.md describes it byte by byte.
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

// The last bytes find out when a program took the file for text.
inline constexpr std::array<char, 8> kMagic = {'P', 'E', 'L', 'A', 'G', 'E', '\r', '\n'};
inline constexpr uint32_t kByteOrder = 0x0a0b0c0d;
inline constexpr uint32_t kMaxItems = 4096;  ///< hairs, and meshes
inline constexpr uint32_t kMaxNameLength = 4095;
inline constexpr uint32_t kMaxFollowHairs = 0x7fffffff;
/// Not reached: a hair has fewer than 24 sections, as has a mesh.
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
/// Of header and table, which `bytes` starts with: of all but the field itself.
uint64_t headerChecksum(std::span<const std::byte> headerAndTable);

/// What is in a section. In the file come the infos, then the others by falling alignment, so that
/// there are no gaps; within these, by item and kind.
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
  kPlaceVertices,
  kPlaceOffsets,
  kPlaceCorners,
  // Bytes
  kSources = 60,
  kHairName,
  kHairBones,   ///< names
  kHairExtras,  ///< TfxFileLayout::extras
  kMeshName,
  kMeshBones,
};

/// What errors call it; nullptr when there is no such kind.
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
/// Whether a section comes before another one; a file has no two that are alike.
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
  uint32_t triangleCount = 0, placeCount = 0;
  uint32_t misorientedEdges = 0;
  double volume = 0;
};
static_assert(sizeof(TopologyInfo) == 64);
TopologyInfo infoOf(const ColliderTopology& topology);
MeshReport reportOf(const TopologyInfo& info);

/// Calls f(kind, vector, elements) for every array of a topology.
template <class Topology, class Function>
void forEachTopologyArray(Topology& topology, uint64_t vertices, uint64_t triangles,
                          uint64_t places, Function&& f) {
  f(Kind::kUsedIndices, topology.indices, 3 * triangles);
  f(Kind::kSourceTriangles, topology.sourceTriangles, triangles);
  f(Kind::kAdjacency, topology.adjacency, 3 * triangles);
  f(Kind::kWeldedVertices, topology.weldedVertices, vertices);
  f(Kind::kPlaceVertices, topology.placeVertices, places);
  f(Kind::kPlaceOffsets, topology.placeOffsets, places + 1);
  f(Kind::kPlaceCorners, topology.placeCorners, 3 * triangles);
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

/// A value that a section must not have.
struct Fault {
  Kind kind = Kind::kPositions;
  uint64_t offset = 0;  ///< of its bytes in the section
  std::string what;
};
/// What is wrong with the values of an item whose arrays have their sizes; nothing when all is
/// well.
std::optional<Fault> faultOf(const CachedHair& hair);
std::optional<Fault> faultOf(const CollisionMesh& mesh);
/// \param vertices, triangles of the mesh that it is of.
std::optional<Fault> faultOf(const ColliderTopology& topology, uint32_t vertices,
                             uint32_t triangles);

}  // namespace pelage::detail::cache
