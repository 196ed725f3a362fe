#include "asset_files.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <optional>
#include <utility>

#include "pelage/hair_asset.h"

namespace pelage::program {
namespace {

using Path = std::filesystem::path;

Error fail(const Path& path, const Error& error) {
  return {error.code, path.string() + ": " + error.message};
}

// The file of the i-th hair; nothing if there is none.
std::optional<Path> fileOf(const std::vector<Path>& files, size_t i) {
  if (i >= files.size() || files[i] == "-") return std::nullopt;
  return files[i];
}

Result<CachedHair> loadHair(const AssetFiles& files, size_t i, std::vector<std::string>& warnings) {
  const Path& path = files.hairs[i];
  TfxLoadReport report;
  auto asset = loadTfx(path, {.repair = files.repair}, &report);
  if (!asset) return asset.error();
  if (report.repairedCount > 0)
    warnings.push_back(fmt::format("{}: {} values could not be used and were repaired",
                                   path.string(), report.repairedCount));
  CachedHair hair;
  hair.name = path.stem().string();
  hair.asset = std::move(*asset);
  if (auto r = hair.asset.process(files.process); !r) return fail(path, r.error());
  if (const auto file = fileOf(files.bones, i)) {
    auto bones = loadTfxBone(*file, hair.asset.strandCount);
    if (!bones) return bones.error();
    hair.bones = std::move(*bones);
  }
  if (const auto file = fileOf(files.followHairs, i)) {
    auto follow = loadFollowHairs(*file, hair.asset.strandCount);
    if (!follow) return follow.error();
    hair.followHairs = std::move(*follow);
  }
  return hair;
}

bool isCoordinate(float value) { return std::abs(value) <= kMaxCoordinate; }  // false for NaN

Result<void> scaleAll(AssetCache& assets, const AssetFiles& files) {
  if (files.scale == 1) return {};
  for (CachedHair& hair : assets.hairs) {
    // The taper has no unit, and a cache does not say which it was made with.
    std::vector<float> thickness = std::move(hair.asset.vertexThickness);
    if (auto r = scaleHair(hair.asset, files.scale); !r) return fail(hair.name, r.error());
    if (auto r = hair.asset.process(files.process); !r) return fail(hair.name, r.error());
    hair.asset.vertexThickness = std::move(thickness);
    for (FollowHair& follow : hair.followHairs) {
      Float4& offset = follow.offset;
      offset = {offset.x * files.scale, offset.y * files.scale, offset.z * files.scale, offset.w};
    }
  }
  for (CachedMesh& mesh : assets.meshes) {
    for (Float3& p : mesh.mesh.positions) {
      p = {p.x * files.scale, p.y * files.scale, p.z * files.scale};
      if (!isCoordinate(p.x) || !isCoordinate(p.y) || !isCoordinate(p.z))
        return Error{ErrorCode::kInvalidArgument,
                     fmt::format("{}: a vertex is beyond +-1e6 m once scaled", mesh.name)};
    }
    if (auto r = prepareCollider(mesh.mesh); !r) return fail(mesh.name, r.error());
  }
  return {};
}

}  // namespace

Result<AssetCache> loadAssetFiles(const AssetFiles& files, std::vector<std::string>& warnings) {
  if (files.bones.size() > files.hairs.size() || files.followHairs.size() > files.hairs.size())
    return Error{ErrorCode::kInvalidArgument,
                 "there are more files of bones or follow hairs than of hair; they are taken in "
                 "the same order"};
  if (!(files.scale >= 1e-9f && files.scale <= 1e9f))
    return Error{ErrorCode::kInvalidArgument,
                 fmt::format("the scale is {}; it must be 1e-9 to 1e9", files.scale)};
  AssetCache assets;
  if (!files.cache.empty()) {
    auto cache = loadAssetCache(files.cache);
    if (!cache) return cache.error();
    assets = std::move(*cache);
  }
  for (size_t i = 0; i < files.hairs.size(); ++i) {
    auto hair = loadHair(files, i, warnings);
    if (!hair) return hair.error();
    assets.hairs.push_back(std::move(*hair));
  }
  for (const Path& path : files.meshes) {
    auto mesh = loadTfxMesh(path);
    if (!mesh) return mesh.error();
    if (auto r = prepareCollider(*mesh); !r) return fail(path, r.error());
    assets.meshes.push_back({path.stem().string(), std::move(*mesh)});
  }
  if (auto r = scaleAll(assets, files); !r) return r.error();
  return assets;
}

std::string lowerExtension(const Path& path) {
  std::string extension = path.extension().string();
  std::transform(extension.begin(), extension.end(), extension.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return extension;
}

std::vector<std::string> unitWarnings(const AssetCache& assets, float scale) {
  std::vector<std::string> warnings;
  for (const CachedHair& hair : assets.hairs) {
    const auto size = measureHair(hair.asset);
    std::string warning = size ? unitWarningOf(hair.name, *size, scale) : size.error().message;
    if (!warning.empty()) warnings.push_back(std::move(warning));
  }
  return warnings;
}

std::string unitWarningOf(const std::filesystem::path& file, const HairSize& size, float scale) {
  const std::string warning = unitWarning(size);
  if (warning.empty()) return {};
  return fmt::format("{}: {} {}", file.string(), warning,
                     scale == 1 ? "See --scale" : fmt::format("On top of --scale {:g}", scale));
}

}  // namespace pelage::program
