// Guide hair as loaded from a file, the data that the simulation derives from it, its size, and its
// follow hairs.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "pelage/bone_weights.h"
#include "pelage/export.h"
#include "pelage/result.h"
#include "pelage/stream.h"
#include "pelage/types.h"

namespace pelage {

inline constexpr uint32_t kMinVerticesPerStrand = 2;
inline constexpr uint32_t kMaxVerticesPerStrand = 256;
/// Maximum coordinate of an asset [m]; squares of coordinates, and their sums, stay finite in
/// float.
inline constexpr float kMaxCoordinate = 1e6f;
/// Minimum length of a segment with a direction [m]; shorter ones take the direction of the
/// previous segment.
inline constexpr float kMinSegmentLength = 1e-12f;

/// The contents of a .tfx file that are not hair data, kept so that saving gives the same bytes
/// again.
struct TfxFileLayout {
  uint32_t strandCount = 0, verticesPerStrand = 0;
  uint32_t offsets[5] = {0, 0, 0, 0, 0};  ///< positions, strand UV, vertex UV, thickness, color
  uint32_t reserved[32] = {};             ///< last words of the header
  struct Extra {
    uint64_t offset = 0;
    std::vector<std::byte> bytes;
  };
  std::vector<Extra> extras;  ///< byte ranges outside of the arrays, ascending
  uint64_t fileSize = 0;      ///< 0: the asset does not come from a file
};

/// How process() derives its data.
struct ProcessDef {
  /// Thickness of the tip relative to the root, 0..1; it falls linearly with arc length.
  float tipThickness = 0.3f;
};

/// Number and layout of follow hairs.
struct FollowDef {
  uint32_t countPerGuide = 0;  ///< 0..64
  /// Number of guides that shape each hair, 1..3: its own, and those with the nearest roots.
  uint32_t guidesPerHair = 1;
  float maxRadius = 0.004f;  ///< radius of the disc around the guide's root [m], 0..1
  /// Distance from the guide at the tip relative to that at the root, 0..100; 1 keeps the hair
  /// parallel.
  float tipSeparation = 1.0f;
  float flyaways = 0;  ///< share of hairs whose tips stand off, up to 4 radii farther, 0..1
  uint64_t seed = 1;
};

/// A hair that copies its guide, or the weighted mean of up to three guides.
struct FollowHair {
  uint32_t guide = 0;
  /// xyz: offset from the guide's root, or from the weighted mean of the guides' roots, to the root
  /// of this hair, in bind space [m]; it rotates with the root of `guide`. w: factor on it at the
  /// tip.
  Float4 offset;
  /// Further guides and their weights, 0..1. The weight of `guide` is 1 minus their sum.
  uint32_t otherGuides[2] = {0, 0};
  float otherWeights[2] = {0, 0};
  bool operator==(const FollowHair&) const = default;
};

/// Guide strands, all with the same number of vertices. Arrays are [strand][vertex] (the vertices
/// of a strand are contiguous) or [strand]; optional ones may be empty. Meters, in bind space.
///
/// Threads: as a standard container: several threads and scenes may read one while none writes.
struct PELAGE_API HairAsset {
  uint32_t strandCount = 0;        ///< >= 1
  uint32_t verticesPerStrand = 0;  ///< 2..256
  std::vector<Float4> positions;   ///< [strand][vertex] xyz [m], w = inverse mass, 0 = kinematic
  /// [strand] number of vertices of each strand, 2..verticesPerStrand; optional; without it all
  /// strands have verticesPerStrand. The exact solver does not simulate the vertices beyond it;
  /// process() moves them onto the tip.
  std::vector<uint32_t> vertexCounts;
  std::vector<Float2> strandUv;        ///< [strand] UV on the scalp's texture; optional
  std::vector<Float2> vertexUv;        ///< [strand][vertex]; optional
  std::vector<float> strandThickness;  ///< [strand] factor on the fiber radius, >= 0; optional
  std::vector<Float4> vertexColor;     ///< [strand][vertex] linear RGBA; optional
  TfxFileLayout fileLayout;

