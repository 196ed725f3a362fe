// The file of follow hairs, .tfxfollow, beside the .tfx of their guides.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>
#include <string_view>
#include <vector>

#include "pelage/export.h"
#include "pelage/hair_asset.h"
#include "pelage/result.h"
#include "pelage/stream.h"

namespace pelage {

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

}  // namespace pelage
