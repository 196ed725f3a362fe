// Processed assets in one binary file, .pelage, that loads without parsing. docs/formats.md has the
// file byte by byte, docs/loading.md says when to use it.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "pelage/bone_weights.h"
#include "pelage/collision_mesh.h"
#include "pelage/hair_asset.h"
#include "pelage/result.h"
#include "pelage/stream.h"

namespace pelage {

/// What a cache was made from: a file, or any other bytes that its contents depend on, such as the
/// options of a converter.
struct SourceKey {
  std::string name;   ///< for the engine to find it again; of the tool: the path as it was given
  uint64_t size = 0;  ///< [bytes]
  uint64_t hash = 0;  ///< XXH3, 64 bits, of all bytes
  bool operator==(const SourceKey&) const = default;
};

struct CachedHair {
  std::string name;
  HairAsset asset;                   ///< after process()
  std::optional<BoneWeights> bones;  ///< of each guide
  std::vector<FollowHair> followHairs;
};

struct CachedMesh {
  std::string name;
  CollisionMesh mesh;  ///< loaded as if prepareCollider() was called on it
};

/// Contents of a cache.
struct AssetCache {
  std::vector<SourceKey> sources;
  std::vector<CachedHair> hairs;
  std::vector<CachedMesh> meshes;
};

/// Version of the files that this library writes, and the only one that it reads: a cache is made
/// again, never converted.
inline constexpr uint32_t kAssetCacheVersion = 1;

/// The key of some bytes.
SourceKey sourceKeyOf(std::span<const std::byte> bytes, std::string_view name);
/// The key of a file; its name is the path as it was given. Errors: those of reading it.
Result<SourceKey> sourceKeyOf(const std::filesystem::path& path);

/// The bytes of a .pelage file; the same contents give the same bytes. Errors: hair on which
/// process() was not called, or whose arrays were changed so that they do not fit together any
/// more; bone weights of another groom; a follow hair of a guide that does not exist; a mesh with
/// an index out of range; a value that is not finite; a name of more than 4095 bytes; more than
/// 4096 hairs or meshes.
Result<std::vector<std::byte>> saveAssetCache(const AssetCache& cache);
Result<void> saveAssetCache(const AssetCache& cache, const std::filesystem::path& path);

/// Loads a cache: the same bits as those that were saved. All of it is checked, the checksums and
/// what the sections mean, so that assets from any file are as safe as those of the other loaders.
/// The source is read in ascending order, each byte once. Errors name the byte, and the section
/// that it is in: another kind of file or version, truncation, a checksum that does not fit, and
/// what saveAssetCache() refuses.
Result<AssetCache> loadAssetCache(const std::filesystem::path& path);
/// The same from memory, or from a stream; `name` is what errors call it.
Result<AssetCache> loadAssetCache(std::span<const std::byte> bytes, std::string_view name);
Result<AssetCache> loadAssetCache(ByteSource& source, std::string_view name);

/// Only the keys of the sources, to find out whether a cache is stale: reads the table of the file
/// and that section. Errors: as above, as far as it reads.
Result<std::vector<SourceKey>> loadAssetCacheSources(ByteSource& source, std::string_view name);

/// The first of the keys whose file in a folder has changed or is not there any more; nothing when
/// the cache is fresh. \param folder what relative names start from.
std::optional<SourceKey> findStaleSource(std::span<const SourceKey> sources,
                                         const std::filesystem::path& folder);

}  // namespace pelage
