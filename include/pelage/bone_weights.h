// Bone weights: the .tfxbone file of a hair asset, and the mapping of bone names to the indices of
// an engine.
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

#include "pelage/export.h"
#include "pelage/result.h"
#include "pelage/stream.h"

namespace pelage {

/// How the bones of a root are blended.
enum class SkinningMethod : uint8_t {
  kMatrices,         ///< weighted sum of matrices, then the closest rotation
  kDualQuaternions,  ///< dual quaternion blending (Kavan et al. 2008); bones without scale
};

/// A bone as named in a file.
struct BoneName {
  uint32_t index = 0;  ///< used by the influences of the same file; below the bone count
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
  /// Number of strands whose weights summed to (almost) zero in the loaded file; each follows only
  /// the bone of its largest weight, or the first bone if all weights are zero.
  uint32_t repairedStrandCount = 0;
};

/// Loads a .tfxbone file. Strand records may come in any order; each strand must have exactly one.
/// `strandCount` is the number of strands of the hair; 0 accepts any number. Errors name the byte
/// offset: truncation, a name that is not NUL-terminated, an index out of range, a duplicate bone
/// or strand, a weight that is negative, not finite or above 1e6, another strand count, bytes after
/// the last record.
PELAGE_API Result<BoneWeights> loadTfxBone(const std::filesystem::path& path,
                                           uint32_t strandCount = 0);
/// The same from memory, or from a stream, which is read at once; `name` names it in errors.
PELAGE_API Result<BoneWeights> loadTfxBone(std::span<const std::byte> bytes, std::string_view name,
                                           uint32_t strandCount = 0);
PELAGE_API Result<BoneWeights> loadTfxBone(ByteSource& source, std::string_view name,
                                           uint32_t strandCount = 0);

/// Returns the bytes of a .tfxbone file, strands ascending. A file with ascending strands and
/// without repairs gives the same bytes again.
PELAGE_API Result<std::vector<std::byte>> saveTfxBone(const BoneWeights& weights);
PELAGE_API Result<void> saveTfxBone(const BoneWeights& weights, const std::filesystem::path& path);

/// Returns the engine's index of a bone, or nothing if the engine has no such bone.
using BoneLookup = std::function<std::optional<uint32_t>(std::string_view name)>;

/// Replaces bone indices of the file by those of the engine. Looks up only bones with a weight > 0;
/// the others get the index of the strand's heaviest bone, so every index is valid. A bone that the
/// engine lacks gets `fallback`. Errors: a missing bone without `fallback` (the error names it), an
/// exception from the lookup, influences that refer to no bone of `bones`.
PELAGE_API Result<std::vector<BoneInfluences>> mapBones(
    std::span<const BoneName> bones, std::span<const BoneInfluences> influences,
    const BoneLookup& lookup, std::optional<uint32_t> fallback = std::nullopt);

}  // namespace pelage
