// Misuse of the C interface ends in an error code and a message, and changes nothing: handles that
// are null, of another kind or destroyed; structs of another size; values out of range; no memory.
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <functional>
#include <limits>
#include <string>
#include <thread>
#include <vector>

#include "c/c_objects.h"
#include "pelage/asset_cache.h"
#include "pelage/settings/scene_settings.h"
#include "support/counted_new.h"
#include "support/plain_asset.h"
#include "support/test_folder.h"

namespace pelage::test {
namespace {

constexpr float kNan = std::numeric_limits<float>::quiet_NaN();

pelage_asset_def smallAssetDef() {
  static const float positions[] = {0, 0, 0, 0, 0, 0.1f, 0, 0, 0, 0.2f, 0, 1,
                                    1, 0, 0, 0, 1, 0.1f, 0, 0, 1, 0.2f, 0, 1};
  auto def = made(pelage_asset_def_init);
  def.strand_count = 2;
  def.vertices_per_strand = 3;
  def.positions = positions;
  return def;
}
Handle<pelage_asset> smallAsset() {
  const pelage_asset_def def = smallAssetDef();
  return Handle<pelage_asset>(pelage_asset_create, &def);
}

class CMisuse : public testing::Test {
 protected:
  CMisuse() { expectOk(pelage_scene_add_hair(scene_, asset_, nullptr, &hair_)); }
  template <class T>
  static T* as(void* handle) {
    return static_cast<T*>(handle);
  }