  /// Set by process(); empty before, and after one that failed. Edge i joins vertices i and i + 1.
  std::vector<float> restLengths;  ///< [strand][vertex] of edge i [m]; 0 at the last vertex
  /// [strand][vertex] rotation from the x axis to the edge that ends at the vertex (edge 0 for
  /// vertex 0), transported along the strand without twist.
  std::vector<Quaternion> restFrames;
  /// [strand][vertex] edge i in the frame of vertex i [m]; 0 at the last vertex.
  std::vector<Float3> restVectors;
  /// [strand][vertex] unit tangent: the direction from the previous to the next vertex; at the
  /// ends, the direction of the only edge. An edge without length has the direction of the previous
  /// one.
  std::vector<Float3> tangents;
  /// [strand][vertex] >= 0 and finite; 0 at vertices 0 and 1, which follow the bones.
  std::vector<float> inverseMasses;
  /// [strand][vertex] factor on the fiber radius: that of the strand, tapered to the tip.
  std::vector<float> vertexThickness;
  uint64_t degenerateSegmentCount = 0;  ///< segments shorter than kMinSegmentLength

  /// Derives the rest data. Errors: counts and array sizes that do not match, a value that is not
  /// finite or out of range; the message names strand and vertex. Zero-length segments are valid.
  /// After an error the asset has no rest data, also where an earlier call made some. The numbers
  /// are the same on every machine.
  Result<void> process(const ProcessDef& def = {});

