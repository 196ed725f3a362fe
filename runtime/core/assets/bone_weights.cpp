// The .tfxbone file, and bone names mapped to an engine's indices.
#include "pelage/bone_weights.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "assets/bone_influences.h"
#include "base/errors.h"
#include "base/file_io.h"
#include "base/guard.h"

namespace pelage {
namespace {

using detail::append;
using detail::ByteReader;
using detail::fileError;

constexpr uint64_t kBoneRecordMin = 2 * sizeof(int32_t) + 1;  // a name is at least its NUL
constexpr uint64_t kStrandRecord = sizeof(int32_t) + 4 * (sizeof(int32_t) + sizeof(float));
constexpr uint32_t kMaxBoneNameLength = 4096;

// Reads a count of records of at least `recordSize` bytes each: an error if the file cannot hold
// them.
Result<uint32_t> readCount(ByteReader& reader, std::string_view what, uint64_t recordSize) {
  const uint64_t at = reader.offset();
  auto value = reader.value<int32_t>(fmt::format("the number of {}", what));
  if (!value) return value.error();
  if (*value <= 0)
    return fileError(reader.name(), at,
                     fmt::format("the number of {} is {}; it must be at least 1", what, *value));
  if (static_cast<uint64_t>(*value) > reader.left() / recordSize)
    return fileError(
        reader.name(), at,
        fmt::format("{} {} need at least {} bytes, but the file ends at byte {}", *value, what,
                    static_cast<uint64_t>(*value) * recordSize, reader.size()));
  return static_cast<uint32_t>(*value);
}

// Reads a text that ends in NUL, and has no other one.
Result<std::string> readText(ByteReader& reader, uint32_t length, std::string_view what) {
  const uint64_t at = reader.offset();
  auto text = reader.text(length, what);
  if (!text) return text;
  const size_t nul = std::min<size_t>(text->find('\0'), length);
  if (nul + 1 != length)
    return fileError(reader.name(), at + nul,
                     nul == length ? fmt::format("{} does not end in NUL", what)
                                   : fmt::format("{} has a NUL before its end", what));
  text->pop_back();
  return text;
}

Result<std::vector<BoneName>> readBones(ByteReader& reader, std::string_view name) {
  auto count = readCount(reader, "bones", kBoneRecordMin);
  if (!count) return count.error();
  std::vector<BoneName> bones;
  bones.reserve(*count);
  std::vector<bool> seen(*count);
  for (uint32_t i = 0; i < *count; ++i) {
    const uint64_t at = reader.offset();
    auto index = reader.value<int32_t>(fmt::format("bone record {}", i));
    if (!index) return index.error();
    if (*index < 0 || static_cast<uint32_t>(*index) >= *count)
      return fileError(name, at,
                       fmt::format("bone index {}; it must be 0 to {}", *index, *count - 1));
    if (seen[static_cast<uint32_t>(*index)])
      return fileError(name, at, fmt::format("bone index {} is there twice", *index));
    seen[static_cast<uint32_t>(*index)] = true;
    auto length = reader.value<int32_t>(fmt::format("bone record {}", i));
    if (!length) return length.error();
    if (*length < 1 || static_cast<uint32_t>(*length) > kMaxBoneNameLength)
      return fileError(name, at + sizeof(int32_t),
                       fmt::format("the name of bone {} has {} bytes; it must be 1 to {}, its NUL "
                                   "included",
                                   *index, *length, kMaxBoneNameLength));
    auto text = readText(reader, static_cast<uint32_t>(*length),
                         fmt::format("the name of bone {}", *index));
    if (!text) return text.error();
    bones.push_back({static_cast<uint32_t>(*index), std::move(*text)});
  }
  return bones;
}

Result<BoneWeights> loadWeights(std::span<const std::byte> bytes, std::string_view name,
                                uint32_t strandCount) {
  ByteReader reader(bytes, name);
  BoneWeights result;
  auto bones = readBones(reader, name);
  if (!bones) return bones.error();
  result.bones = std::move(*bones);
  const uint64_t countAt = reader.offset();
  auto count = readCount(reader, "strands", kStrandRecord);
  if (!count) return count.error();
  if (strandCount != 0 && *count != strandCount)
    return fileError(
        name, countAt,
        fmt::format("the file is for {} strands, the hair has {}", *count, strandCount));
  result.strands.resize(*count);
  // As many records as strands, each strand at most once: so none is missing.
  std::vector<bool> seen(*count);
  for (uint32_t i = 0; i < *count; ++i) {
    const uint64_t at = reader.offset();
    auto strand = reader.value<int32_t>(fmt::format("strand record {}", i));
    if (!strand) return strand.error();
    if (*strand < 0 || static_cast<uint32_t>(*strand) >= *count)
      return fileError(name, at,
                       fmt::format("strand index {}; it must be 0 to {}", *strand, *count - 1));
    const auto index = static_cast<uint32_t>(*strand);
    if (seen[index]) return fileError(name, at, fmt::format("strand {} is there twice", index));
    seen[index] = true;
    BoneInfluences& influences = result.strands[index];
    for (int k = 0; k < 4; ++k) {
      const uint64_t boneAt = reader.offset();
      auto bone = reader.value<int32_t>(fmt::format("strand record {}", i));
      if (!bone) return bone.error();
      if (*bone < 0 || static_cast<uint32_t>(*bone) >= result.bones.size())
        return fileError(name, boneAt,
                         fmt::format("bone {} of strand {}; it must be 0 to {}", *bone, index,
                                     result.bones.size() - 1));
      auto weight = reader.value<float>(fmt::format("strand record {}", i));
      if (!weight) return weight.error();
      if (!detail::isWeight(*weight))
        return fileError(
            name, boneAt + sizeof(int32_t),
            fmt::format("weight {} of strand {}; it must be 0 to 1e6", *weight, index));
      influences.bones[k] = static_cast<uint32_t>(*bone);
      influences.weights[k] = *weight;
    }
    if (detail::repairWeights(influences)) ++result.repairedStrandCount;
  }
  if (reader.left() != 0)
    return fileError(name, reader.offset(),
                     fmt::format("{} bytes after the last strand record", reader.left()));
  return result;
}

Result<std::vector<std::byte>> saveWeights(const BoneWeights& weights) {
  constexpr auto kMaxCount = static_cast<size_t>(std::numeric_limits<int32_t>::max());
  if (weights.bones.empty() || weights.bones.size() > kMaxCount)
    return detail::invalid(fmt::format("{} bones cannot be saved", weights.bones.size()));
  if (weights.strands.empty() || weights.strands.size() > kMaxCount)
    return detail::invalid(
        fmt::format("weights of {} strands cannot be saved", weights.strands.size()));
  if (auto r = detail::checkBoneNames(weights.bones, kMaxBoneNameLength); !r) return r.error();
  std::vector<std::byte> bytes;
  append(bytes, static_cast<int32_t>(weights.bones.size()));
  for (const BoneName& bone : weights.bones) {
    append(bytes, static_cast<int32_t>(bone.index));
    append(bytes, static_cast<int32_t>(bone.name.size() + 1));
    const auto* text = reinterpret_cast<const std::byte*>(bone.name.c_str());
    bytes.insert(bytes.end(), text, text + bone.name.size() + 1);
  }
  append(bytes, static_cast<int32_t>(weights.strands.size()));
  bytes.reserve(bytes.size() + weights.strands.size() * kStrandRecord);
  for (size_t i = 0; i < weights.strands.size(); ++i) {
    const BoneInfluences& influences = weights.strands[i];
    if (auto r = detail::checkInfluences(influences, weights.bones.size(), "strand", i); !r)
      return r.error();
    append(bytes, static_cast<int32_t>(i));
    for (int k = 0; k < 4; ++k) {
      append(bytes, static_cast<int32_t>(influences.bones[k]));
      append(bytes, influences.weights[k]);
    }
  }
  return bytes;
}

Result<std::vector<BoneInfluences>> map(std::span<const BoneName> bones,
                                        std::span<const BoneInfluences> influences,
                                        const BoneLookup& lookup,
                                        std::optional<uint32_t> fallback) {
  std::vector<const BoneName*> byIndex(bones.size(), nullptr);
  for (const BoneName& bone : bones)
    if (bone.index < bones.size()) byIndex[bone.index] = &bone;
  std::vector<std::optional<uint32_t>> known(bones.size());  // of the bones looked up so far

  std::vector<BoneInfluences> mapped(influences.begin(), influences.end());
  for (size_t i = 0; i < mapped.size(); ++i) {
    BoneInfluences& entry = mapped[i];
    if (auto r = detail::checkInfluences(entry, bones.size(), "entry", i); !r) return r.error();
    int heaviest = 0;
    for (int k = 1; k < 4; ++k)
      if (entry.weights[k] > entry.weights[heaviest]) heaviest = k;
    for (int k = 0; k < 4; ++k) {
      if (!(entry.weights[k] > 0)) continue;
      const uint32_t fileIndex = entry.bones[k];
      if (!known[fileIndex]) {
        const BoneName* bone = byIndex[fileIndex];
        if (bone == nullptr)
          return detail::invalid(
              fmt::format("entry {} follows bone {}, which has no name", i, fileIndex));
        known[fileIndex] = lookup ? lookup(bone->name) : std::nullopt;
        if (!known[fileIndex]) known[fileIndex] = fallback;
        if (!known[fileIndex])
          return Error{
              ErrorCode::kInvalidArgument,
              fmt::format("the engine has no bone named '{}'; rename it or give a fallback",
                          bone->name)};
      }
      entry.bones[k] = *known[fileIndex];
    }
    for (int k = 0; k < 4; ++k)
      if (!(entry.weights[k] > 0)) entry.bones[k] = entry.bones[heaviest];
  }
  return mapped;
}

}  // namespace

namespace detail {

bool isWeight(float weight) { return weight >= 0 && weight <= 1e6f; }  // false for NaN

bool repairWeights(BoneInfluences& influences) {
  float sum = 0;
  int heaviest = 0;
  for (int k = 0; k < 4; ++k) {
    sum += influences.weights[k];
    if (influences.weights[k] > influences.weights[heaviest]) heaviest = k;
  }
  if (sum >= 1e-6f) return false;
  const uint32_t bone = influences.bones[heaviest];
  influences = {{bone, bone, bone, bone}, {1, 0, 0, 0}};
  return true;
}

Result<void> checkInfluences(const BoneInfluences& influences, size_t boneCount, const char* what,
                             size_t index) {
  float sum = 0;
  for (int k = 0; k < 4; ++k) {
    if (influences.bones[k] >= boneCount)
      return detail::invalid(
          fmt::format("{} {} follows bone {} of {}", what, index, influences.bones[k], boneCount));
    if (!isWeight(influences.weights[k]))
      return Error{ErrorCode::kInvalidArgument,
                   fmt::format("{} {} has the bone weight {}; it must be 0 to 1e6", what, index,
                               influences.weights[k])};
    sum += influences.weights[k];
  }
  if (!(sum > 0))
    return detail::invalid(fmt::format("the bone weights of {} {} are all zero", what, index));
  return {};
}

Result<void> checkBoneNames(std::span<const BoneName> bones, size_t maxLength) {
  std::vector<bool> seen(bones.size());
  for (const BoneName& bone : bones) {
    if (bone.index >= bones.size() || seen[bone.index])
      return Error{ErrorCode::kInvalidArgument,
                   fmt::format("bone '{}' has the index {}; each of 0 to {} must occur once",
                               bone.name, bone.index, bones.size() - 1)};
    seen[bone.index] = true;
    if (bone.name.size() >= maxLength || bone.name.find('\0') != std::string::npos)
      return detail::invalid(
          fmt::format("the name of bone {} is too long or has a NUL inside", bone.index));
  }
  return {};
}

}  // namespace detail

Result<BoneWeights> loadTfxBone(std::span<const std::byte> bytes, std::string_view name,
                                uint32_t strandCount) {
  return detail::guarded([&] { return loadWeights(bytes, name, strandCount); });
}

Result<BoneWeights> loadTfxBone(ByteSource& source, std::string_view name, uint32_t strandCount) {
  auto bytes = readAll(source, name);
  if (!bytes) return bytes.error();
  return loadTfxBone(*bytes, name, strandCount);
}

Result<BoneWeights> loadTfxBone(const std::filesystem::path& path, uint32_t strandCount) {
  return detail::guarded([&]() -> Result<BoneWeights> {
    auto bytes = detail::readFile(path);
    if (!bytes) return bytes.error();
    return loadWeights(*bytes, path.string(), strandCount);
  });
}

Result<std::vector<std::byte>> saveTfxBone(const BoneWeights& weights) {
  return detail::guarded([&] { return saveWeights(weights); });
}

Result<void> saveTfxBone(const BoneWeights& weights, const std::filesystem::path& path) {
  return detail::guarded([&]() -> Result<void> {
    auto bytes = saveWeights(weights);
    if (!bytes) return bytes.error();
    return detail::writeFile(path, *bytes);
  });
}

Result<std::vector<BoneInfluences>> mapBones(std::span<const BoneName> bones,
                                             std::span<const BoneInfluences> influences,
                                             const BoneLookup& lookup,
                                             std::optional<uint32_t> fallback) {
  return detail::guarded([&] { return map(bones, influences, lookup, fallback); });
}

}  // namespace pelage
