#include "project.h"

#include <fmt/format.h>

#include <algorithm>
#include <set>
#include <utility>
#include <vector>

#include "bone_stream.h"
#include "json_members.h"
#include "pelage/asset_cache.h"
#include "pelage/hair_cache.h"

namespace pelage::bake {
namespace {

using nlohmann::json;
using Path = std::filesystem::path;

constexpr int64_t kMaxFrame = 1'000'000'000;
constexpr int64_t kMaxFrames = 1'000'000;
constexpr uint32_t kMaxGuides = 1u << 20;
const std::vector<std::string> kMotions = {"bind", "idle", "walk", "shake", "jump", "all"};
const std::vector<std::string> kGrooms = {"long", "fur", "mohawk"};

Path in(const Path& folder, const std::string& path) {
  return path.empty() ? Path() : (folder / path).lexically_normal();
}

bool isName(const std::string& name) {
  return !name.empty() && name.front() != '.' && name.size() <= 200 &&
         std::all_of(name.begin(), name.end(), [](char c) {
           return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') ||
                  c == '.' || c == '_' || c == '-';
         });
}

void readHair(JsonMembers& hair, const Path& folder, program::AssetFiles& files) {
  files.hairs.push_back(in(folder, hair.text("file")));
  const std::string bones = hair.text("bones", ""), follow = hair.text("follow", "");
  files.bones.push_back(bones.empty() ? Path("-") : in(folder, bones));
  files.followHairs.push_back(follow.empty() ? Path("-") : in(folder, follow));
  hair.finish();
}

void readGenerated(JsonMembers& from, Shot& shot) {
  GeneratedAssets generated;
  generated.kind = static_cast<GeneratedKind>(from.choice("kind", {"character", "head"}, 0));
  generated.seed = static_cast<uint64_t>(from.integer("seed", 0, kMaxFrame, 1));
  if (from.has("guides"))
    generated.guides = static_cast<uint32_t>(from.integer("guides", 1, kMaxGuides));
  generated.grooms = from.texts("grooms");
  for (const std::string& groom : generated.grooms)
    if (std::find(kGrooms.begin(), kGrooms.end(), groom) == kGrooms.end())
      from.fault("grooms", "are \"long\", \"fur\" and \"mohawk\"");
  from.finish();
  shot.generated = std::move(generated);
}

void readAssets(JsonMembers& assets, const Path& folder, JsonFaults& faults, Shot& shot) {
  if (const json* generated = assets.object("generated"); generated != nullptr) {
    JsonMembers members(*generated, assets.pointerOf("generated"), faults);
    readGenerated(members, shot);
  }
  const json* hairs = assets.array("hairs");
  for (size_t i = 0; hairs != nullptr && i < hairs->size(); ++i) {
    JsonMembers hair((*hairs)[i], fmt::format("{}/{}", assets.pointerOf("hairs"), i), faults);
    readHair(hair, folder, shot.files);
  }
  for (const std::string& mesh : assets.texts("colliders"))
    shot.files.meshes.push_back(in(folder, mesh));
  shot.files.cache = in(folder, assets.text("cache", ""));
  shot.files.scale = static_cast<float>(assets.number("scale", 1e-9, 1e9, 1));
  if (assets.has("cellSize")) shot.cellSize = assets.meters("cellSize", 1e-4, 1);
  const bool files = !shot.files.hairs.empty() || !shot.files.cache.empty();
  if (shot.generated.has_value() == files)
    assets.fault("hairs", "give \"hairs\" or \"cache\", or \"generated\" in their place");
  assets.finish();
}

void readAnimation(JsonMembers& animation, const Path& folder, double framesPerSecond, Shot& shot) {
  shot.animation = in(folder, animation.text("file", ""));
  shot.clip = animation.text("clip", "");
  if (animation.has("motion"))
    shot.motion = static_cast<CharacterMotion>(animation.choice("motion", kMotions, 0));
  shot.transforms = in(folder, animation.text("transforms", ""));
  shot.points = in(folder, animation.text("points", ""));
  shot.pointMesh = in(folder, animation.text("mesh", ""));
  shot.pointsPerSecond = animation.number("fps", 1e-3, 1e6, framesPerSecond);
  shot.animationStart = animation.number("start", -1e6, 1e6, 0);
  const int sources =
      (shot.animation.empty() ? 0 : 1) + (shot.motion ? 1 : 0) + (shot.transforms.empty() ? 0 : 1);
  if (sources > 1 || (sources == 0 && shot.points.empty()))
    animation.fault("file", "give \"file\", \"transforms\" or \"motion\", or \"points\"");
  if (shot.points.empty() != shot.pointMesh.empty())
    animation.fault("mesh", "is the mesh that \"points\" moves: give both or none");
  if (shot.points.empty() && animation.has("fps"))
    animation.fault("fps", "is that of \"points\", which are not there");
  animation.finish();
}

void readAccuracy(JsonMembers& members, Shot& shot) {
  if (members.has("solver"))
    shot.solver =
        members.choice("solver", {"exact", "classic"}, 0) == 0 ? Solver::kExact : Solver::kClassic;
  if (members.has("subSteps"))
    shot.subSteps = static_cast<uint32_t>(members.integer("subSteps", 1, 32));
  if (members.has("errorBound")) shot.errorBound = members.meters("errorBound", 1e-7, 1);
  shot.errorShare = members.number("errorShare", 0.01, 1, shot.errorShare);
  if (shot.subSteps && shot.errorBound)
    members.fault("errorBound", "chooses the sub-steps: leave out \"subSteps\"");
  if (shot.errorBound && shot.solver == Solver::kClassic)
    members.fault("errorBound", "is for the exact solver, whose steps can be halved");
}

Shot readShot(JsonMembers& members, const Path& folder, double framesPerSecond,
              JsonFaults& faults) {
  Shot shot;
  shot.name = members.text("name");
  if (!shot.name.empty() && !isName(shot.name))
    members.fault("name",
                  "must be 1 to 200 letters, digits, '.', '_' or '-', and not begin with '.'");
  const auto [first, last] = members.range("frames", -kMaxFrame, kMaxFrame);
  shot.frames = {first, last};
  if (last - first >= kMaxFrames) members.fault("frames", "are more than 1000000");
  shot.preRoll = static_cast<uint32_t>(members.integer("preRoll", 0, kMaxFrames, 0));
  const json* assets = members.object("assets");
  if (assets == nullptr && !members.has("assets")) members.fault("assets", "is missing");
  if (assets != nullptr) {
    JsonMembers object(*assets, members.pointerOf("assets"), faults);
    readAssets(object, folder, faults, shot);
  }
  if (const json* animation = members.object("animation"); animation != nullptr) {
    JsonMembers object(*animation, members.pointerOf("animation"), faults);
    readAnimation(object, folder, framesPerSecond, shot);
  }
  shot.settings = in(folder, members.text("settings", ""));
  shot.collides = members.flag("collides", true);
  shot.followHairs = members.choice("strands", {"guides", "all"}, 0) == 1;
  readAccuracy(members, shot);
  return shot;
}

void readDevice(JsonMembers& device, Project& project) {
  project.api = static_cast<Api>(device.choice("api", {"vulkan", "gl", "gles"}, 0));
  project.device = device.text("device", "");
  device.finish();
}

void readOutput(JsonMembers& root, const Path& folder, Project& project) {
  project.output = in(folder, root.text("output"));
  project.framesPerSecond = root.number("fps", 15, 1000, 24);
  project.chunkFrames = static_cast<uint32_t>(root.integer("chunkFrames", 1, 4096, 16));
  project.checkpointChunks = static_cast<uint32_t>(root.integer("checkpointChunks", 1, 4096, 4));
  project.cacheError = static_cast<float>(root.meters("cacheError", 0, 1, 1e-4));
  if (project.cacheError > 0 && project.cacheError < 1e-9f)
    root.fault("cacheError", "must be 0, or 1e-9 m and more");
  for (const std::string& format : root.texts("formats")) {
    if (format == "usda")
      project.usd = true;
    else if (format != "pelagecache")
      root.fault("formats", "are \"pelagecache\", which is always written, and \"usda\"");
  }
}

// Everything that the frames of a shot depend on, except its files.
json inputsOf(const Project& project, const Shot& shot) {
  json inputs = {{"version", 1},
                 {"cacheVersion", kHairCacheVersion},
                 {"fps", project.framesPerSecond},
                 {"chunkFrames", project.chunkFrames},
                 {"cacheError", project.cacheError},
                 {"usd", project.usd},
                 {"api", static_cast<int>(project.api)},
                 {"frames", {shot.frames.first, shot.frames.last}},
                 {"preRoll", shot.preRoll},
                 {"scale", shot.files.scale},
                 {"collides", shot.collides},
                 {"clip", shot.clip},
                 {"start", shot.animationStart},
                 {"follow", shot.followHairs}};
  if (shot.generated)
    inputs["generated"] = {static_cast<int>(shot.generated->kind), shot.generated->seed,
                           shot.generated->guides.value_or(0), shot.generated->grooms};
  if (shot.motion) inputs["motion"] = static_cast<int>(*shot.motion);
  if (!shot.points.empty()) inputs["pointsPerSecond"] = shot.pointsPerSecond;
  if (shot.cellSize > 0) inputs["cellSize"] = shot.cellSize;
  if (shot.solver) inputs["solver"] = static_cast<int>(*shot.solver);
  if (shot.subSteps) inputs["subSteps"] = *shot.subSteps;
  if (shot.errorBound) inputs["errorBound"] = {*shot.errorBound, shot.errorShare};
  return inputs;
}

// A glTF file and the buffers beside it.
Result<std::vector<Path>> gltfFiles(const Path& file) {
  std::vector<Path> files = {file};
  if (file.extension() != ".gltf") return files;
  const auto parsed = loadJson(file.string());
  if (!parsed) return parsed.error();
  if (!parsed->is_object() || !parsed->contains("buffers")) return files;
  for (const json& buffer : (*parsed)["buffers"]) {
    const std::string uri =
        buffer.is_object() && buffer.contains("uri") && buffer["uri"].is_string()
            ? buffer["uri"].get<std::string>()
            : "";
    if (!uri.empty() && uri.rfind("data:", 0) != 0) files.push_back(file.parent_path() / uri);
  }
  return files;
}

// Files that move bones and vertices.
Result<std::vector<Path>> animationFiles(const Shot& shot) {
  std::vector<Path> files;
  if (!shot.animation.empty()) {
    auto gltf = gltfFiles(shot.animation);
    if (!gltf) return gltf.error();
    files = *std::move(gltf);
  }
  if (!shot.transforms.empty()) {
    auto data = dataOfBoneStream(shot.transforms);
    if (!data) return data.error();
    files.insert(files.end(), {shot.transforms, *std::move(data)});
  }
  if (!shot.points.empty()) files.insert(files.end(), {shot.points, shot.pointMesh});
  return files;
}

}  // namespace

const Shot* Project::find(std::string_view name) const {
  const auto found =
      std::find_if(shots.begin(), shots.end(), [&](const Shot& shot) { return shot.name == name; });
  return found == shots.end() ? nullptr : &*found;
}

Result<Project> loadProject(const Path& path) {
  const auto loaded = loadJson(path.string());
  if (!loaded) return loaded.error();
  std::error_code code;
  const Path file = std::filesystem::absolute(path, code).lexically_normal();
  const Path folder = file.parent_path();
  JsonFaults faults = {path.string(), {}};
  Project project;
  project.file = file;
  JsonMembers root(*loaded, "", faults);
  (void)root.integer("version", 1, 1);
  readOutput(root, folder, project);
  if (const json* device = root.object("device"); device != nullptr) {
    JsonMembers members(*device, "/device", faults);
    readDevice(members, project);
  }
  static const json kNone = json::object();
  const json* given = root.object("defaults");
  JsonMembers defaults(given != nullptr ? *given : kNone, "/defaults", faults);
  const json* shots = root.array("shots");
  if (shots == nullptr && !root.has("shots")) root.fault("shots", "is missing");
  std::set<std::string> names;
  for (size_t i = 0; shots != nullptr && i < shots->size(); ++i) {
    const std::string pointer = fmt::format("/shots/{}", i);
    JsonMembers members((*shots)[i], pointer, faults, &defaults);
    Shot shot = readShot(members, folder, project.framesPerSecond, faults);
    members.finish();
    if (!shot.name.empty() && !names.insert(shot.name).second)
      members.fault("name", fmt::format("another shot is '{}'", shot.name));
    project.shots.push_back(std::move(shot));
  }
  if (shots != nullptr && shots->empty()) root.fault("shots", "has no shot");
  root.finish();
  if (auto fine = faults.result(); !fine) return fine.error();
  return project;
}

FrameRange chunkOf(const Project& project, const Shot& shot, uint64_t chunk) {
  const auto frames = static_cast<int64_t>(project.chunkFrames);
  const int64_t first = shot.frames.first;
  const int64_t into = ((first % frames) + frames) % frames;
  const int64_t begin = first - into + static_cast<int64_t>(chunk) * frames;
  return {std::max(begin, first), std::min(begin + frames - 1, shot.frames.last)};
}

uint64_t chunkCount(const Project& project, const Shot& shot) {
  const int64_t end = chunkOf(project, shot, 0).last;
  if (end >= shot.frames.last) return 1;
  return 1 + (static_cast<uint64_t>(shot.frames.last - end) + project.chunkFrames - 1) /
                 project.chunkFrames;
}

Result<SourceKey> FileHashes::of(const Path& path) {
  std::error_code code;
  const uint64_t size = std::filesystem::file_size(path, code);
  const auto time =
      code ? std::filesystem::file_time_type() : std::filesystem::last_write_time(path, code);
  const auto found = known_.find(path);
  if (!code && found != known_.end() && found->second.size == size && found->second.time == time)
    return found->second.key;
  auto key = sourceKeyOf(path);
  if (!key) return key;
  ++filesRead_;
  if (!code) known_[path] = {size, time, *key};
  return key;
}

Result<uint64_t> fingerprintOf(const Project& project, const Shot& shot, FileHashes& hashes) {
  std::vector<Path> files = shot.files.hairs;
  for (const auto* more : {&shot.files.bones, &shot.files.followHairs, &shot.files.meshes})
    files.insert(files.end(), more->begin(), more->end());
  for (const Path& one : {shot.files.cache, shot.settings})
    files.push_back(one.empty() ? Path("-") : one);
  auto moving = animationFiles(shot);
  if (!moving) return moving.error();
  files.insert(files.end(), moving->begin(), moving->end());
  json inputs = inputsOf(project, shot);
  for (const Path& file : files) {
    if (file == "-") {
      inputs["files"].push_back(nullptr);
      continue;
    }
    const auto key = hashes.of(file);
    if (!key) return key.error();
    inputs["files"].push_back({file.filename().string(), key->size, key->hash});
  }
  const std::string text = inputs.dump();
  return sourceKeyOf(std::as_bytes(std::span(text)), "").hash;
}

Result<uint64_t> assetKeyOf(const Shot& shot, FileHashes& hashes) {
  Shot assets;
  assets.files = shot.files;
  assets.generated = shot.generated;
  return fingerprintOf({}, assets, hashes);
}

}  // namespace pelage::bake
