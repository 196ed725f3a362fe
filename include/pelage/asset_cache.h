// Processed assets in one binary file, .pelage, that loads without parsing: docs/assets.md.
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
#include "pelage/export.h"
#include "pelage/hair_asset.h"
#include "pelage/result.h"
#include "pelage/stream.h"

namespace pelage {

/// A source of a cache: a file, or any other bytes that its contents depend on, such as the options
/// of a converter.
struct SourceKey {
  std::string name;   ///< finds the source again; pelage-convert stores the path as given
  uint64_t size = 0;  ///< [bytes]
  uint64_t hash = 0;  ///< XXH3, 64 bits, of all bytes
  bool operator==(const SourceKey&) const = default;
};

struct CachedHair {
  std::string name;
  HairAsset asset;                   ///< process() has been called
  std::optional<BoneWeights> bones;  ///< of each guide
  std::vector<FollowHair> followHairs;
};

struct CachedMesh {
  std::string name;
  CollisionMesh mesh;  ///< loaded as if prepareCollider() had been called
};

/// Contents of a cache.
struct AssetCache {
  std::vector<SourceKey> sources;
  std::vector<CachedHair> hairs;
  std::vector<CachedMesh> meshes;
};

/// Version of the files that this library writes, and the only one that it reads: make a cache
/// again; it is never converted.
inline constexpr uint32_t kAssetCacheVersion = 1;

/// Returns the key of some bytes.
PELAGE_API SourceKey sourceKeyOf(std::span<const std::byte> bytes, std::string_view name);
/// Returns the key of a file; its name is the path as given. Errors: those of reading the file.
PELAGE_API Result<SourceKey> sourceKeyOf(const std::filesystem::path& path);

/// Returns the bytes of a .pelage file; the same contents give the same bytes. Errors: hair on
/// which process() was not called, or whose arrays have changed and no longer fit together; bone
/// weights of another groom; a follow hair of a guide that does not exist; a mesh with an index out
/// of range; a value that is not finite; a name of more than 4095 bytes; more than 4096 hairs or
/// meshes.
PELAGE_API Result<std::vector<std::byte>> saveAssetCache(const AssetCache& cache);
PELAGE_API Result<void> saveAssetCache(const AssetCache& cache, const std::filesystem::path& path);

/// Loads a cache, with the same bits that were saved. It checks everything, the checksums and the
/// contents of the sections, so that assets from any file are as safe as those of the other
/// loaders. It reads the source in ascending order, each byte once. Errors name the byte and its
/// section: another kind of file or version, truncation, a wrong checksum, and everything that
/// saveAssetCache() refuses.
PELAGE_API Result<AssetCache> loadAssetCache(const std::filesystem::path& path);
/// The same from memory, or from a stream; `name` names it in errors.
PELAGE_API Result<AssetCache> loadAssetCache(std::span<const std::byte> bytes,
                                             std::string_view name);
PELAGE_API Result<AssetCache> loadAssetCache(ByteSource& source, std::string_view name);

/// Loads only the keys of the sources, to find out whether a cache is stale: reads the table of the
/// file and that section. Errors: as above, for the parts that it reads.
PELAGE_API Result<std::vector<SourceKey>> loadAssetCacheSources(ByteSource& source,
                                                                std::string_view name);

/// Returns the first of the keys whose file has changed or no longer exists; nothing if the cache
/// is fresh. \param folder base of relative names.
PELAGE_API std::optional<SourceKey> findStaleSource(std::span<const SourceKey> sources,
                                                    const std::filesystem::path& folder);

}  // namespace pelage
