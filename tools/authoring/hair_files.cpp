// Chooses the reader for a file.
#include "pelage/authoring/hair_files.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <utility>

#include "binary_file.h"
#include "common/errors.h"
#include "text_lines.h"

namespace pelage {
namespace {

std::string lowerExtension(std::string_view name) {
  std::string extension = std::filesystem::path(name).extension().string();
  std::transform(extension.begin(), extension.end(), extension.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return extension;
}

Result<HairCurves> load(std::span<const std::byte> bytes, std::string_view name,
                        const std::filesystem::path& folder, HairFileReport* report) {
  const auto kind = hairFileKind(bytes, name);
  if (!kind)
    return Error{ErrorCode::kInvalidFile,
                 fmt::format("{}: byte 0: not a kind of file that has hair; .tfx, .hair, .obj, "
                             ".gltf, .glb, .hairtxt and .usda can be read",
                             name)};
  switch (*kind) {
    case HairFileKind::kTfx:
      return loadTfxCurves(bytes, name, report);
    case HairFileKind::kHair:
      return loadYukselHair(bytes, name, report);
    case HairFileKind::kObj:
      return loadObjCurves(bytes, name, report);
    case HairFileKind::kGltf:
      return loadGltfCurves(bytes, name, folder, report);
    case HairFileKind::kHairText:
      return loadHairText(bytes, name, report);
    case HairFileKind::kUsd:
      return loadUsdCurves(bytes, name, report);
  }
  return Error{ErrorCode::kInvalidArgument, "unknown kind of file"};
}

}  // namespace

std::optional<HairFileKind> hairFileKind(std::span<const std::byte> bytes, std::string_view name) {
  std::string_view text = detail::asText(bytes);
  if (text.starts_with(detail::kByteOrderMark)) text.remove_prefix(detail::kByteOrderMark.size());
  if (text.substr(0, 4) == "HAIR") return HairFileKind::kHair;
  if (text.substr(0, 4) == "glTF") return HairFileKind::kGltf;
  if (text.substr(0, 8) == "hairtxt ") return HairFileKind::kHairText;
  if (text.substr(0, 6) == "#usda " || text.substr(0, 8) == "PXR-USDC") return HairFileKind::kUsd;
  constexpr std::pair<std::string_view, HairFileKind> kExtensions[] = {
      {".tfx", HairFileKind::kTfx},          {".tfxb", HairFileKind::kTfx},
      {".hair", HairFileKind::kHair},        {".obj", HairFileKind::kObj},
      {".gltf", HairFileKind::kGltf},        {".glb", HairFileKind::kGltf},
      {".hairtxt", HairFileKind::kHairText}, {".usda", HairFileKind::kUsd},
      {".usd", HairFileKind::kUsd},          {".usdc", HairFileKind::kUsd},
      {".usdz", HairFileKind::kUsd},
  };
  const std::string extension = lowerExtension(name);
  for (const auto& [known, kind] : kExtensions)
    if (extension == known) return kind;
  return std::nullopt;
}

Result<HairCurves> loadHairCurves(std::span<const std::byte> bytes, std::string_view name,
                                  HairFileReport* report) {
  return tools::guarded([&] { return load(bytes, name, {}, report); });
}

Result<HairCurves> loadHairCurves(const std::filesystem::path& path, HairFileReport* report) {
  return tools::guarded([&]() -> Result<HairCurves> {
    auto bytes = tools::readFile(path);
    if (!bytes) return bytes.error();
    const std::filesystem::path folder = path.parent_path();
    return load(*bytes, path.string(), folder.empty() ? "." : folder, report);
  });
}

const char* toString(HairFileKind kind) {
  switch (kind) {
    case HairFileKind::kTfx:
      return "TressFX";
    case HairFileKind::kHair:
      return "HAIR";
    case HairFileKind::kObj:
      return "OBJ";
    case HairFileKind::kGltf:
      return "glTF";
    case HairFileKind::kHairText:
      return "hairtxt";
    case HairFileKind::kUsd:
      return "USD";
  }
  return "?";
}

}  // namespace pelage