  /// Returns follow hairs of all guides, countPerGuide of each, with roots uniform in a disc, in
  /// spreadOrder(). The same seed gives the same hairs. The roots do not depend on other guides,
  /// nor on countPerGuide. With several guides per hair, weights are proportional to 1 / (d^2 +
  /// maxRadius^2), where d is the distance of the roots. Needs only positions. Errors: an asset
  /// that process() refuses, a value of `def` out of range.
  Result<std::vector<FollowHair>> generateFollowHairs(const FollowDef& def) const;
};

/// Returns the order in which the first of the follow hairs are spread over all guides, so that
/// HairObject::drawnShare leaves no gaps: rounds of one hair a guide, in which guides follow each
/// other in steps of the golden ratio. Hairs of one guide keep their order.
/// \param guides  [follow hair] FollowHair::guide. Asserts that each is below guideCount; if not,
///                returns nothing.
PELAGE_API std::vector<uint32_t> spreadOrder(std::span<const uint32_t> guides, uint32_t guideCount);

/// Checks counts, array sizes and values, as process() does.
PELAGE_API Result<void> validate(const HairAsset& asset);

/// Returns the array that the simulation kernels read as g_rest, [2][vertex][strand] with the
/// strand fastest. First half: bind position, w = inverse mass as 0 or 1. Second half: rest vector
/// of the edge that starts at the vertex, w = its rest length; at the last vertex, where no edge
/// starts, the frame of edge 0 as a quaternion. Error: process() was not called.
PELAGE_API Result<std::vector<Float4>> packRest(const HairAsset& asset);

struct TfxLoadOptions {
  /// False: a value that is not finite or out of range is an error. True: it is replaced and
  /// counted. A position becomes that of the nearest valid vertex before it on the strand, or after
  /// it if there is none before (a strand without any valid vertex is an error). An inverse mass
  /// becomes 0 on vertices 0 and 1, and 1 elsewhere; UV and color become 0, a thickness 1.
  bool repair = false;
  /// Loads only the first strands of the file, >= 1: for a quick look, or a coarse level of a groom
  /// whose strands are in random order. Of a stream, only their bytes are read.
  uint32_t maxStrands = 0xffffffffu;
  /// Optional arrays that are loaded if the file has them; the others are not read.
  bool strandUv = true, vertexUv = true, strandThickness = true, vertexColor = true;
};

struct TfxLoadReport {
  uint64_t repairedCount = 0;      ///< values replaced
  uint64_t firstRepairOffset = 0;  ///< byte offset of the first one
};

/// Loads a .tfx file, version 4.0, and validates all of it; does not call process(). Errors name
/// the byte offset: truncation, another version, counts out of range (a file without strands is
/// refused), arrays that exceed the file or overlap, and everything that TfxLoadOptions repairs.
/// saveTfx() saves a partly loaded asset as a file of its own.
PELAGE_API Result<HairAsset> loadTfx(const std::filesystem::path& path,
                                     const TfxLoadOptions& options = {},
                                     TfxLoadReport* report = nullptr);
/// The same from memory, or from a stream; `name` names it in errors. If no parts are left out,
/// each byte of a stream is read once.
PELAGE_API Result<HairAsset> loadTfx(std::span<const std::byte> bytes, std::string_view name,
                                     const TfxLoadOptions& options = {},
                                     TfxLoadReport* report = nullptr);
PELAGE_API Result<HairAsset> loadTfx(ByteSource& source, std::string_view name,
                                     const TfxLoadOptions& options = {},
                                     TfxLoadReport* report = nullptr);

/// Returns the bytes of a .tfx file. An asset from loadTfx() (without repairs) gives the bytes it
/// came from. If its counts or arrays have changed, or it came from elsewhere, the arrays follow
/// the header in the order of the offsets.
PELAGE_API Result<std::vector<std::byte>> saveTfx(const HairAsset& asset);
PELAGE_API Result<void> saveTfx(const HairAsset& asset, const std::filesystem::path& path);

/// Returns the bytes of a .tfxfollow file, version 1 (docs/assets_formats.md). \param guideCount
/// number of guides, >= 1. Errors: a guide that is not below guideCount, a value that is not finite
/// or beyond
/// +-1e6, weights that are not within 0..1 or sum to more than 1; the message names the hair.
PELAGE_API Result<std::vector<std::byte>> saveFollowHairs(std::span<const FollowHair> hairs,
                                                          uint32_t guideCount);
PELAGE_API Result<void> saveFollowHairs(std::span<const FollowHair> hairs, uint32_t guideCount,
                                        const std::filesystem::path& path);

/// Loads a .tfxfollow file and checks all of it; saving gives the same bytes again. \param
/// guideCount number of guides of the asset that the hairs follow; 0 accepts any number. Errors
/// name the byte offset: no .tfxfollow file, another version, another number of guides, a file
/// whose size differs from that in its header, and everything that saveFollowHairs() refuses.
PELAGE_API Result<std::vector<FollowHair>> loadFollowHairs(const std::filesystem::path& path,
                                                           uint32_t guideCount);
/// The same from memory, or from a stream, which is read at once; `name` names it in errors.
PELAGE_API Result<std::vector<FollowHair>> loadFollowHairs(std::span<const std::byte> bytes,
                                                           std::string_view name,
                                                           uint32_t guideCount);
PELAGE_API Result<std::vector<FollowHair>> loadFollowHairs(ByteSource& source,
                                                           std::string_view name,
                                                           uint32_t guideCount);

/// Mean strand lengths [m] within which a groom is taken for one in meters.
inline constexpr double kMinMeanLength = 0.001, kMaxMeanLength = 3;

struct HairSize {
  double meanLength = 0;  ///< mean length of the strands, along their vertices [m]
  double maxLength = 0;   ///< length of the longest strand [m]
  Float3 low, high;       ///< bounds of the vertices [m]
};

/// Returns the size of a groom, as loaded or processed. Vertices beyond HairAsset::vertexCounts do
/// not count. Costs one pass over the positions. Errors: an asset that validate() refuses.
PELAGE_API Result<HairSize> measureHair(const HairAsset& asset);

/// A unit that a groom may be in.
struct UnitGuess {
  const char* unit = "";  ///< "centimeters"
  float scale = 1;        ///< meters per unit, for scaleHair()
  double meanLength = 0;  ///< mean length of the strands with this scale [m]
};

/// Returns the units with which strands of this mean length would be of a size that hair has, the
/// likeliest first; empty if the length is within kMinMeanLength..kMaxMeanLength, or if no usual
/// unit explains it. \param meanLength HairSize::meanLength.
PELAGE_API std::vector<UnitGuess> guessUnits(double meanLength);

/// Returns one line about strands that are too long or too short for meters, with the likely units
/// and their scales; empty if nothing is wrong.
PELAGE_API std::string unitWarning(const HairSize& size);

/// Multiplies all positions, and clears what process() has derived from them: call it again. Scale
/// follow hairs and collision meshes with it: FollowHair::offset.x, y and z, and
/// CollisionMesh::positions. \param scale meters per unit, 1e-9..1e9. Errors, after which the asset
/// is as it was: a scale out of range, a coordinate beyond kMaxCoordinate.
PELAGE_API Result<void> scaleHair(HairAsset& asset, float scale);

}  // namespace pelage
