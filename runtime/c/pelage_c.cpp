// The C interface: each function checks its arguments and calls the function of C++ that has its
// name.
#include "pelage/pelage_c.h"

#include <algorithm>
#include <bit>
#include <cfloat>
#include <cmath>
#include <cstddef>
#include <cstring>
#include <filesystem>
#include <functional>
#include <iterator>
#include <optional>
#include <set>
#include <span>
#include <vector>

#include "call.h"
#include "pelage/asset_cache.h"
#include "pelage/collision_mesh.h"
#include "pelage/demo/groom.h"
#include "pelage/hair_asset.h"
#include "pelage/headless.h"
#include "pelage/scene.h"
#include "pelage/settings/settings_file.h"
#if PELAGE_C_VULKAN
#include "pelage/vulkan.h"
#endif
#if PELAGE_C_GL
#include "pelage/gl.h"
#endif

// NOLINTBEGIN(readability-identifier-naming): the names of C.
using namespace pelage;
using namespace pelage::c;

// The objects behind handles.
struct pelage_asset {
  std::string name;
  std::shared_ptr<const HairAsset> hair;
  std::vector<BoneName> bones;  // of the file that the influences came from
  std::vector<BoneInfluences> influences;
  std::vector<FollowHair> followHairs;
};
struct pelage_mesh {
  CollisionMesh mesh;
};
struct pelage_cache {
  AssetCache cache;
};
struct pelage_settings {
  SceneSettings settings;
};
struct pelage_scene {
  Scene scene;
  std::unordered_map<pelage_id, uint32_t> boneCounts;  // 0: it follows a skeleton
  std::set<BufferId> buffers;                          // of the application
  std::shared_ptr<bool> spoiled = std::make_shared<bool>(false);
};
struct pelage_frame {
  Frame frame;
  std::shared_ptr<bool> spoiled;  // its scene's
};
struct pelage_snapshot {
  SceneSnapshot snapshot;
};
struct pelage_headless {
  std::unique_ptr<HeadlessDevice> device;
};
PELAGE_C_NAME(pelage_asset);
PELAGE_C_NAME(pelage_mesh);
PELAGE_C_NAME(pelage_cache);
PELAGE_C_NAME(pelage_settings);
PELAGE_C_NAME(pelage_scene);
PELAGE_C_NAME(pelage_frame);
PELAGE_C_NAME(pelage_snapshot);
PELAGE_C_NAME(pelage_headless);
#if PELAGE_C_VULKAN
struct pelage_vulkan_runtime {
  vulkan::Runtime runtime;
  uint64_t frame = 0;  // the last one that began
};
PELAGE_C_NAME(pelage_vulkan_runtime);
#endif
#if PELAGE_C_GL
struct pelage_gl_runtime {
  gl::Runtime runtime;
};
PELAGE_C_NAME(pelage_gl_runtime);
#endif

