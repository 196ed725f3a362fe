// The .tfxfollow file: a header of 24 bytes, then 36 bytes a hair. Little endian.
#include "pelage/hair_asset.h"

#include <fmt/format.h>

#include <array>
#include <cmath>
#include <cstring>
#include <limits>
#include <string>
#include <utility>

#include "base/errors.h"
#include "base/file_io.h"
#include "base/guard.h"

namespace pelage {
namespace {

using detail::append;
using detail::fileError;
using detail::invalid;
using detail::readAt;

constexpr std::array<char, 8> kFollowMagic = {'P', 'L', 'G', 'F', 'O', 'L', 'L', 'W'};
constexpr uint32_t kFollowVersion = 1;
constexpr uint64_t kVersionAt = 8, kGuideCountAt = 12, kHairCountAt = 16, kReservedAt = 20;
constexpr uint64_t kFollowHeaderSize = 24;
constexpr uint64_t kOffsetAt = 4, kOthersAt = 20, kWeightsAt = 28, kHairSize = 36;

// Returns the error of a hair, and the byte in its record; an empty text if there is none.
struct Fault {
  uint64_t offset = 0;
  std::string text;
};

Fault findFault(const FollowHair& hair, uint32_t guideCount) {
  const auto guideFault = [&](uint64_t offset, uint32_t guide) -> Fault {
    return {offset, fmt::format("it follows guide {} of {}", guide, guideCount)};
  };
  if (hair.guide >= guideCount) return guideFault(0, hair.guide);
  const std::array<float, 4> offset = {hair.offset.x, hair.offset.y, hair.offset.z, hair.offset.w};
  for (uint64_t i = 0; i < offset.size(); ++i)
    if (!(std::abs(offset[i]) <= kMaxCoordinate))  // true for NaN
      return {kOffsetAt + i * sizeof(float),
              fmt::format("number {} of its offset is {}; it must be within +-1e6", i, offset[i])};
  for (uint64_t i = 0; i < 2; ++i)
    if (hair.otherGuides[i] >= guideCount)
      return guideFault(kOthersAt + i * sizeof(uint32_t), hair.otherGuides[i]);
  for (uint64_t i = 0; i < 2; ++i)
    if (!(hair.otherWeights[i] >= 0 && hair.otherWeights[i] <= 1))
      return {kWeightsAt + i * sizeof(float),
              fmt::format("a weight is {}; it must be 0 to 1", hair.otherWeights[i])};
  if (hair.otherWeights[0] + hair.otherWeights[1] > 1)
    return {kWeightsAt, fmt::format("its weights {} and {} are more than 1 together",
                                    hair.otherWeights[0], hair.otherWeights[1])};
  return {};
}

Result<std::vector<std::byte>> saveHairs(std::span<const FollowHair> hairs, uint32_t guideCount) {
  if (guideCount == 0) return invalid("saveFollowHairs() needs the number of guides, 1 or more");
  if (hairs.size() > std::numeric_limits<uint32_t>::max())
    return invalid(
        fmt::format("{} follow hairs are more than a .tfxfollow file can have, which is "
                    "2^32 - 1",
                    hairs.size()));
  for (size_t i = 0; i < hairs.size(); ++i)
    if (const Fault fault = findFault(hairs[i], guideCount); !fault.text.empty())
      return invalid(fmt::format("follow hair {}: {}", i, fault.text));
  std::vector<std::byte> bytes;
  bytes.reserve(kFollowHeaderSize + hairs.size() * kHairSize);
  append(bytes, kFollowMagic);
  append(bytes, kFollowVersion);
  append(bytes, guideCount);
  append(bytes, static_cast<uint32_t>(hairs.size()));
  append(bytes, uint32_t{0});
  for (const FollowHair& hair : hairs) {
    append(bytes, hair.guide);
    append(bytes, hair.offset);
    append(bytes, hair.otherGuides);
    append(bytes, hair.otherWeights);
  }
  return bytes;
}

Result<std::vector<FollowHair>> loadHairs(std::span<const std::byte> bytes, std::string_view name,
                                          uint32_t guideCount) {
  if (bytes.size() < kFollowHeaderSize)
    return fileError(name, bytes.size(), "the file ends inside the 24-byte header");
  if (readAt<std::array<char, 8>>(bytes, 0) != kFollowMagic)
    return fileError(name, 0, "this is no .tfxfollow file (it does not begin with PLGFOLLW)");
  if (const auto version = readAt<uint32_t>(bytes, kVersionAt); version != kFollowVersion)
    return fileError(
        name, kVersionAt,
        fmt::format("the version is {}; only {} can be read", version, kFollowVersion));
  const auto guides = readAt<uint32_t>(bytes, kGuideCountAt);
  if (guides == 0) return fileError(name, kGuideCountAt, "the file is for 0 guides");
  if (guideCount != 0 && guides != guideCount)
    return fileError(name, kGuideCountAt,
                     fmt::format("the file is for {} guides, but the hair has {}; take the .tfx "
                                 "that was written together with it",
                                 guides, guideCount));
  const uint64_t count = readAt<uint32_t>(bytes, kHairCountAt);
  if (const auto reserved = readAt<uint32_t>(bytes, kReservedAt); reserved != 0)
    return fileError(name, kReservedAt, fmt::format("a reserved word is {} and not 0", reserved));
  const uint64_t end = kFollowHeaderSize + count * kHairSize;
  if (bytes.size() < end)
    return fileError(
        name, bytes.size(),
        fmt::format("{} follow hairs need {} bytes, but the file ends here", count, end));
  if (bytes.size() > end)
    return fileError(name, end,
                     fmt::format("{} bytes follow after the last of {} follow hairs",
                                 bytes.size() - end, count));
  std::vector<FollowHair> hairs(count);
  for (uint64_t i = 0; i < count; ++i) {
    const uint64_t at = kFollowHeaderSize + i * kHairSize;
    FollowHair& hair = hairs[i];
    hair.guide = readAt<uint32_t>(bytes, at);
    hair.offset = readAt<Float4>(bytes, at + kOffsetAt);
    for (uint64_t k = 0; k < 2; ++k) {
      hair.otherGuides[k] = readAt<uint32_t>(bytes, at + kOthersAt + k * sizeof(uint32_t));
      hair.otherWeights[k] = readAt<float>(bytes, at + kWeightsAt + k * sizeof(float));
    }
    if (const Fault fault = findFault(hair, guides); !fault.text.empty())
      return fileError(name, at + fault.offset, fmt::format("follow hair {}: {}", i, fault.text));
  }
  return hairs;
}

}  // namespace

Result<std::vector<std::byte>> saveFollowHairs(std::span<const FollowHair> hairs,
                                               uint32_t guideCount) {
  return detail::guarded([&] { return saveHairs(hairs, guideCount); });
}

Result<void> saveFollowHairs(std::span<const FollowHair> hairs, uint32_t guideCount,
                             const std::filesystem::path& path) {
  return detail::guarded([&]() -> Result<void> {
    const auto bytes = saveHairs(hairs, guideCount);
    if (!bytes) return bytes.error();
    return detail::writeFile(path, *bytes);
  });
}

Result<std::vector<FollowHair>> loadFollowHairs(std::span<const std::byte> bytes,
                                                std::string_view name, uint32_t guideCount) {
  return detail::guarded([&] { return loadHairs(bytes, name, guideCount); });
}

Result<std::vector<FollowHair>> loadFollowHairs(ByteSource& source, std::string_view name,
                                                uint32_t guideCount) {
  const auto bytes = readAll(source, name);
  if (!bytes) return bytes.error();
  return loadFollowHairs(*bytes, name, guideCount);
}

Result<std::vector<FollowHair>> loadFollowHairs(const std::filesystem::path& path,
                                                uint32_t guideCount) {
  return detail::guarded([&]() -> Result<std::vector<FollowHair>> {
    const auto bytes = detail::readFile(path);
    if (!bytes) return bytes.error();
    return loadHairs(*bytes, path.string(), guideCount);
  });
}

}  // namespace pelage