  Handle<pelage_asset> asset_ = smallAsset();
  Handle<pelage_scene> scene_{pelage_scene_create};
  Handle<pelage_settings> settings_{pelage_settings_create};
  pelage_id hair_ = 0;
};

// Every function that takes handles, with one in place of all of them.
std::vector<pelage_result> callAll(void* handle) {
  static float numbers[16] = {};
  static double number = 0;
  static uint64_t words[3] = {};
  static pelage_transform transform = {};
  static const char* text = nullptr;
  auto view = made(pelage_view_init);
  auto hairInfo = made(pelage_hair_info_init);
  auto assetInfo = made(pelage_asset_info_init);
  const auto reader = [](void*, pelage_buffer_id, void*, uint64_t) { return PELAGE_OK; };
  auto* asset = static_cast<pelage_asset*>(handle);
  auto* mesh = static_cast<pelage_mesh*>(handle);
  auto* cache = static_cast<pelage_cache*>(handle);
  auto* settings = static_cast<pelage_settings*>(handle);
  auto* scene = static_cast<pelage_scene*>(handle);
  auto* frame = static_cast<pelage_frame*>(handle);
  auto* device = static_cast<pelage_headless*>(handle);
  pelage_asset* newAsset = nullptr;
  pelage_mesh* newMesh = nullptr;
  pelage_frame* newFrame = nullptr;
  pelage_snapshot* newSnapshot = nullptr;
  std::vector<pelage_result> results = {
      pelage_asset_load_bones(asset, "x", "", 0),
      pelage_asset_map_bones(asset, nullptr, 0, -1),
      pelage_asset_get_info(asset, &assetInfo),
      pelage_mesh_map_bones(mesh, nullptr, 0, -1),
      pelage_cache_get_counts(cache, nullptr, nullptr),
      pelage_cache_hair(cache, 0, &newAsset),
      pelage_cache_mesh(cache, 0, &newMesh),
      pelage_settings_load(settings, "x", "{}"),
      pelage_settings_load_preset(settings, "curly"),
      pelage_settings_save(settings, "/nowhere/x"),
      pelage_settings_set(settings, "simulation.damping", &number, 1),
      pelage_settings_get(settings, "simulation.damping", &number, 1),
      pelage_scene_add_hair(scene, asset, nullptr, words),
      pelage_scene_add_collider(scene, mesh, nullptr, words),
      pelage_scene_add_skeleton(scene, "x", 1, words),
      pelage_scene_remove(scene, 1),
      pelage_scene_set_settings(scene, 1, settings),
      pelage_scene_set_bones(scene, 1, &transform, 1),
      pelage_scene_set_capsules(scene, 1, nullptr, 0),
      pelage_scene_set_mesh_colliders(scene, 1, nullptr, 0),
      pelage_scene_set_forces(scene, 1, 0),
      pelage_scene_reset(scene, 1),
      pelage_scene_teleport(scene, 1, &transform),
      pelage_scene_shift_origin(scene, numbers),
      pelage_scene_get_hair_info(scene, 1, &hairInfo),
      pelage_scene_set_tier_of(scene, handle),
      pelage_scene_add_buffer(scene, "x", 16, nullptr, words),
      pelage_scene_remove_buffer(scene, 1),
      pelage_scene_take_snapshot(scene, reader, nullptr, &newSnapshot),
      pelage_scene_recover(scene, nullptr, nullptr),
      pelage_scene_simulate(scene, kDt, &newFrame),
      pelage_frame_interpolate(frame, 0),
      pelage_frame_draw(frame, &view, nullptr, nullptr),
      pelage_headless_get_name(device, &text),
      pelage_headless_run(device, frame, nullptr, 0),
      pelage_read(handle, 1, 0, numbers, 16),
  };
#if PELAGE_TEST_VULKAN
  auto* vulkan = static_cast<pelage_vulkan_runtime*>(handle);
  for (const pelage_result result :
       {pelage_vulkan_begin_frame(vulkan, 1, 0),
        pelage_vulkan_record(vulkan, frame, numbers, nullptr, 0), pelage_vulkan_submitted(vulkan),
        pelage_vulkan_abandon_frame(vulkan), pelage_vulkan_collect(vulkan, 0),
        pelage_vulkan_register_buffer(vulkan, 1, 1, 0),
        pelage_vulkan_buffer(vulkan, 1, words, words + 1, words + 2)})
    results.push_back(result);
#endif
#if PELAGE_TEST_GL
  auto* gl = static_cast<pelage_gl_runtime*>(handle);
  uint32_t name = 0;
  for (const pelage_result result :
       {pelage_gl_record(gl, frame, nullptr, 0, 0), pelage_gl_register_buffer(gl, 1, 1),
        pelage_gl_buffer(gl, 1, &name)})
    results.push_back(result);
#endif
  EXPECT_EQ(newAsset, nullptr);
  EXPECT_EQ(newMesh, nullptr);
  EXPECT_EQ(newFrame, nullptr);
  EXPECT_EQ(newSnapshot, nullptr);
  return results;
}

TEST_F(CMisuse, HandlesThatAreNoneAreErrorsOfEveryCall) {
  Handle<pelage_mesh> gone(pelage_mesh_create, nullptr, nullptr, 0u, nullptr, 0u);
  void* const destroyed = static_cast<pelage_mesh*>(gone);
  gone.destroy();
  int local = 0;
  // A snapshot is an argument of none of them.
  const auto reader = [](void*, pelage_buffer_id, void*, uint64_t) { return PELAGE_ERROR_DEVICE; };
  Handle<pelage_scene> empty(pelage_scene_create);
  Handle<pelage_snapshot> snapshot(pelage_scene_take_snapshot, static_cast<pelage_scene*>(empty),
                                   static_cast<pelage_reader>(reader), nullptr);
  const struct {
    void* handle;
    const char* words;
  } cases[] = {{nullptr, "is NULL"},
               {&local, "no handle"},
               {destroyed, "destroyed"},
               {static_cast<pelage_snapshot*>(snapshot), "is a pelage_snapshot"}};
  for (const auto& of : cases) {
    for (const pelage_result result : callAll(of.handle))
      EXPECT_EQ(result, PELAGE_ERROR_INVALID_ARGUMENT) << of.words;
    // The message of the last call.
    expectHas(pelage_last_error(), of.words);
  }
  for (void* handle : {destroyed, static_cast<void*>(&local)})
    expectInvalid(pelage_destroy(handle), "destroyed");
  expectOk(pelage_destroy(nullptr));
  expectInvalid(pelage_scene_set_settings(scene_, hair_, as<pelage_settings>(asset_)),
                "the pelage_settings is a pelage_asset");
}

TEST_F(CMisuse, StructsOfAnotherSizeAreRefused) {
  // A header with a member less: init leaves the memory behind the struct alone.
  std::array<unsigned char, sizeof(pelage_view)> bytes;
  bytes.fill(0xaa);
  auto* view = reinterpret_cast<pelage_view*>(bytes.data());
  expectInvalid(pelage_view_init(view, sizeof(pelage_view) - 8), "pelage_view_init()");
  for (const unsigned char byte : bytes) EXPECT_EQ(byte, 0xaa);
  expectInvalid(pelage_view_init(nullptr, sizeof(pelage_view)), "NULL");

  pelage_hair_def hairDef = {};
  pelage_id hair = 5;
  expectInvalid(pelage_scene_add_hair(scene_, asset_, &hairDef, &hair), "pelage_hair_def has 0");
  EXPECT_EQ(hair, 0u);
  Handle<pelage_frame> frame(pelage_scene_simulate, static_cast<pelage_scene*>(scene_), kDt);
  auto wrong = made(pelage_view_init);
  ++wrong.struct_size;
  expectInvalid(pelage_frame_draw(frame, &wrong, nullptr, nullptr), "pelage_view has");
  expectInvalid(pelage_frame_draw(frame, nullptr, nullptr, nullptr), "pelage_view is NULL");
  pelage_hair_info info = {};
  expectInvalid(pelage_scene_get_hair_info(scene_, hair_, &info), "pelage_hair_info_init()");
  pelage_asset_def assetDef = {};
  pelage_asset* asset = nullptr;
  expectInvalid(pelage_asset_create(&assetDef, &asset), "pelage_asset_def_init()");
}

TEST_F(CMisuse, ResultsHaveToGoSomewhere) {
  expectInvalid(pelage_scene_create(nullptr), "takes the result is NULL");
  expectInvalid(pelage_scene_simulate(scene_, kDt, nullptr), "takes the result is NULL");
  expectInvalid(pelage_scene_add_hair(scene_, asset_, nullptr, nullptr), "takes the result");
  expectInvalid(pelage_asset_get_info(asset_, nullptr), "pelage_asset_info is NULL");
}

TEST_F(CMisuse, ValuesOutOfRangeAreTheErrorsOfCpp) {
  pelage_frame* frame = nullptr;
  for (const float dt : {-1.0f, kNan})
    expectInvalid(pelage_scene_simulate(scene_, dt, &frame), "time step");
  EXPECT_EQ(frame, nullptr);
  pelage_asset* asset = nullptr;
  expectInvalid(pelage_asset_generate(1, 0, &asset), "strandCount");
  auto def = made(pelage_asset_def_init);
  def.strand_count = 0xffffffffu;
  def.vertices_per_strand = 0xffffffffu;
  expectInvalid(pelage_asset_create(&def, &asset), "");
  expectError(pelage_asset_load_tfx("/nowhere.tfx", nullptr, 0, &asset),
              PELAGE_ERROR_FILE_NOT_FOUND, {"/nowhere.tfx"});
  expectError(pelage_asset_load_tfx("archive/hair.tfx", "short", 5, &asset),
              PELAGE_ERROR_INVALID_FILE, {"archive/hair.tfx"});
  expectInvalid(pelage_asset_load_tfx(nullptr, "short", 5, &asset), "NULL");
  EXPECT_EQ(asset, nullptr);

  const pelage_transform bones[2] = {};
  expectInvalid(pelage_scene_set_bones(scene_, hair_, bones, 2), "'hair' has 1 bones, not 2");
  expectInvalid(pelage_scene_set_bones(scene_, hair_, nullptr, 1), "'bones' is NULL");
  expectInvalid(pelage_scene_set_capsules(scene_, hair_, nullptr, 3), "'capsules' is NULL");
  expectInvalid(pelage_scene_teleport(scene_, hair_, bones), "");  // its rows are 0
  const float shift[3] = {kNan, 0, 0};
  expectInvalid(pelage_scene_shift_origin(scene_, shift), "");
  expectInvalid(pelage_scene_set_mesh_colliders(scene_, hair_, &hair_, 1), "no collider");
  pelage_buffer_id buffer = 0;
  expectInvalid(pelage_scene_add_buffer(scene_, "odd", 6, nullptr, &buffer), "multiple of 4");
  expectInvalid(pelage_scene_remove_buffer(scene_, infoOf(scene_, hair_).positions), "none that");
  // Noticed by the next frame.
  expectOk(pelage_scene_set_forces(scene_, hair_, 12345));
  expectInvalid(pelage_scene_simulate(scene_, kDt, &frame), "does not exist");
  expectOk(pelage_scene_set_forces(scene_, hair_, 0));

  pelage_headless* device = nullptr;
  auto headless = made(pelage_headless_def_init);
  headless.api = 7;
  expectInvalid(pelage_headless_create(&headless, &device), "no pelage_api");
}

TEST_F(CMisuse, IdsAreOfTheirSceneAndTheirKind) {
  Handle<pelage_scene> other(pelage_scene_create);
  auto info = made(pelage_hair_info_init);
  for (pelage_scene* scene :
       {static_cast<pelage_scene*>(scene_), static_cast<pelage_scene*>(other)})
    expectInvalid(pelage_scene_get_hair_info(scene, scene == other ? hair_ : 0, &info), "no hair");
  pelage_id skeleton = 0;
  expectOk(pelage_scene_add_skeleton(scene_, "walker", 3, &skeleton));
  expectInvalid(pelage_scene_get_hair_info(scene_, skeleton, &info), "no hair");
  expectInvalid(pelage_scene_reset(scene_, skeleton), "skeleton");
  expectInvalid(pelage_scene_set_settings(scene_, skeleton, settings_), "skeleton");
  const std::vector<pelage_transform> bones(3);
  expectOk(pelage_scene_set_bones(scene_, skeleton, bones.data(), 3));

  auto def = made(pelage_hair_def_init);
  def.skeleton = skeleton;
  pelage_id follower = 0;
  expectOk(pelage_scene_add_hair(scene_, asset_, &def, &follower));
  EXPECT_EQ(infoOf(scene_, follower).bone_count, 3u);
  expectInvalid(pelage_scene_set_bones(scene_, follower, bones.data(), 3), "follows a skeleton");
  expectInvalid(pelage_scene_remove(scene_, skeleton), "");
  expectOk(pelage_scene_remove(scene_, follower));
  expectInvalid(pelage_scene_remove(scene_, follower), "removed");
  expectOk(pelage_scene_remove(scene_, skeleton));
}

TEST_F(CMisuse, ObjectsMayBeDestroyedInAnyOrder) {
  asset_.destroy();
  settings_.destroy();
  pelage_frame* frame = nullptr;
  expectOk(pelage_scene_simulate(scene_, kDt, &frame));
  expectOk(pelage_scene_remove(scene_, hair_));
  scene_.destroy();
  auto view = made(pelage_view_init);
  view.width = view.height = 8;
  expectInvalid(pelage_frame_draw(frame, &view, nullptr, nullptr), "scene");
  expectInvalid(pelage_frame_interpolate(frame, 0.5f), "scene");
  expectOk(pelage_destroy(frame));
}

TEST_F(CMisuse, MessagesAreThoseOfAThread) {
  expectInvalid(pelage_scene_remove(scene_, 0), "the id 0");
  std::thread([] {
    EXPECT_STREQ(pelage_last_error(), "");
    expectInvalid(pelage_destroy(&g_allocationsLeft), "destroyed");
  }).join();
  expectHas(pelage_last_error(), "the id 0");
}

// The calls of an application, one at a time; the last one has as much memory as it is given.
class Session {
 public:
  static constexpr size_t kCalls = 11;