// Codes are those of C++, each one more.
#define PELAGE_C_CODE(c, cpp) \
  static_assert(PELAGE_ERROR_##c == static_cast<int>(ErrorCode::cpp) + 1)
PELAGE_C_CODE(INVALID_ARGUMENT, kInvalidArgument);
PELAGE_C_CODE(FILE_NOT_FOUND, kFileNotFound);
PELAGE_C_CODE(INVALID_FILE, kInvalidFile);
PELAGE_C_CODE(OUT_OF_MEMORY, kOutOfMemory);
PELAGE_C_CODE(UNSUPPORTED, kUnsupported);
PELAGE_C_CODE(DEVICE, kDevice);
PELAGE_C_CODE(DEVICE_LOST, kDeviceLost);
static_assert(PELAGE_PARAMETER_CHOICE == static_cast<int>(ParameterType::kChoice));
static_assert(PELAGE_GLES == static_cast<int>(Api::kGles));

// Arrays of C are read as those of C++.
static_assert(sizeof(pelage_transform) == sizeof(AffineTransform));
static_assert(sizeof(pelage_influences) == sizeof(BoneInfluences));
static_assert(offsetof(pelage_influences, weights) == offsetof(BoneInfluences, weights));
static_assert(sizeof(pelage_capsule) == sizeof(CapsuleCollider));
static_assert(offsetof(pelage_capsule, tail) == offsetof(CapsuleCollider, tail));
static_assert(offsetof(pelage_capsule, friction) == offsetof(CapsuleCollider, friction));
static_assert(offsetof(pelage_capsule, angular_velocity) ==
              offsetof(CapsuleCollider, angularVelocity));

namespace {

thread_local std::string g_lastError;
thread_local const char* g_lastErrorText = "";

// An array as one of C++. `name` is that of the argument.
template <class To, class From>
Result<std::span<const To>> arrayOf(const From* first, uint64_t count, const char* name) {
  if (first == nullptr && count > 0) return invalid("the array '{}' is NULL", name);
  return std::span(reinterpret_cast<const To*>(first), static_cast<size_t>(count));
}
// Empty for NULL.
template <class To, class From>
std::vector<To> copyOf(const From* first, uint64_t count) {
  if (first == nullptr) return {};
  const auto* from = reinterpret_cast<const To*>(first);
  return std::vector<To>(from, from + count);
}

Float3 float3(const float* v) { return {v[0], v[1], v[2]}; }

std::filesystem::path pathOf(const char* utf8) { return reinterpret_cast<const char8_t*>(utf8); }

// Loads by a function of a path, or of bytes and a name.
template <class Load>
auto loadFrom(const char* name, const void* bytes, size_t size, Load load)
    -> decltype(load(std::filesystem::path())) {
  if (name == nullptr) return invalid("the name of a file is NULL");
  if (bytes == nullptr) return load(pathOf(name));
  return load(std::span(static_cast<const std::byte*>(bytes), size), std::string_view(name));
}

Result<pelage_asset> process(Result<HairAsset> hair) {
  if (!hair) return hair.error();
  if (Result<void> done = hair->process(); !done) return done.error();
  pelage_asset asset;
  asset.hair = std::make_shared<const HairAsset>(*std::move(hair));
  return asset;
}

// Replaces the bones of a file by their indices in an array of names.
Result<void> mapByNames(std::vector<BoneName>& bones, std::vector<BoneInfluences>& influences,
                        const char* const* names, uint32_t count, int64_t fallback) {
  if (bones.empty()) return invalid("there are no bones with names: load them first");
  PELAGE_C_TRY(all, arrayOf<const char*>(names, count, "names"));
  if (fallback >= static_cast<int64_t>(count))
    return invalid("the fallback is bone {} of {}", fallback, count);
  std::unordered_map<std::string_view, uint32_t> indices;
  for (uint32_t i = 0; i < count; ++i) {
    if (all[i] == nullptr) return invalid("name {} is NULL", i);
    indices.emplace(all[i], i);
  }
  const auto lookup = [&](std::string_view name) -> std::optional<uint32_t> {
    const auto found = indices.find(name);
    return found == indices.end() ? std::nullopt : std::optional(found->second);
  };
  const auto instead = fallback < 0 ? std::nullopt : std::optional(static_cast<uint32_t>(fallback));
  PELAGE_C_TRY(mapped, mapBones(bones, influences, lookup, instead));
  influences = std::move(mapped);
  bones.clear();
  return {};
}

// Transforms that influences need, at least 1.
uint32_t boneCountOf(std::span<const BoneInfluences> influences) {
  uint32_t last = 0;
  for (const BoneInfluences& of : influences)
    last = std::max(last, *std::max_element(of.bones, of.bones + 4));
  return last + 1;
}

// A parameter of the table, with its struct in some settings.
struct NamedParameter {
  const SettingsSection* section = nullptr;
  const Parameter* parameter = nullptr;
  size_t index = 0;
};

Result<NamedParameter> parameterOf(const SceneSettings& settings, const char* text) {
  if (text == nullptr) return invalid("the name of a parameter is NULL");
  const std::string_view name = text;
  for (const SettingsSection& section : settingsSections())
    for (size_t index = 0; index < section.count(settings); ++index) {
      std::string prefix(section.key);
      if (section.isList) prefix += '[' + std::to_string(index) + ']';
      prefix += '.';
      if (!name.starts_with(prefix)) continue;
      for (const Parameter& parameter : section.parameters)
        if (name.substr(prefix.size()) == parameter.path)
          return NamedParameter{&section, &parameter, index};
    }
  return invalid(
      "'{}' is no parameter of these settings: docs/settings.md has the names, and "
      "pelage_settings_load() makes lights",
      name);
}

std::vector<double> numbersOf(const ParameterValue& value) {
  return std::visit(
      [](const auto& of) -> std::vector<double> {
        using T = std::decay_t<decltype(of)>;
        if constexpr (std::is_same_v<T, Float3>)
          return {of.x, of.y, of.z};
        else if constexpr (std::is_same_v<T, ParameterCurve>)
          return std::vector<double>(of.begin(), of.end());
        else
          return {static_cast<double>(of)};
      },
      value);
}

Error wrongCount(std::string_view name, size_t wanted, size_t given) {
  return invalid("'{}' has {} numbers, not {}", name, wanted, given);
}

// Beyond the range of floats: an infinity, for which check() has an error.
float toFloat(double number) {
  const bool fits = !std::isfinite(number) || std::abs(number) <= double{FLT_MAX};
  return static_cast<float>(fits ? number : std::copysign(double{INFINITY}, number));
}

Result<ParameterValue> valueOf(const Parameter& parameter, std::span<const double> numbers) {
  ParameterValue value = parameter.defaultValue;
  const size_t count = numbersOf(value).size();
  if (numbers.size() != count) return wrongCount(parameter.path, count, numbers.size());
  const double first = numbers[0];
  if (std::holds_alternative<bool>(value)) {
    if (first != 0 && first != 1) return invalid("'{}' must be 0 or 1", parameter.path);
    value = first == 1;
  } else if (std::holds_alternative<uint64_t>(value)) {
    if (!(first >= 0 && first <= 0x1p53) || first != std::floor(first))
      return invalid("'{}' must be a whole number in 0..2^53", parameter.path);
    value = static_cast<uint64_t>(first);
  } else if (std::holds_alternative<float>(value)) {
    value = toFloat(first);
  } else if (std::holds_alternative<Float3>(value)) {
    value = Float3{toFloat(first), toFloat(numbers[1]), toFloat(numbers[2])};
  } else {
    std::transform(numbers.begin(), numbers.end(), std::get<ParameterCurve>(value).begin(),
                   toFloat);
  }
  return value;
}

// A row of the table with texts that end in a zero.
struct ParameterTexts {
  const Parameter* parameter;
  std::string name, unit, range, meaning;
  std::vector<std::string> choices;
  std::vector<const char*> choicePointers;
};

const std::vector<ParameterTexts>& parameterTable() {
  static const std::vector<ParameterTexts> table = [] {
    std::vector<ParameterTexts> rows;
    for (const SettingsSection& section : settingsSections())
      for (const Parameter& p : section.parameters) {
        ParameterTexts& row = rows.emplace_back();
        row.parameter = &p;
        row.name = std::string(section.key) + (section.isList ? "[0]." : ".") + std::string(p.path);
        row.unit = p.unit;
        row.range = plainText(p.range);
        row.meaning = plainText(p.meaning);
        for (const std::string_view choice : p.choices) row.choices.push_back(choiceName(choice));
      }
    for (ParameterTexts& row : rows)
      for (const std::string& choice : row.choices) row.choicePointers.push_back(choice.c_str());
    return rows;
  }();
  return table;
}

// The settings of a handle; NULL: the defaults.
Result<SceneSettings> settingsOr(pelage_settings* handle) {
  if (handle == nullptr) return SceneSettings{};
  PELAGE_C_TRY(object, Handles::all().get(handle));
  return object->settings;
}

Error noObject(uint64_t id, const char* what) {
  return invalid("the id {} is of no {} of this scene: it is 0, removed, or of another scene", id,
                 what);
}
Result<HairObject*> hairOf(pelage_scene& s, pelage_id id) {
  if (!s.scene.isValid(HairId{id})) return noObject(id, "hair");
  return &s.scene.hair(HairId{id});
}
// Calls a function with hair, a collider or a skeleton.
template <class Function>
Result<void> visit(pelage_scene& s, pelage_id id, Function function) {
  if (s.scene.isValid(HairId{id})) return function(s.scene.hair(HairId{id}));
  if (s.scene.isValid(ColliderId{id})) return function(s.scene.collider(ColliderId{id}));
  if (s.scene.isValid(SkeletonId{id})) return function(s.scene.skeleton(SkeletonId{id}));
  return noObject(id, "object");
}
// The members that the definitions of hair and of colliders share.
template <class To, class From>
void setSkinning(To& to, const From& from, std::span<const BoneInfluences> influences) {
  if (from.name != nullptr) to.name = from.name;
  to.skeleton = SkeletonId{from.skeleton};
  if (from.bone_count > 0)
    to.boneCount = from.bone_count;
  else if (from.skeleton == 0)
    to.boneCount = boneCountOf(influences);
}

template <class Target>
Result<std::vector<Target>> targetsOf(const Target* targets, uint32_t count) {
  PELAGE_C_TRY(given, arrayOf<Target>(targets, count, "targets"));
  std::vector<Target> all;
  for (const Target& target : given) {
    PELAGE_C_TRY(checked, read(&target));
    all.push_back(checked);
  }
  return all;
}
#if PELAGE_C_VULKAN || PELAGE_C_GL
// A callback of a target; empty where there is none.
std::function<void(const FrameStep&)> callbackOf(void (*function)(void*, uint32_t, uint32_t),
                                                 void* user) {
  if (function == nullptr) return {};
  return [=](const FrameStep& step) { function(user, step.view, step.listOfView); };
}
#endif

}  // namespace

void pelage::c::setLastError(std::string&& message) noexcept {
  g_lastError = std::move(message);
  g_lastErrorText = g_lastError.empty() ? "out of memory" : g_lastError.c_str();
}

uint32_t pelage_version(void) { return libraryVersion(); }
const char* pelage_last_error(void) { return g_lastErrorText; }

pelage_result pelage_destroy(void* handle) {
  return call([&]() -> Result<void> {
    return handle != nullptr ? Handles::all().destroy(handle) : Result<void>();
  });
}

// Assets.
PELAGE_C_STRUCT(pelage_asset_def)
PELAGE_C_STRUCT(pelage_asset_info)

pelage_result pelage_asset_create(const pelage_asset_def* given, pelage_asset** asset) {
  return make(asset)([&]() -> Result<pelage_asset> {
    PELAGE_C_TRY(def, read(given));
    const uint64_t strands = def.strand_count, vertices = strands * def.vertices_per_strand;
    HairAsset hair;
    hair.strandCount = def.strand_count;
    hair.verticesPerStrand = def.vertices_per_strand;
    hair.positions = copyOf<Float4>(def.positions, vertices);
    hair.vertexCounts = copyOf<uint32_t>(def.vertex_counts, strands);
    hair.strandUv = copyOf<Float2>(def.strand_uv, strands);
    hair.strandThickness = copyOf<float>(def.strand_thickness, strands);
    hair.vertexColor = copyOf<Float4>(def.vertex_color, vertices);
    return process(std::move(hair));
  });
}

pelage_result pelage_asset_load_tfx(const char* name, const void* bytes, size_t size,
                                    pelage_asset** asset) {
  return make(asset)([&]() -> Result<pelage_asset> {
    return process(loadFrom(name, bytes, size, [](auto... from) { return loadTfx(from...); }));
  });
}

pelage_result pelage_asset_generate(uint64_t seed, uint32_t strand_count, pelage_asset** asset) {
  return make(asset)([&]() -> Result<pelage_asset> {
    PELAGE_C_TRY(groom, generateGroom({.seed = seed, .strandCount = strand_count}));
    return process(std::move(groom.hair));
  });
}

pelage_result pelage_asset_load_bones(pelage_asset* asset, const char* name, const void* bytes,
                                      size_t size) {
  return with(asset)([&](pelage_asset& to) -> Result<void> {
    const auto load = [&](auto... from) { return loadTfxBone(from..., to.hair->strandCount); };
    PELAGE_C_TRY(weights, loadFrom(name, bytes, size, load));
    to.bones = std::move(weights.bones);
    to.influences = std::move(weights.strands);
    return {};
  });
}

pelage_result pelage_asset_map_bones(pelage_asset* asset, const char* const* names, uint32_t count,
                                     int64_t fallback) {
  return with(asset)([&](pelage_asset& to) {
    return mapByNames(to.bones, to.influences, names, count, fallback);
  });
}

pelage_result pelage_asset_get_info(pelage_asset* asset, pelage_asset_info* info) {
  return with(asset)([&](pelage_asset& from) -> Result<void> {
    PELAGE_C_TRY(out, read(info));
    out.strand_count = from.hair->strandCount;
    out.vertices_per_strand = from.hair->verticesPerStrand;
    out.bone_count = boneCountOf(from.influences);
    out.name = from.name.c_str();
    out.positions = &from.hair->positions.data()->x;
    *info = out;
    return {};
  });
}

pelage_result pelage_mesh_create(const float* positions, const pelage_influences* influences,
                                 uint32_t vertex_count, const uint32_t* indices,
                                 uint32_t index_count, pelage_mesh** mesh) {
  return make(mesh)([&]() -> Result<pelage_mesh> {
    CollisionMesh made;
    made.positions = copyOf<Float3>(positions, vertex_count);
    made.normals.resize(made.positions.size());
    made.influences = copyOf<BoneInfluences>(influences, vertex_count);
    made.indices = copyOf<uint32_t>(indices, index_count);
    return pelage_mesh{std::move(made)};
  });
}

pelage_result pelage_mesh_load_tfxmesh(const char* name, const void* bytes, size_t size,
                                       pelage_mesh** mesh) {
  struct Load {
    auto operator()(const std::filesystem::path& path) const { return loadTfxMesh(path); }
    auto operator()(std::span<const std::byte> text, std::string_view of) const {
      return loadTfxMesh({reinterpret_cast<const char*>(text.data()), text.size()}, of);
    }
  };
  return make(mesh)([&]() -> Result<pelage_mesh> {
    PELAGE_C_TRY(loaded, loadFrom(name, bytes, size, Load()));
    return pelage_mesh{std::move(loaded)};
  });
}

pelage_result pelage_mesh_map_bones(pelage_mesh* mesh, const char* const* names, uint32_t count,
                                    int64_t fallback) {
  return with(mesh)([&](pelage_mesh& to) {
    return mapByNames(to.mesh.bones, to.mesh.influences, names, count, fallback);
  });
}

pelage_result pelage_cache_load(const char* name, const void* bytes, size_t size,
                                pelage_cache** cache) {
  return make(cache)([&]() -> Result<pelage_cache> {
    const auto load = [](auto... from) { return loadAssetCache(from...); };
    PELAGE_C_TRY(loaded, loadFrom(name, bytes, size, load));
    return pelage_cache{std::move(loaded)};
  });
}

pelage_result pelage_cache_get_counts(pelage_cache* cache, uint32_t* hairs, uint32_t* meshes) {
  return with(cache)([&](pelage_cache& from) -> Result<void> {
    if (hairs != nullptr) *hairs = static_cast<uint32_t>(from.cache.hairs.size());
    if (meshes != nullptr) *meshes = static_cast<uint32_t>(from.cache.meshes.size());
    return {};
  });
}

pelage_result pelage_cache_hair(pelage_cache* cache, uint32_t index, pelage_asset** asset) {
  return make(asset, cache)([&](pelage_cache& from) -> Result<pelage_asset> {
    if (index >= from.cache.hairs.size())
      return invalid("the cache has {} hairs", from.cache.hairs.size());
    const CachedHair& hair = from.cache.hairs[index];
    pelage_asset made;
    made.name = hair.name;
    made.hair = std::make_shared<const HairAsset>(hair.asset);
    made.followHairs = hair.followHairs;
    if (hair.bones) {
      made.bones = hair.bones->bones;
      made.influences = hair.bones->strands;
    }
    return made;
  });
}

pelage_result pelage_cache_mesh(pelage_cache* cache, uint32_t index, pelage_mesh** mesh) {
  return make(mesh, cache)([&](pelage_cache& from) -> Result<pelage_mesh> {
    if (index >= from.cache.meshes.size())
      return invalid("the cache has {} meshes", from.cache.meshes.size());
    return pelage_mesh{from.cache.meshes[index].mesh};
  });
}

// Settings.
PELAGE_C_STRUCT(pelage_parameter)

pelage_result pelage_settings_create(pelage_settings** settings) {
  return make(settings)([]() -> Result<pelage_settings> { return pelage_settings(); });
}

pelage_result pelage_settings_load(pelage_settings* settings, const char* name, const char* text) {
  return with(settings)([&](pelage_settings& to) -> Result<void> {
    if (name == nullptr) return invalid("the name of a file is NULL");
    PELAGE_C_TRY(
        file, text == nullptr ? SettingsFile::load(pathOf(name)) : SettingsFile::parse(text, name));
    file.apply(to.settings);
    return {};
  });
}

pelage_result pelage_settings_load_preset(pelage_settings* settings, const char* name) {
  return with(settings)([&](pelage_settings& to) -> Result<void> {
    if (name == nullptr) return invalid("the name of a preset is NULL");
    PELAGE_C_TRY(preset, presetSettings(name));
    to.settings = std::move(preset);
    return {};
  });
}

pelage_result pelage_settings_save(pelage_settings* settings, const char* path) {
  return with(settings)([&](pelage_settings& from) -> Result<void> {
    if (path == nullptr) return invalid("the name of a file is NULL");
    return saveSettings(pathOf(path), from.settings);
  });
}

pelage_result pelage_settings_set(pelage_settings* settings, const char* name,
                                  const double* numbers, uint32_t count) {
  return with(settings)([&](pelage_settings& to) -> Result<void> {
    PELAGE_C_TRY(named, parameterOf(to.settings, name));
    PELAGE_C_TRY(given, arrayOf<double>(numbers, count, "numbers"));
    PELAGE_C_TRY(value, valueOf(*named.parameter, given));
    if (Result<void> good = check(*named.parameter, value, name); !good) return good;
    named.section->set(to.settings, *named.parameter, value, named.index);
    return {};
  });
}

pelage_result pelage_settings_get(pelage_settings* settings, const char* name, double* numbers,
                                  uint32_t count) {
  return with(settings)([&](pelage_settings& from) -> Result<void> {
    PELAGE_C_TRY(named, parameterOf(from.settings, name));
    const auto all = numbersOf(named.section->get(from.settings, *named.parameter, named.index));
    if (count != all.size()) return wrongCount(name, all.size(), count);
    if (numbers == nullptr) return nullOutput();
    std::copy(all.begin(), all.end(), numbers);
    return {};
  });
}

uint32_t pelage_parameter_count(void) {
  uint32_t count = 0;
  call([&]() -> Result<void> {
    count = static_cast<uint32_t>(parameterTable().size());
    return {};
  });
  return count;
}

pelage_result pelage_parameter_get(uint32_t index, pelage_parameter* parameter) {
  return call([&]() -> Result<void> {
    PELAGE_C_TRY(out, read(parameter));
    const std::vector<ParameterTexts>& table = parameterTable();
    if (index >= table.size()) return invalid("there are {} parameters", table.size());
    const ParameterTexts& row = table[index];
    const std::vector<double> numbers = numbersOf(row.parameter->defaultValue);
    out.type = static_cast<uint32_t>(row.parameter->type);
    out.name = row.name.c_str();
    out.unit = row.unit.c_str();
    out.range = row.range.c_str();
    out.meaning = row.meaning.c_str();
    out.choices = row.choicePointers.data();
    out.choice_count = static_cast<uint32_t>(row.choices.size());
    out.number_count = static_cast<uint32_t>(numbers.size());
    out.low = row.parameter->low;
    out.high = row.parameter->high;
    out.slider_low = row.parameter->sliderLow;
    out.slider_high = row.parameter->sliderHigh;
    std::copy(numbers.begin(), numbers.end(), out.default_numbers);
    *parameter = out;
    return {};
  });
}

// Scenes.
template <>
pelage_hair_def pelage::c::defaultsOf() {
  pelage_hair_def def = {};
  def.name = "hair";
  return def;
}
PELAGE_C_STRUCT(pelage_hair_def)
PELAGE_C_STRUCT(pelage_hair_info)

template <>
pelage_collider_def pelage::c::defaultsOf() {
  const SdfColliderDef from;
  pelage_collider_def def = {};
  def.name = "collider";
  def.cell_size = from.cellSize;
  def.band = from.band;
  def.motion_tolerance = from.motionTolerance;
  def.memory_cap = from.memoryCap;
  return def;
}
PELAGE_C_STRUCT(pelage_collider_def)

pelage_result pelage_scene_create(pelage_scene** scene) {
  // Where it stays: a move of a scene makes another one.
  return produce(scene)([]() -> Result<pelage_scene*> {
    return Handles::all().add(std::make_shared<pelage_scene>());
  });
}

pelage_result pelage_scene_add_hair(pelage_scene* scene, pelage_asset* asset,
                                    const pelage_hair_def* given, pelage_id* hair) {
  return produce(hair, scene, asset)([&](pelage_scene& s, pelage_asset& of) -> Result<HairId> {
    PELAGE_C_TRY(from, readOr(given));
    PELAGE_C_TRY(settings, settingsOr(from.settings));
    PELAGE_C_TRY(influences,
                 arrayOf<BoneInfluences>(from.influences, from.influence_count, "influences"));
    const uint64_t texels = uint64_t{from.base_texture_width} * from.base_texture_height;
    PELAGE_C_TRY(texture, arrayOf<Float4>(from.base_texture, texels, "base_texture"));
    HairDef def;
    def.settings = settings.simulation;
    def.material = settings.material;
    apply(settings.creation, def);
    def.influences = influences.empty() ? of.influences : influences;
    setSkinning(def, from, def.influences);
    def.followHairs = of.followHairs;
    PELAGE_C_TRY(follows, of.hair->generateFollowHairs(settings.follow));
    if (!follows.empty()) def.followHairs = follows;
    def.baseTexture = {from.base_texture_width, from.base_texture_height, texture};
    PELAGE_C_TRY(added, s.scene.addHair(of.hair, def));
    HairObject& object = s.scene.hair(added);
    apply(settings.object, object);
    s.boneCounts[static_cast<pelage_id>(added)] = from.skeleton != 0 ? 0 : object.boneCount();
    return added;
  });
}

pelage_result pelage_scene_add_collider(pelage_scene* scene, pelage_mesh* mesh,
                                        const pelage_collider_def* given, pelage_id* collider) {
  return produce(collider, scene,
                 mesh)([&](pelage_scene& s, pelage_mesh& of) -> Result<ColliderId> {
    PELAGE_C_TRY(from, readOr(given));
    PELAGE_C_TRY(settings, settingsOr(from.settings));
    SdfColliderDef def;
    def.cellSize = from.cell_size;
    def.band = from.band;
    def.memoryCap = from.memory_cap;
    def.motionTolerance = from.motion_tolerance;
    def.skinning = settings.creation.skinning;
    setSkinning(def, from, of.mesh.influences);
    PELAGE_C_TRY(added, s.scene.addCollider(of.mesh, def));
    apply(settings.collider, s.scene.collider(added));
    s.boneCounts[static_cast<pelage_id>(added)] = from.skeleton != 0 ? 0 : def.boneCount;
    return added;
  });
}

pelage_result pelage_scene_add_skeleton(pelage_scene* scene, const char* name, uint32_t bone_count,
                                        pelage_id* skeleton) {
  return produce(skeleton, scene)([&](pelage_scene& s) -> Result<SkeletonId> {
    SkeletonDef def;
    if (name != nullptr) def.name = name;
    def.boneCount = bone_count;
    PELAGE_C_TRY(added, s.scene.addSkeleton(def));
    s.boneCounts[static_cast<pelage_id>(added)] = bone_count;
    return added;
  });
}

pelage_result pelage_scene_remove(pelage_scene* scene, pelage_id id) {
  return with(scene)([&](pelage_scene& s) -> Result<void> {
    Result<void> removed = noObject(id, "object");
    if (s.scene.isValid(HairId{id}))
      removed = s.scene.removeHair(HairId{id});
    else if (s.scene.isValid(ColliderId{id}))
      removed = s.scene.removeCollider(ColliderId{id});
    else if (s.scene.isValid(SkeletonId{id}))
      removed = s.scene.removeSkeleton(SkeletonId{id});
    if (removed) s.boneCounts.erase(id);
    return removed;
  });
}

pelage_result pelage_scene_set_settings(pelage_scene* scene, pelage_id id,
                                        pelage_settings* settings) {
  return with(scene, settings)([&](pelage_scene& s, pelage_settings& from) {
    return visit(s, id, [&](auto& object) -> Result<void> {
      using Object = std::decay_t<decltype(object)>;
      if constexpr (std::is_same_v<Object, SkeletonPose>) {
        return invalid("a skeleton has no settings");
      } else if constexpr (std::is_same_v<Object, SdfCollider>) {
        apply(from.settings.collider, object);
      } else {
        object.settings = from.settings.simulation;
        object.material = from.settings.material;
        apply(from.settings.object, object);
      }
      return {};
    });
  });
}

pelage_result pelage_scene_set_bones(pelage_scene* scene, pelage_id id,
                                     const pelage_transform* bones, uint32_t count) {
  return with(scene)([&](pelage_scene& s) {
    return visit(s, id, [&](auto& object) -> Result<void> {
      PELAGE_C_TRY(transforms, arrayOf<AffineTransform>(bones, count, "bones"));
      const uint32_t wanted = s.boneCounts[id];
      if (wanted == 0)
        return invalid("'{}' follows a skeleton: set the skeleton's bones", object.name());
      if (count != wanted)
        return invalid("'{}' has {} bones, not {}", object.name(), wanted, count);
      object.setBones(transforms);
      return {};
    });
  });
}

pelage_result pelage_scene_set_capsules(pelage_scene* scene, pelage_id hair,
                                        const pelage_capsule* capsules, uint32_t count) {
  return with(scene)([&](pelage_scene& s) -> Result<void> {
    PELAGE_C_TRY(object, hairOf(s, hair));
    PELAGE_C_TRY(all, arrayOf<CapsuleCollider>(capsules, count, "capsules"));
    object->setColliders(all);
    return {};
  });
}

pelage_result pelage_scene_set_mesh_colliders(pelage_scene* scene, pelage_id hair,
                                              const pelage_id* colliders, uint32_t count) {
  return with(scene)([&](pelage_scene& s) -> Result<void> {
    PELAGE_C_TRY(object, hairOf(s, hair));
    if (colliders == nullptr) return object->useAllMeshColliders(), Result<void>();
    PELAGE_C_TRY(all, arrayOf<ColliderId>(colliders, count, "colliders"));
    for (const ColliderId id : all)
      if (!s.scene.isValid(id)) return noObject(static_cast<uint64_t>(id), "collider");
    object->setMeshColliders(all);
    return {};
  });
}

pelage_result pelage_scene_set_forces(pelage_scene* scene, pelage_id hair,
                                      pelage_buffer_id forces) {
  return with(scene)([&](pelage_scene& s) -> Result<void> {
    PELAGE_C_TRY(object, hairOf(s, hair));
    object->setForces(BufferId{forces});
    return {};
  });
}

pelage_result pelage_scene_reset(pelage_scene* scene, pelage_id id) {
  return with(scene)([&](pelage_scene& s) {
    return visit(s, id, [](auto& object) -> Result<void> {
      if constexpr (std::is_same_v<std::decay_t<decltype(object)>, SkeletonPose>)
        return invalid("a skeleton has nothing to reset: reset what follows it");
      else
        return object.reset(), Result<void>();
    });
  });
}

pelage_result pelage_scene_teleport(pelage_scene* scene, pelage_id hair,
                                    const pelage_transform* motion) {
  return with(scene)([&](pelage_scene& s) -> Result<void> {
    PELAGE_C_TRY(transform, arrayOf<AffineTransform>(motion, 1, "motion"));
    return s.scene.teleport(HairId{hair}, transform[0]);
  });
}

pelage_result pelage_scene_shift_origin(pelage_scene* scene, const float shift[3]) {
  return with(scene)([&](pelage_scene& s) -> Result<void> {
    PELAGE_C_TRY(by, arrayOf<float>(shift, 3, "shift"));
    return s.scene.shiftOrigin(float3(by.data()));
  });
}

pelage_result pelage_scene_get_hair_info(pelage_scene* scene, pelage_id hair,
                                         pelage_hair_info* info) {
  return with(scene)([&](pelage_scene& s) -> Result<void> {
    PELAGE_C_TRY(out, read(info));
    PELAGE_C_TRY(object, hairOf(s, hair));
    out.guide_count = object->guideCount();
    out.follow_count = object->followCount();
    out.vertices_per_strand = object->verticesPerStrand();
    out.bone_count = object->boneCount();
    out.positions = static_cast<pelage_buffer_id>(object->buffers().positions);
    out.tangents = static_cast<pelage_buffer_id>(object->buffers().tangents);
    *info = out;
    return {};
  });
}

pelage_result pelage_scene_set_tier_of(pelage_scene* scene, void* runtime) {
  return with(scene)([&](pelage_scene& s) -> Result<void> {
    const Handles& handles = Handles::all();
    std::optional<Tier> tier;
    if (const auto of = handles.find<pelage_headless>(runtime)) tier = of->device->info().tier;
#if PELAGE_C_VULKAN
    if (const auto of = handles.find<pelage_vulkan_runtime>(runtime)) tier = of->runtime.tier();
#endif
#if PELAGE_C_GL
    if (const auto of = handles.find<pelage_gl_runtime>(runtime)) tier = of->runtime.tier();
#endif
    if (!tier) return handles.why(runtime, "runtime");
    s.scene.setTier(*tier);
    return {};
  });
}

pelage_result pelage_scene_add_buffer(pelage_scene* scene, const char* name, uint64_t size,
                                      const void* bytes, pelage_buffer_id* buffer) {
  return produce(buffer, scene)([&](pelage_scene& s) -> Result<BufferId> {
    if (size == 0 || size % 4 != 0)
      return invalid("a buffer has {} bytes: give a multiple of 4", size);
    BufferDesc desc = {.name = name != nullptr ? name : "buffer", .size = size, .stride = 4};
    desc.initial = copyOf<std::byte>(static_cast<const std::byte*>(bytes), size);
    const BufferId added = s.scene.resources().add(std::move(desc));
    s.buffers.insert(added);
    return added;
  });
}

pelage_result pelage_scene_remove_buffer(pelage_scene* scene, pelage_buffer_id buffer) {
  return with(scene)([&](pelage_scene& s) -> Result<void> {
    if (s.buffers.erase(BufferId{buffer}) == 0)
      return invalid("the buffer is none that pelage_scene_add_buffer() made in this scene");
    s.scene.resources().remove(BufferId{buffer});
    return {};
  });
}

pelage_result pelage_scene_take_snapshot(pelage_scene* scene, pelage_reader reader, void* user,
                                         pelage_snapshot** snapshot) {
  return make(snapshot, scene)([&](pelage_scene& s) -> Result<pelage_snapshot> {
    if (reader == nullptr) return invalid("the reader of a snapshot is NULL");
    const auto readAll = [&](BufferId id) -> Result<std::vector<std::byte>> {
      std::vector<std::byte> bytes(s.scene.resources().find(id)->size);
      const int code = reader(user, static_cast<pelage_buffer_id>(id), bytes.data(), bytes.size());
      if (code == PELAGE_OK) return bytes;
      const int known = std::clamp(code, 1, static_cast<int>(PELAGE_ERROR_DEVICE_LOST));
      return Error{static_cast<ErrorCode>(known - 1), "the reader of a snapshot failed"};
    };
    PELAGE_C_TRY(taken, s.scene.takeSnapshot(readAll));
    return pelage_snapshot{std::move(taken)};
  });
}

pelage_result pelage_scene_recover(pelage_scene* scene, pelage_snapshot* snapshot, uint32_t* kept) {
  return with(scene)([&](pelage_scene& s) -> Result<void> {
    SceneSnapshot from;
    if (snapshot != nullptr) {
      PELAGE_C_TRY(object, Handles::all().get(snapshot));
      from = object->snapshot;
    }
    PELAGE_C_TRY(count, s.scene.recover(from));
    if (kept != nullptr) *kept = count;
    return {};
  });
}

// Frames.
template <>
pelage_view pelage::c::defaultsOf() {
  const View from;
  pelage_view view = {};
  std::memcpy(view.world_to_clip, &from.worldToClip, sizeof(view.world_to_clip));
  view.samples = from.samples;
  return view;
}
PELAGE_C_STRUCT(pelage_view)

pelage_result pelage_view_look_at(pelage_view* view, const float eye[3], const float target[3],
                                  const float up[3], float vertical_fov, float near_plane,
                                  float far_plane) {
  return call([&]() -> Result<void> {
    PELAGE_C_TRY(out, read(view));
    if (eye == nullptr || target == nullptr || up == nullptr)
      return invalid("a vector of the camera is NULL");
    if (out.width == 0 || out.height == 0)
      return invalid("the view has no pixels: set its width and height first");
    const float aspect = static_cast<float>(out.width) / static_cast<float>(out.height);
    const Matrix4 matrix = lookAt(float3(eye), float3(target), float3(up), vertical_fov, aspect,
                                  near_plane, far_plane, out.reversed_depth != 0);
    std::memcpy(view->world_to_clip, &matrix, sizeof(matrix));
    std::copy_n(eye, 3, view->eye);
    return {};
  });
}

pelage_result pelage_scene_simulate(pelage_scene* scene, float dt, pelage_frame** frame) {
  return make(frame, scene)([&](pelage_scene& s) -> Result<pelage_frame> {
    PELAGE_C_TRY(begun, s.scene.simulate(dt));
    return pelage_frame{std::move(begun), s.spoiled};
  });
}

pelage_result pelage_frame_interpolate(pelage_frame* frame, float share) {
  return with(frame)([&](pelage_frame& f) { return f.frame.interpolate(share); });
}

pelage_result pelage_frame_draw(pelage_frame* frame, const pelage_view* given,
                                pelage_settings* settings, uint32_t* number) {
  return with(frame)([&](pelage_frame& f) -> Result<void> {
    PELAGE_C_TRY(from, read(given));
    PELAGE_C_TRY(of, settingsOr(settings));
    View view;
    std::memcpy(&view.worldToClip, from.world_to_clip, sizeof(from.world_to_clip));
    view.eye = float3(from.eye);
    view.x = static_cast<float>(from.x);
    view.y = static_cast<float>(from.y);
    view.width = from.width;
    view.height = from.height;
    view.samples = from.samples;
    view.reversedDepth = from.reversed_depth != 0;
    view.seed = from.seed;
    of.transparency.opaqueDepth = BufferId{from.opaque_depth};
    PELAGE_C_TRY(drawn, f.frame.draw(view, of.lights, of.transparency));
    if (number != nullptr) *number = drawn;
    return {};
  });
}

#if PELAGE_C_VULKAN
template <>
pelage_vulkan_runtime_def pelage::c::defaultsOf() {
  pelage_vulkan_runtime_def def = {};
  def.max_frames_in_flight = vulkan::RuntimeDef().maxFramesInFlight;
  return def;
}
PELAGE_C_STRUCT(pelage_vulkan_runtime_def)

template <>
pelage_vulkan_target pelage::c::defaultsOf() {
  const vulkan::TargetFormats from;
  pelage_vulkan_target target = {};
  target.color = from.color;
  target.depth = from.depth;
  target.samples = from.samples;
  return target;
}
PELAGE_C_STRUCT(pelage_vulkan_target)

pelage_result pelage_vulkan_runtime_create(const pelage_vulkan_runtime_def* given,
                                           pelage_vulkan_runtime** runtime) {
  return make(runtime)([&]() -> Result<pelage_vulkan_runtime> {
    PELAGE_C_TRY(from, read(given));
    vulkan::RuntimeDef def;
    def.instance = static_cast<VkInstance>(from.instance);
    def.physicalDevice = static_cast<VkPhysicalDevice>(from.physical_device);
    def.device = static_cast<VkDevice>(from.device);
    def.queueFamily = from.queue_family;
    if (from.enabled_features != nullptr)
      def.enabledFeatures = *static_cast<const VkPhysicalDeviceFeatures*>(from.enabled_features);
    def.getInstanceProcAddr =
        reinterpret_cast<PFN_vkGetInstanceProcAddr>(from.get_instance_proc_addr);
    def.allocationCallbacks = static_cast<const VkAllocationCallbacks*>(from.allocation_callbacks);
    def.pipelineCache = std::bit_cast<VkPipelineCache>(from.pipeline_cache);
    def.debugUtils = from.debug_utils != 0;
    def.pipelineThreads = from.pipeline_threads;
    def.maxFramesInFlight = from.max_frames_in_flight;
    PELAGE_C_TRY(made, vulkan::Runtime::create(def));
    return pelage_vulkan_runtime{std::move(made)};
  });
}

pelage_result pelage_vulkan_begin_frame(pelage_vulkan_runtime* runtime, uint64_t frame,
                                        uint64_t completed_frame) {
  return with(runtime)([&](pelage_vulkan_runtime& r) -> Result<void> {
    if (frame <= r.frame || completed_frame >= frame)
      return invalid("frame {} with {} completed comes behind frame {}: numbers rise, from 1",
                     frame, completed_frame, r.frame);
    r.frame = frame;
    r.runtime.beginFrame(frame, completed_frame);
    return {};
  });
}

pelage_result pelage_vulkan_record(pelage_vulkan_runtime* runtime, pelage_frame* frame,
                                   void* commands, const pelage_vulkan_target* targets,
                                   uint32_t target_count) {
  return with(runtime, frame)([&](pelage_vulkan_runtime& r, pelage_frame& f) -> Result<void> {
    if (r.frame == 0) return invalid("pelage_vulkan_begin_frame() comes first");
    if (commands == nullptr) return invalid("the command buffer is NULL");
    PELAGE_C_TRY(given, targetsOf(targets, target_count));
    std::vector<vulkan::ViewTarget> all;
    for (const pelage_vulkan_target& from : given) {
      vulkan::ViewTarget& to = all.emplace_back();
      to.formats.color = static_cast<VkFormat>(from.color);
      to.formats.depth = static_cast<VkFormat>(from.depth);
      to.formats.stencil = static_cast<VkFormat>(from.stencil);
      to.formats.samples = static_cast<VkSampleCountFlagBits>(from.samples);
      to.formats.renderPass = std::bit_cast<VkRenderPass>(from.render_pass);
      to.formats.subpass = from.subpass;
      to.formats.otherColorCount = from.other_color_count;
      for (size_t i = 0; i < std::size(from.other_colors); ++i)
        to.formats.otherColors[i] = static_cast<VkFormat>(from.other_colors[i]);
      to.area = {{from.x, from.y}, {from.width, from.height}};
      to.begin = callbackOf(from.begin, from.user);
      to.end = callbackOf(from.end, from.user);
    }
    return r.runtime.record(f.frame, static_cast<VkCommandBuffer>(commands), all);
  });
}

pelage_result pelage_vulkan_submitted(pelage_vulkan_runtime* runtime) {
  return with(runtime)(
      [](pelage_vulkan_runtime& r) { return r.runtime.submitted(), Result<void>(); });
}
pelage_result pelage_vulkan_abandon_frame(pelage_vulkan_runtime* runtime) {
  return with(runtime)(
      [](pelage_vulkan_runtime& r) { return r.runtime.abandonFrame(), Result<void>(); });
}
pelage_result pelage_vulkan_collect(pelage_vulkan_runtime* runtime, uint64_t completed_frame) {
  return with(runtime)([&](pelage_vulkan_runtime& r) -> Result<void> {
    if (completed_frame > r.frame) return invalid("frame {} has not begun", completed_frame);
    r.runtime.collect(completed_frame);
    return {};
  });
}

pelage_result pelage_vulkan_register_buffer(pelage_vulkan_runtime* runtime, pelage_buffer_id buffer,
                                            uint64_t vk_buffer, uint64_t offset) {
  return with(runtime)([&](pelage_vulkan_runtime& r) -> Result<void> {
    if (buffer == 0 || vk_buffer == 0) return invalid("the id or the VkBuffer is 0");
    if (offset % 4 != 0) return invalid("the offset is no multiple of 4");
    if (r.runtime.buffer(BufferId{buffer}).buffer != VK_NULL_HANDLE)
      return invalid("the id has a buffer: register yours before the first frame with it");
    vulkan::ExternalBuffer own;
    own.buffer = std::bit_cast<VkBuffer>(vk_buffer);
    own.offset = offset;
    r.runtime.registerBuffer(BufferId{buffer}, own);
    return {};
  });
}

pelage_result pelage_vulkan_buffer(pelage_vulkan_runtime* runtime, pelage_buffer_id buffer,
                                   uint64_t* vk_buffer, uint64_t* offset, uint64_t* size) {
  return with(runtime)([&](pelage_vulkan_runtime& r) -> Result<void> {
    if (vk_buffer == nullptr || offset == nullptr || size == nullptr) return nullOutput();
    const vulkan::BufferRange range = r.runtime.buffer(BufferId{buffer});
    if (range.buffer == VK_NULL_HANDLE)
      return invalid("the runtime has no buffer of this id: record a frame first");
    *vk_buffer = std::bit_cast<uint64_t>(range.buffer);
    *offset = range.offset;
    *size = range.size;
    return {};
  });
}
#endif

#if PELAGE_C_GL
PELAGE_C_STRUCT(pelage_gl_runtime_def)
PELAGE_C_STRUCT(pelage_gl_target)

pelage_result pelage_gl_runtime_create(const pelage_gl_runtime_def* given,
                                       pelage_gl_runtime** runtime) {
  return make(runtime)([&]() -> Result<pelage_gl_runtime> {
    PELAGE_C_TRY(from, read(given));
    if (from.get_proc_address == nullptr)
      return invalid("pelage_gl_runtime_def::get_proc_address is NULL");
    gl::RuntimeDef def;
    def.getProcAddress = [get = from.get_proc_address](const char* name) {
      return reinterpret_cast<void*>(get(name));
    };
    if (from.program_cache != nullptr)
      def.programCache = gl::directoryProgramCache(from.program_cache);
    def.debug = from.debug != 0;
    PELAGE_C_TRY(made, gl::Runtime::create(std::move(def)));
    return pelage_gl_runtime{std::move(made)};
  });
}

pelage_result pelage_gl_record(pelage_gl_runtime* runtime, pelage_frame* frame,
                               const pelage_gl_target* targets, uint32_t target_count,
                               uint32_t restore_state) {
  return with(runtime, frame)([&](pelage_gl_runtime& r, pelage_frame& f) -> Result<void> {
    PELAGE_C_TRY(given, targetsOf(targets, target_count));
    std::vector<gl::ViewTarget> all;
    for (const pelage_gl_target& from : given)
      all.push_back({{from.x, from.y, from.width, from.height}, callbackOf(from.begin, from.user)});
    std::optional<gl::StateGuard> guard;
    if (restore_state != 0) guard.emplace(r.runtime);
    return r.runtime.record(f.frame, all);
  });
}

pelage_result pelage_gl_register_buffer(pelage_gl_runtime* runtime, pelage_buffer_id buffer,
                                        uint32_t gl_name) {
  return with(runtime)([&](pelage_gl_runtime& r) -> Result<void> {
    if (buffer == 0) return invalid("the id of the buffer is 0");
    return r.runtime.registerBuffer(BufferId{buffer}, gl_name);
  });
}

pelage_result pelage_gl_buffer(pelage_gl_runtime* runtime, pelage_buffer_id buffer,
                               uint32_t* gl_name) {
  return produce(gl_name, runtime)([&](pelage_gl_runtime& r) -> Result<uint32_t> {
    const uint32_t name = r.runtime.bufferName(BufferId{buffer});
    if (name == 0) return invalid("the runtime has no buffer of this id: record a frame first");
    return name;
  });
}
#endif

// Devices without a window.
template <>
pelage_headless_def pelage::c::defaultsOf() {
  pelage_headless_def def = {};
  def.device_index = HeadlessDef().deviceIndex;
  return def;
}
PELAGE_C_STRUCT(pelage_headless_def)

template <>
pelage_headless_target pelage::c::defaultsOf() {
  pelage_headless_target target = {};
  target.samples = 1;
  target.clear_depth = 1;
  return target;
}
PELAGE_C_STRUCT(pelage_headless_target)

pelage_result pelage_headless_create(const pelage_headless_def* given, pelage_headless** device) {
  return make(device)([&]() -> Result<pelage_headless> {
    PELAGE_C_TRY(from, readOr(given));
    if (from.api > PELAGE_GLES) return invalid("pelage_headless_def::api is no pelage_api");
    HeadlessDef def;
    def.api = static_cast<Api>(from.api);
    def.validation = from.validation != 0;
    def.deviceIndex = from.device_index;
    Result<std::unique_ptr<HeadlessDevice>> made =
        Error{ErrorCode::kUnsupported, "this library was built without the runtime of the API"};
#if PELAGE_C_VULKAN
    if (def.api == Api::kVulkan) made = createHeadlessVulkan(def);
#endif
#if PELAGE_C_GL
    if (def.api != Api::kVulkan) made = createHeadlessGl(def);
#endif
    if (!made) return made.error();
    return pelage_headless{*std::move(made)};
  });
}

pelage_result pelage_headless_get_name(pelage_headless* device, const char** name) {
  return produce(name, device)(
      [](pelage_headless& d) -> Result<const char*> { return d.device->info().name.c_str(); });
}

pelage_result pelage_headless_run(pelage_headless* device, pelage_frame* frame,
                                  const pelage_headless_target* targets, uint32_t target_count) {
  return with(device, frame)([&](pelage_headless& d, pelage_frame& f) -> Result<void> {
    PELAGE_C_TRY(given, targetsOf(targets, target_count));
    if (given.empty()) return d.device->run(f.frame);
    std::vector<RenderTargetDef> all;
    for (const pelage_headless_target& from : given) {
      if (from.pixels == nullptr) return invalid("pelage_headless_target::pixels is NULL");
      RenderTargetDef& to = all.emplace_back();
      to.width = from.width;
      to.height = from.height;
      to.samples = from.samples;
      std::memcpy(&to.clearColor, from.clear_color, sizeof(from.clear_color));
      to.clearDepth = from.clear_depth;
      to.area = {from.x, from.y, from.area_width, from.area_height};
    }
    PELAGE_C_TRY(images, d.device->render(f.frame, all));
    for (size_t i = 0; i < images.size(); ++i)
      std::memcpy(given[i].pixels, images[i].pixels.data(),
                  images[i].pixels.size() * sizeof(Float4));
    return {};
  });
}

pelage_result pelage_read(void* runtime, pelage_buffer_id buffer, uint64_t offset, void* bytes,
                          uint64_t size) {
  return call([&]() -> Result<void> {
    if (bytes == nullptr || size == 0) return invalid("there is no room for the bytes to read");
    const Handles& handles = Handles::all();
    Result<std::vector<std::byte>> found = handles.why(runtime, "device to read from");
    if (const auto from = handles.find<pelage_headless>(runtime))
      found = from->device->read(BufferId{buffer}, offset, size);
#if PELAGE_C_GL
    if (const auto from = handles.find<pelage_gl_runtime>(runtime))
      found = from->runtime.read(BufferId{buffer}, offset, size);
#endif
    if (!found) return found.error();
    std::memcpy(bytes, found->data(), found->size());
    return {};
  });
}
// NOLINTEND(readability-identifier-naming)
