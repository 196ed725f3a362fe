// Guide hair as it comes from a file or from an artist, and what the simulation derives from it.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>
#include <string_view>
#include <vector>

#include "pelage/bone_weights.h"
#include "pelage/result.h"
#include "pelage/stream.h"
#include "pelage/types.h"

namespace pelage {

inline constexpr uint32_t kMinVerticesPerStrand = 2;
inline constexpr uint32_t kMaxVerticesPerStrand = 256;
/// Largest coordinate that an asset may have [m]; squares and sums of them stay finite in float.
inline constexpr float kMaxCoordinate = 1e6f;
/// Shorter segments have no direction of their own; they take the one of the segment before [m].
inline constexpr float kMinSegmentLength = 1e-12f;

/// What of a .tfx file is not hair data, kept so that saving gives the same bytes again.
struct TfxFileLayout {
  uint32_t strandCount = 0, verticesPerStrand = 0;
  uint32_t offsets[5] = {0, 0, 0, 0, 0};  ///< positions, strand UV, vertex UV, thickness, colour
  uint32_t reserved[32] = {};             ///< last words of the header
  struct Extra {
    uint64_t offset = 0;
    std::vector<std::byte> bytes;
  };
  std::vector<Extra> extras;  ///< bytes that no array covers, ascending
  uint64_t fileSize = 0;      ///< 0: the asset does not come from a file
};

/// How process() derives its data.
struct ProcessDef {
  /// Thickness of the tip relative to the root, 0..1; between them it falls linearly with the arc
  /// length.
  float tipThickness = 0.3f;
};

/// How many follow hairs each guide gets, and where.
struct FollowDef {
  uint32_t countPerGuide = 0;  ///< 0..64
  /// Guides that each hair takes its shape from, 1..3: its own, and those whose roots are nearest.
  uint32_t guidesPerHair = 1;
  float maxRadius = 0.004f;  ///< of the disc around the guide's root [m], 0..1
  /// Distance from the guide at the tip relative to that at the root, 0..100; 1 is parallel.
  float tipSeparation = 1.0f;
  uint64_t seed = 1;
};

/// A hair that copies its guide, or the weighted mean of up to three guides.
struct FollowHair {
  uint32_t guide = 0;
  /// xyz: from the guide's root, or the weighted mean of the guides' roots, to this one in bind
  /// space [m]; it turns with the root of `guide`. w: factor on it at the tip.
  Float4 offset;
  /// Further guides, and their weights, 0..1. `guide` has the rest of 1.
  uint32_t otherGuides[2] = {0, 0};
  float otherWeights[2] = {0, 0};
  bool operator==(const FollowHair&) const = default;
};

/// Guide strands, all with the same number of vertices. Arrays are [strand][vertex] (a strand's
/// vertices are neighbours) or [strand]; optional ones are empty. Metres, in bind space.
struct HairAsset {
  uint32_t strandCount = 0;        ///< >= 1
  uint32_t verticesPerStrand = 0;  ///< 2..256
  std::vector<Float4> positions;   ///< [strand][vertex] xyz [m], w = inverse mass, 0 = kinematic
  /// [strand] vertices of each strand, 2..verticesPerStrand; optional, all have verticesPerStrand
  /// without it. Vertices beyond them are not simulated by the exact solver; process() puts them
  /// onto the tip.
  std::vector<uint32_t> vertexCounts;
  std::vector<Float2> strandUv;        ///< [strand] on the scalp's texture; optional
  std::vector<Float2> vertexUv;        ///< [strand][vertex]; optional
  std::vector<float> strandThickness;  ///< [strand] factor on the fibre radius, >= 0; optional
  std::vector<Float4> vertexColor;     ///< [strand][vertex] linear RGBA; optional
  TfxFileLayout fileLayout;

