// The hair of an object, for all rooms.
#pragma once

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "pelage/bone_weights.h"
#include "pelage/hair_asset.h"
#include "pelage/host_allocator.h"
#include "pelage/simulation_settings.h"

namespace pelage::detail {

/// The rest pose, which HairObject::setRestPose() changes.
struct RestPose {
  /// Positions and rest data, to fill buffers again when settings change.
  std::shared_ptr<const HairAsset> asset;
  uint64_t version = 0;     ///< rises with each change
  float longestStrand = 0;  ///< [m]
  float meanStrand = 0;     ///< mean length [m]
  float volume = 0;         ///< that the bind shape fills [m3]
};

/// The hair of an object as it was added; it never changes.
struct Groom {
  std::shared_ptr<const HairAsset> firstAsset;  ///< of addHair(): the order of strands goes by it
  std::vector<BoneInfluences> influences;       ///< [guide], or empty for bone 0
  std::vector<StrandFactors> strandFactors;     ///< [guide], or empty for 1
  std::vector<uint32_t> hairsOfGuides;          ///< that a guide stands for, with itself
  bool levelOfDetail = false;
  bool storesFollowHairs = false;
  bool collidesFollowHairs = false;  ///< they are stored, too
  bool heldVertices = false;         ///< beyond the two at the root
  float followRange = 0;     ///< largest offset of a follow hair at its root, and at its tip
  float followTipRange = 0;  ///< before the setting's tipSeparation [m]
  float meanThickness = 1, maxThickness = 1;     ///< of the factors of all strands
  uint32_t textureWidth = 0, textureHeight = 0;  ///< texels of the base color's texture
};

/// Returns false for NaN.
inline bool isCoordinate(float value) { return std::abs(value) <= kMaxCoordinate; }
/// Whether the asset is as process() left it. Errors: arrays of another size than the strands have,
/// rest data of no numbers; the message names the array and the strand.
Result<void> checkRestData(const HairAsset& asset);
/// Takes back what process() derived.
void clearRestData(HairAsset& asset);
/// [guide] bind position of vertex 0.
std::vector<Float4> bindRootsOf(const HairAsset& asset);
/// Length of the longest strand [m].
float longestStrand(const HairAsset& asset);
/// Vertices of a strand, without those that only fill its row up.
uint32_t vertexCountOf(const HairAsset& asset, uint32_t strand);
/// True where a vertex beyond the two at the root is held in the bind pose.
bool hasHeldVertices(const HairAsset& asset);

/// Contents of a buffer.
template <class T, class Memory>
HostArray<std::byte> bytesOf(const std::vector<T, Memory>& values) {
  const auto bytes = std::as_bytes(std::span(values));
  return {bytes.begin(), bytes.end()};
}

}  // namespace pelage::detail