  ~Session() {
    for (void* handle : std::initializer_list<void*>{frame_, scene_, settings_, asset_})
      expectOk(pelage_destroy(handle));
  }
  pelage_result call(size_t index) {
    static const std::vector<pelage_capsule> capsules(3);
    static const float eye[3] = {0, 0.1f, 1}, target[3] = {0, 0.1f, 0}, up[3] = {0, 1, 0};
    auto parameter = made(pelage_parameter_init);
    auto view = made(pelage_view_init);
    view.width = view.height = 8;
    expectOk(pelage_view_look_at(&view, eye, target, up, 0.5f, 0.1f, 10));
    auto def = smallAssetDef();
    const Limited limited(index == limitedCall_ ? limit_ : -1);
    switch (index) {
      case 0:
        return pelage_asset_create(&def, &asset_);
      case 1:
        return pelage_settings_create(&settings_);
      case 2:
        return pelage_parameter_get(3, &parameter);
      case 3:
        return pelage_scene_create(&scene_);
      case 4:
        return pelage_scene_add_hair(scene_, asset_, nullptr, &hair_);
      case 5:
        return pelage_scene_add_skeleton(scene_, "x", 3, &skeleton_);
      case 6:
        return pelage_scene_set_capsules(scene_, hair_, capsules.data(), 3);
      case 7:
        return pelage_scene_add_buffer(scene_, "a long name", 160, nullptr, &buffer_);
      case 8:
        return pelage_scene_simulate(scene_, kDt, &frame_);
      case 9:
        return pelage_frame_draw(frame_, &view, settings_, nullptr);
      default:
        return pelage_settings_load_preset(settings_, "a name that is no preset's");
    }
  }
  /// \return the result of the call with few allocations
  pelage_result play(size_t limitedCall, int64_t limit) {
    limitedCall_ = limitedCall;
    limit_ = limit;
    for (size_t i = 0; i < limitedCall; ++i) expectOk(call(i));
    return call(limitedCall);
  }
  pelage_scene* scene() const { return scene_; }

