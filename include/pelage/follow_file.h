// Follow hairs in a file of their own, .tfxfollow, beside the .tfx of their guides.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>
#include <string_view>
#include <vector>

#include "pelage/hair_asset.h"
#include "pelage/result.h"
#include "pelage/stream.h"

namespace pelage {

/// The bytes of a .tfxfollow file, version 1 (docs/formats.md).
/// \param guideCount number of guides, >= 1.
/// Errors: a guide that is not below guideCount, a value that is not finite or beyond +-1e6,
/// weights that are not 0 to 1 together; the message names the hair.
Result<std::vector<std::byte>> saveFollowHairs(std::span<const FollowHair> hairs,
                                               uint32_t guideCount);
Result<void> saveFollowHairs(std::span<const FollowHair> hairs, uint32_t guideCount,
                             const std::filesystem::path& path);

/// Loads a .tfxfollow file and checks all of it; saving gives the same bytes again.
/// \param guideCount of the asset that the hairs follow; 0 takes whatever the file was made for.
/// Errors name the byte offset: no .tfxfollow file, another version, another number of guides, a
/// file that is shorter or longer than its header says, and what saveFollowHairs() refuses.
Result<std::vector<FollowHair>> loadFollowHairs(const std::filesystem::path& path,
                                                uint32_t guideCount);
/// The same from memory, or from a stream, all of which is read at once; `name` is what errors call
/// it.
Result<std::vector<FollowHair>> loadFollowHairs(std::span<const std::byte> bytes,
                                                std::string_view name, uint32_t guideCount);
Result<std::vector<FollowHair>> loadFollowHairs(ByteSource& source, std::string_view name,
                                                uint32_t guideCount);

}  // namespace pelage
