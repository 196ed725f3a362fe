// Which bones move what: the .tfxbone file of a hair asset, and the mapping of bone names to the
// indices that an engine uses.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "pelage/result.h"
#include "pelage/stream.h"

namespace pelage {

/// A bone as a file names it.
struct BoneName {
  uint32_t index = 0;  ///< what the influences of the same file refer to; below the bone count
  std::string name;
  bool operator==(const BoneName&) const = default;
};

/// Up to four bones that move one strand's root or one mesh vertex.
struct BoneInfluences {
  uint32_t bones[4] = {0, 0, 0, 0};
  float weights[4] = {0, 0, 0, 0};  ///< >= 0; the sum is > 0, and need not be 1
  bool operator==(const BoneInfluences&) const = default;
};

/// Contents of a .tfxbone file.
struct BoneWeights {
  std::vector<BoneName> bones;          ///< in the file's order
  std::vector<BoneInfluences> strands;  ///< [strand]
  /// Strands whose weights summed to (almost) zero when the file was loaded; they follow the bone
  /// of their largest weight alone, the first one when all weights are zero.
  uint32_t repairedStrandCount = 0;
};

/// Loads a .tfxbone file. Strand records may come in any order; each strand must have exactly one.
/// `strandCount` is the number of strands that the hair has; 0 takes what the file says.
/// Errors name the byte offset: truncation, a name that is not NUL-terminated, an index out of
/// range, a duplicate bone or strand, a weight that is negative, not finite or above 1e6, another
/// strand count, bytes after the last record.
Result<BoneWeights> loadTfxBone(const std::filesystem::path& path, uint32_t strandCount = 0);
/// The same from memory, or from a stream, all of which is read at once; `name` is what errors call
/// it.
Result<BoneWeights> loadTfxBone(std::span<const std::byte> bytes, std::string_view name,
                                uint32_t strandCount = 0);
Result<BoneWeights> loadTfxBone(ByteSource& source, std::string_view name,
                                uint32_t strandCount = 0);

/// The bytes of a .tfxbone file, strands ascending. What loadTfxBone() read from a file with
/// ascending strands and without repairs gives the same bytes again.
Result<std::vector<std::byte>> saveTfxBone(const BoneWeights& weights);
Result<void> saveTfxBone(const BoneWeights& weights, const std::filesystem::path& path);

/// Gives the engine's index of a bone, or nothing when it has no such bone.
using BoneLookup = std::function<std::optional<uint32_t>(std::string_view name)>;

/// Replaces file bone indices by the engine's. Only bones with a weight > 0 are looked up; the
/// others take the index of the strand's heaviest bone, so that every index is valid. A bone that
/// the engine lacks takes `fallback`; without one it is an error that names the bone. Also an
/// error: an exception from the lookup, influences that name no bone of `bones`.
Result<std::vector<BoneInfluences>> mapBones(std::span<const BoneName> bones,
                                             std::span<const BoneInfluences> influences,
                                             const BoneLookup& lookup,
                                             std::optional<uint32_t> fallback = std::nullopt);

}  // namespace pelage