  /// Set by process(); empty before. "Edge i" joins vertex i and i + 1.
  std::vector<float> restLengths;  ///< [strand][vertex] of edge i [m]; 0 at the last vertex
  /// [strand][vertex] rotation from the x axis to the edge that arrives at the vertex (edge 0 for
  /// vertex 0), carried along the strand without twist.
  std::vector<Quaternion> restFrames;
  /// [strand][vertex] edge i in the frame of vertex i [m]; 0 at the last vertex.
  std::vector<Float3> restVectors;
  /// [strand][vertex] unit tangent: the direction from the vertex before to the one after; at the
  /// ends that of the only edge. An edge without length has the direction of the one before.
  std::vector<Float3> tangents;
  /// [strand][vertex] >= 0 and finite; 0 at vertices 0 and 1, which follow the bones.
  std::vector<float> inverseMasses;
  /// [strand][vertex] factor on the fibre radius: the strand's, tapered to the tip.
  std::vector<float> vertexThickness;
  uint64_t degenerateSegmentCount = 0;  ///< segments shorter than kMinSegmentLength

  /// Derives the rest data. Errors: counts and array sizes that do not fit together, a value that
  /// is not finite or out of its range; the message names strand and vertex. Zero-length segments
  /// are fine. The numbers are the same on every machine.
  Result<void> process(const ProcessDef& def = {});

  /// Follow hairs of all guides, countPerGuide neighbouring ones a guide; roots uniform in a disc.
  /// The same seed gives the same hairs. Their roots do not depend on other guides. With several
  /// guides a hair, weights go with 1 / (d^2 + maxRadius^2), d the distance of the roots. Needs
  /// only positions. Errors: an asset that process() would refuse, a value of `def` out of range.
  Result<std::vector<FollowHair>> generateFollowHairs(const FollowDef& def) const;
};

/// Checks counts, array sizes and values, as process() does.
Result<void> validate(const HairAsset& asset);

/// What the simulation kernels read as g_rest, [2][vertex][strand] with the strand fastest. First
/// half: bind position, w = inverse mass as 0 or 1. Second half: rest vector of the leaving edge,
/// w = its rest length; at the last vertex, which no edge leaves, the frame of edge 0 as a
/// quaternion. An error when process() was not called.
Result<std::vector<Float4>> packRest(const HairAsset& asset);

struct TfxLoadOptions {
  /// False: a value that is not finite or out of range is an error. True: it is replaced and
  /// counted. A position takes the nearest good vertex before it on the strand, or after it when
  /// there is none before (a strand without any good vertex is an error); an inverse mass becomes 0
  /// on vertices 0 and 1 and 1 elsewhere; UV and colour become 0, a thickness 1.
  bool repair = false;
  /// The first strands of the file, >= 1: for a quick look, or a coarse level of a groom whose
  /// strands are in random order. Of a stream, only their bytes are read.
  uint32_t maxStrands = 0xffffffffu;
  /// Optional arrays that are taken when the file has them; the others are not even read.
  bool strandUv = true, vertexUv = true, strandThickness = true, vertexColor = true;
};

struct TfxLoadReport {
  uint64_t repairedCount = 0;      ///< values replaced
  uint64_t firstRepairOffset = 0;  ///< byte offset of the first one
};

/// Loads a .tfx file, version 4.0, and validates all of it; does not call process(). Errors name
/// the byte offset: truncation, another version, counts out of range (a file without strands is
/// refused), arrays that leave the file or overlap, and what TfxLoadOptions repairs. Of an asset
/// that is only a part, saveTfx() makes a file of its own.
Result<HairAsset> loadTfx(const std::filesystem::path& path, const TfxLoadOptions& options = {},
                          TfxLoadReport* report = nullptr);
/// The same from memory, or from a stream; `name` is what errors call it. Without parts left out,
/// each byte of a stream is read once.
Result<HairAsset> loadTfx(std::span<const std::byte> bytes, std::string_view name,
                          const TfxLoadOptions& options = {}, TfxLoadReport* report = nullptr);
Result<HairAsset> loadTfx(ByteSource& source, std::string_view name,
                          const TfxLoadOptions& options = {}, TfxLoadReport* report = nullptr);

/// The bytes of a .tfx file. An asset from loadTfx() (without repairs) gives the bytes it came
/// from; when its counts or arrays have changed, or it was made otherwise, the arrays follow the
/// header in the order of the offsets.
Result<std::vector<std::byte>> saveTfx(const HairAsset& asset);
Result<void> saveTfx(const HairAsset& asset, const std::filesystem::path& path);

}  // namespace pelage