 private:
  struct Limited {
    explicit Limited(int64_t limit) { g_allocationsLeft = limit; }
    ~Limited() { g_allocationsLeft = -1; }
  };
  size_t limitedCall_ = 0;
  int64_t limit_ = -1;
  pelage_asset* asset_ = nullptr;
  pelage_scene* scene_ = nullptr;
  pelage_frame* frame_ = nullptr;
  pelage_settings* settings_ = nullptr;
  pelage_id hair_ = 0, skeleton_ = 0;
  pelage_buffer_id buffer_ = 0;
};

TEST(CMemory, MayRunOutInEveryAllocationOfACall) {
  for (size_t index = 0; index < Session::kCalls; ++index) {
    int64_t limit = 0;
    for (pelage_result result = PELAGE_ERROR_OUT_OF_MEMORY;
         result == PELAGE_ERROR_OUT_OF_MEMORY && limit < 5000; ++limit) {
      Session session;
      result = session.play(index, limit);
      if (index + 1 == Session::kCalls && result != PELAGE_ERROR_OUT_OF_MEMORY) {
        expectInvalid(result, "no preset");
      } else if (result != PELAGE_ERROR_OUT_OF_MEMORY) {
        expectOk(result);
      } else {
        expectHas(pelage_last_error(), "memory");
        pelage_frame* frame = nullptr;
        if (index > 3 && index < 10)
          expectInvalid(pelage_scene_simulate(session.scene(), kDt, &frame), "destroy it");
      }
    }
    EXPECT_GT(limit, 1) << "call " << index << " allocates nothing";
    EXPECT_LT(limit, 5000) << "call " << index << " does not end";
  }
}

class CSettings : public testing::Test {
 protected:
  Handle<pelage_settings> settings_{pelage_settings_create};
};

TEST_F(CSettings, HaveTheParametersOfTheTable) {
  size_t index = 0;
  SceneSettings defaults;
  for (const SettingsSection& section : settingsSections())
    for (const Parameter& parameter : section.parameters) {
      auto row = made(pelage_parameter_init);
      expectOk(pelage_parameter_get(static_cast<uint32_t>(index++), &row));
      const std::string name =
          std::string(section.key) + (section.isList ? "[0]." : ".") + std::string(parameter.path);
      EXPECT_EQ(row.name, name);
      EXPECT_EQ(row.type, static_cast<uint32_t>(parameter.type)) << name;
      EXPECT_EQ(row.unit, parameter.unit) << name;
      EXPECT_EQ(row.choice_count, parameter.choices.size()) << name;
      for (uint32_t i = 0; i < row.choice_count; ++i)
        EXPECT_EQ(row.choices[i], choiceName(parameter.choices[i])) << name;
      // The default is valid, and can be set again.
      double numbers[8] = {};
      expectOk(pelage_settings_get(settings_, row.name, numbers, row.number_count));
      for (uint32_t i = 0; i < row.number_count; ++i)
        EXPECT_EQ(numbers[i], row.default_numbers[i]) << name;
      expectOk(pelage_settings_set(settings_, row.name, numbers, row.number_count));
      expectInvalid(pelage_settings_set(settings_, row.name, numbers, row.number_count + 1),
                    "numbers");
      expectInvalid(pelage_settings_get(settings_, row.name, numbers, 0), "numbers");
      for (const double wrong : {std::nan(""), -1e300}) {
        numbers[0] = wrong;
        expectInvalid(pelage_settings_set(settings_, row.name, numbers, row.number_count), "");
      }
    }
  EXPECT_EQ(index, pelage_parameter_count());
  auto row = made(pelage_parameter_init);
  expectInvalid(pelage_parameter_get(static_cast<uint32_t>(index), &row), "parameters");
}

TEST_F(CSettings, AreRefusedByName) {
  const double two = 2, half = 0.5;
  expectInvalid(pelage_settings_set(settings_, "simulation.damping", &two, 1),
                "'simulation.damping' is 2, but must be in 0..1");
  expectInvalid(pelage_settings_set(settings_, "simulation.subSteps", &half, 1), "whole number");
  expectInvalid(pelage_settings_set(settings_, "object.visible", &two, 1), "0 or 1");
  expectInvalid(pelage_settings_set(settings_, "simulation.damping", nullptr, 1), "NULL");
  for (const char* name : {"damping", "simulation", "simulation.", "lights.color",
                           "lights[1].color", "lights[x].color", "simulation.damping.x", ""})
    expectInvalid(pelage_settings_set(settings_, name, &half, 1), "is no parameter");
  expectInvalid(pelage_settings_set(settings_, nullptr, &half, 1), "NULL");
  expectError(pelage_settings_load(settings_, "look.json", "{"), PELAGE_ERROR_INVALID_FILE,
              {"look.json"});
  expectInvalid(pelage_settings_load_preset(settings_, "bald"), "curly");
}

TEST_F(CSettings, GoToFilesAndBack) {
  const TestFolder folder;
  const std::string path = folder / "settings.json";
  const double bend = 0.08, wind[3] = {1, 2, 3};
  expectOk(pelage_settings_load(settings_, "x", R"({"lights": [{"shadow": "deep"}, {}]})"));
  expectOk(pelage_settings_set(settings_, "simulation.bendLength", &bend, 1));
  expectOk(pelage_settings_set(settings_, "simulation.wind.velocity", wind, 3));
  expectOk(pelage_settings_save(settings_, path.c_str()));
  Handle<pelage_settings> again(pelage_settings_create);
  expectOk(pelage_settings_load(again, path.c_str(), nullptr));
  double number = 0, numbers[3] = {};
  expectOk(pelage_settings_get(again, "simulation.bendLength", &number, 1));
  EXPECT_EQ(static_cast<float>(number), 0.08f);
  expectOk(pelage_settings_get(again, "simulation.wind.velocity", numbers, 3));
  EXPECT_EQ(numbers[2], 3);
  expectOk(pelage_settings_get(again, "lights[0].shadow", &number, 1));
  EXPECT_EQ(number, 2);
  expectOk(pelage_settings_get(again, "lights[1].shadow", &number, 1));
  EXPECT_EQ(number, 0);
}

TEST(CAssets, AreThoseOfFilesAndArchives) {
  const TestFolder folder;
  const HairAsset hair = makeAsset(2, 5);
  BoneWeights weights;
  weights.bones = {{0, "head"}, {1, "ear"}};
  weights.strands = {{{0, 1, 0, 0}, {1, 1, 0, 0}}, {{1, 0, 0, 0}, {1, 0, 0, 0}}};
  CollisionMesh mesh;
  mesh.bones = weights.bones;
  mesh.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
  mesh.normals.resize(3);
  mesh.influences.assign(3, {{1, 0, 0, 0}, {1, 0, 0, 0}});
  mesh.indices = {0, 1, 2};
  const std::string tfx = folder / "hair.tfx", cachePath = folder / "all.pelage";
  required(saveTfx(hair, tfx));
  const auto bones = required(saveTfxBone(weights));
  const auto text = required(saveTfxMesh(mesh));
  HairAsset cachedHair = hair;
  required(saveAssetCache(
      {.sources = {},
       .hairs = {{"beard", cachedHair, weights, {FollowHair{.guide = 1, .offset = {}}}}},
       .meshes = {{"face", mesh}}},
      cachePath));

  Handle<pelage_asset> fromFile(pelage_asset_load_tfx, tfx.c_str(), nullptr, size_t{0});
  const std::vector<std::byte> bytes = bytesOf(tfx);
  Handle<pelage_asset> asset(pelage_asset_load_tfx, "archive/hair.tfx",
                             static_cast<const void*>(bytes.data()), bytes.size());
  const char* const wrongNames[] = {"hand", "ear"};
  expectInvalid(pelage_asset_map_bones(asset, wrongNames, 2, -1), "load them first");
  expectOk(pelage_asset_load_bones(asset, "hair.tfxbone", bones->data(), bones->size()));
  expectError(pelage_asset_map_bones(asset, wrongNames, 2, -1), PELAGE_ERROR_INVALID_ARGUMENT,
              {"head"});
  expectInvalid(pelage_asset_map_bones(asset, wrongNames, 2, 2), "fallback");
  const char* const names[] = {"ear", "hand", "hip", "head"};
  expectOk(pelage_asset_map_bones(asset, names, 4, -1));

  Handle<pelage_cache> cache(pelage_cache_load, cachePath.c_str(), nullptr, size_t{0});
  uint32_t hairs = 0, meshes = 0;
  expectOk(pelage_cache_get_counts(cache, &hairs, &meshes));
  EXPECT_EQ(hairs + meshes, 2u);
  Handle<pelage_asset> cached(pelage_cache_hair, static_cast<pelage_cache*>(cache), 0u);
  Handle<pelage_mesh> face(pelage_cache_mesh, static_cast<pelage_cache*>(cache), 0u);
  pelage_asset* none = nullptr;
  expectInvalid(pelage_cache_hair(cache, 1, &none), "1 hairs");
  cache.destroy();

  const struct {
    pelage_asset* asset;
    const char* name;
    uint32_t bones, follows;
  } cases[] = {{fromFile, "", 1, 0}, {asset, "", 4, 0}, {cached, "beard", 2, 1}};
  Handle<pelage_scene> scene(pelage_scene_create);
  for (const auto& of : cases) {
    auto info = made(pelage_asset_info_init);
    expectOk(pelage_asset_get_info(of.asset, &info));
    EXPECT_EQ(info.strand_count, 2u);
    EXPECT_EQ(info.vertices_per_strand, 5u);
    EXPECT_EQ(info.bone_count, of.bones);
    EXPECT_STREQ(info.name, of.name);
    EXPECT_EQ(std::memcmp(info.positions, hair.positions.data(), 10 * sizeof(Float4)), 0);
    pelage_id id = 0;
    expectOk(pelage_scene_add_hair(scene, of.asset, nullptr, &id));
    EXPECT_EQ(infoOf(scene, id).bone_count, of.bones);
    EXPECT_EQ(infoOf(scene, id).follow_count, of.follows);
  }

  Handle<pelage_mesh> fromText(pelage_mesh_load_tfxmesh, "face.tfxmesh",
                               static_cast<const void*>(text->data()), text->size());
  expectOk(pelage_mesh_map_bones(fromText, names, 4, -1));
  for (pelage_mesh* of : {static_cast<pelage_mesh*>(face), static_cast<pelage_mesh*>(fromText)}) {
    pelage_id id = 0;
    expectOk(pelage_scene_add_collider(scene, of, nullptr, &id));
    const std::vector<pelage_transform> pose(2);
    // "ear" is bone 1 of the file, and bone 0 by its new name.
    expectOk(pelage_scene_set_bones(scene, id, pose.data(), of == face ? 2 : 1));
    expectOk(pelage_scene_reset(scene, id));
    expectOk(pelage_scene_remove(scene, id));
  }
}

}  // namespace
}  // namespace pelage::test
