// cache: processed hair, bones, follow hairs and collision meshes in one file that loads fast.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <chrono>
#include <filesystem>
#include <limits>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "asset_files.h"
#include "commands.h"
#include "output_file.h"
#include "pelage/asset_cache.h"

namespace pelage::convert {
namespace {

// The fastest of a few runs: the others waited for the disk or for other programs.
constexpr int kRuns = 5;

struct CacheOptions {
  std::filesystem::path output;
  program::AssetFiles files;
};

// [ms] of the fastest run. The last result is kept.
template <class Function>
double fastest(Function&& function) {
  double best = std::numeric_limits<double>::infinity();
  for (int run = 0; run < kRuns; ++run) {
    const auto start = std::chrono::steady_clock::now();
    function();
    const std::chrono::duration<double, std::milli> taken =
        std::chrono::steady_clock::now() - start;
    best = std::min(best, taken.count());
  }
  return best;
}

Result<void> writeCache(const CacheOptions& options, Session& session) {
  if (auto r = program::checkOutput(options.output, ".pelage"); !r) return r;
  const program::AssetFiles& from = options.files;
  if (from.hairs.empty() && from.meshes.empty())
    return Error{ErrorCode::kInvalidArgument,
                 "nothing to put into the cache: give --hair or --mesh"};
  std::vector<std::string> warnings;
  Result<AssetCache> sources = program::loadAssetFiles(from, warnings);
  if (!sources) return sources.error();
  for (std::string& warning : program::unitWarnings(*sources, from.scale))
    session.warn(std::move(warning));
  const double sourceTime = fastest([&] { sources = program::loadAssetFiles(from, warnings); });
  if (!sources) return sources.error();

  uint64_t sourceBytes = 0;
  for (const auto* files : {&from.hairs, &from.bones, &from.followHairs, &from.meshes})
    for (const std::filesystem::path& path : *files) {
      if (path == "-") continue;
      auto key = sourceKeyOf(path);
      if (!key) return key.error();
      sourceBytes += key->size;
      sources->sources.push_back(std::move(*key));
    }
  if (auto r = saveAssetCache(*sources, options.output); !r) return r;

  Result<AssetCache> loaded = loadAssetCache(options.output);
  if (!loaded) return loaded.error();
  const double cacheTime = fastest([&] { loaded = loadAssetCache(options.output); });
  const uint64_t cacheBytes = std::filesystem::file_size(options.output);
  uint64_t strands = 0, triangles = 0;
  for (const CachedHair& hair : sources->hairs) strands += hair.asset.strandCount;
  for (const CachedMesh& mesh : sources->meshes) triangles += mesh.mesh.indices.size() / 3;

  session.add("hairs", sources->hairs.size(), "hair",
              fmt::format("{} with {} strands", sources->hairs.size(), strands));
  session.add("meshes", sources->meshes.size(), "meshes",
              fmt::format("{} with {} triangles", sources->meshes.size(), triangles));
  session.add("source_bytes", sourceBytes, "sources",
              fmt::format("{} files, {:.2f} MB", sources->sources.size(),
                          1e-6 * static_cast<double>(sourceBytes)));
  session.add("cache_bytes", cacheBytes, "cache",
              fmt::format("{:.2f} MB", 1e-6 * static_cast<double>(cacheBytes)));
  session.add("source_milliseconds", sourceTime, "parsing and processing",
              fmt::format("{:.2f} ms", sourceTime));
  session.add("cache_milliseconds", cacheTime, "loading the cache",
              fmt::format("{:.2f} ms, {:.1f} times faster", cacheTime, sourceTime / cacheTime));
  session.add("output", options.output.string(), "written", options.output.string());
  return {};
}

}  // namespace

void addCacheCommand(CLI::App& app, Session& session) {
  auto options = std::make_shared<CacheOptions>();
  CLI::App* command = app.add_subcommand(
      "cache", "Puts processed assets into one file that loads without parsing, .pelage");
  command->add_option("OUT", options->output, "Cache, .pelage")->required();
  command->add_option("--hair", options->files.hairs, "Hair, .tfx; any number")
      ->allow_extra_args(false);
  command
      ->add_option("--bones", options->files.bones,
                   "Bones of the hair, .tfxbone: the first of the first --hair, and so on; - for "
                   "none")
      ->allow_extra_args(false);
  command
      ->add_option("--follow", options->files.followHairs,
                   "Follow hairs, .tfxfollow, in the same way")
      ->allow_extra_args(false);
  command->add_option("--mesh", options->files.meshes, "Collision mesh, .tfxmesh; any number")
      ->allow_extra_args(false);
  command
      ->add_option("--tip-thickness", options->files.process.tipThickness,
                   "Thickness of the tip relative to the root, 0 to 1")
      ->capture_default_str();
  command->add_option("--scale", options->files.scale, "Metres a unit of all files")
      ->capture_default_str();
  command->callback([options, &session] {
    session.command = [options, &session] { return writeCache(*options, session); };
  });
}

}  // namespace pelage::convert
