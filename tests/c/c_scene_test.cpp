// A scene through the C interface has the bits of the same scene in C++: positions and pictures.
#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <string>
#include <utility>
#include <vector>

#include "c/c_objects.h"
#include "pelage/demo/groom.h"
#include "pelage/headless.h"
#include "pelage/scene.h"
#include "pelage/settings/settings_file.h"
#include "support/gpu_fixture.h"
#include "support/pictures.h"
#include "support/plain_asset.h"
#include "support/test_folder.h"
#include "support/views.h"

namespace pelage::test {
namespace {

// A device of each interface.
class CScene : public testing::TestWithParam<Api> {
 protected:
  void SetUp() override {
    auto made = createDeviceOfPelage({.api = GetParam()});
    if (!made) PELAGE_SKIP_WITHOUT_DEVICE() << made.error().message;
    device_ = *std::move(made);
    auto def = test::made(pelage_headless_def_init);
    def.api = static_cast<uint32_t>(GetParam());
    expectOk(pelage_headless_create(&def, &cDevice_));
  }
  void TearDown() override { expectOk(pelage_destroy(cDevice_)); }

  static std::vector<Float4> positions(pelage_headless* device, pelage_scene* scene,
                                       pelage_id hair) {
    const pelage_hair_info info = infoOf(scene, hair);
    std::vector<Float4> all(size_t{info.guide_count} * info.vertices_per_strand);
    expectOk(pelage_read(device, info.positions, 0, all.data(), all.size() * sizeof(Float4)));
    return all;
  }
  std::vector<Float4> positions(const Scene& scene, HairId hair) const {
    const HairObject& object = scene.hair(hair);
    const auto bytes = required(device_->read(object.buffers().positions));
    std::vector<Float4> all(size_t{object.guideCount()} * object.verticesPerStrand());
    EXPECT_LE(all.size() * sizeof(Float4), bytes->size());
    std::memcpy(all.data(), bytes->data(), all.size() * sizeof(Float4));
    return all;
  }
  /// \param view  nullptr: none
  static std::vector<Float4> run(pelage_headless* device, pelage_scene* scene, float dt,
                                 const View* view, pelage_settings* settings) {
    Handle<pelage_frame> frame(pelage_scene_simulate, scene, dt);
    if (view == nullptr) {
      expectOk(pelage_headless_run(device, frame, nullptr, 0));
      return {};
    }
    auto cView = test::made(pelage_view_init);
    std::memcpy(cView.world_to_clip, &view->worldToClip, sizeof(cView.world_to_clip));
    std::memcpy(cView.eye, &view->eye, sizeof(cView.eye));
    cView.width = view->width;
    cView.height = view->height;
    uint32_t number = 7;
    expectOk(pelage_frame_draw(frame, &cView, settings, &number));
    EXPECT_EQ(number, 0u);
    std::vector<Float4> pixels(size_t{view->width} * view->height);
    auto target = test::made(pelage_headless_target_init);
    target.width = view->width;
    target.height = view->height;
    target.pixels = &pixels.data()->x;
    expectOk(pelage_headless_run(device, frame, &target, 1));
    return pixels;
  }
  std::vector<Float4> run(Scene& scene, float dt, const View* view,
                          const SceneSettings& settings) const {
    Result<Frame> frame = required(scene.simulate(dt));
    if (view == nullptr) {
      required(device_->run(*frame));
      return {};
    }
    EXPECT_TRUE(frame->draw(*view, settings.lights, settings.transparency));
    const RenderTargetDef target = {.width = view->width, .height = view->height};
    return required(device_->render(*frame, {&target, 1}))->front().pixels;
  }

  std::unique_ptr<HeadlessDevice> device_;
  pelage_headless* cDevice_ = nullptr;
};
INSTANTIATE_TEST_SUITE_P(All, CScene, testing::Values(Api::kVulkan, Api::kGl), apiTestName);

// A transform of bone 0 of a frame, in both interfaces.
AffineTransform poseOf(int frame) {
  const float angle = 0.3f * std::sin(0.4f * static_cast<float>(frame));
  return rigidTransform({0, std::sin(angle / 2), 0, std::cos(angle / 2)}, {0, 0.01f, 0});
}
pelage_transform toC(const AffineTransform& transform) {
  pelage_transform c;
  std::memcpy(&c, &transform, sizeof(c));
  return c;
}

// Settings of all kinds, follow hairs, a skeleton, capsules, and a mesh on the skeleton.
TEST_P(CScene, HasTheBitsOfCpp) {
  const char* const text = R"({
      "simulation": {"bendLength": 0.03, "wind": {"velocity": [1, 0, 0.5]}, "damping": 0.1},
      "material": {"fiberRadius": 0.001, "rootColor": [0.5, 0.2, 0.1], "model": "fiber"},
      "object": {"drawnShare": 0.8}, "follow": {"countPerGuide": 2, "maxRadius": 0.01},
      "collider": {"margin": 0.002}, "transparency": {"method": "hybrid8"},
      "lights": [{"shadow": "deep", "shadowSize": 64}, {"color": [0.1, 0.1, 0.3]}]})";
  const SceneSettings settings = *required(parseSettings(text, "text"));
  const HairAsset asset = makeAsset(5, 8);
  CollisionMesh mesh;
  mesh.positions = {{-0.1f, 0.02f, -0.1f}, {0.15f, 0.02f, -0.1f}, {0, 0.02f, 0.15f}, {0, -0.1f, 0}};
  mesh.normals.resize(4);
  mesh.indices = {0, 2, 1, 0, 1, 3, 1, 2, 3, 2, 0, 3};
  const CapsuleCollider capsule = {.head = {0.02f, 0.06f, 0.01f},
                                   .headRadius = 0.01f,
                                   .tail = {0.03f, 0.06f, 0.01f},
                                   .tailRadius = 0.02f};
  const View view =
      cameraView({.eye = {0.2f, 0.1f, 0.4f}, .target = {0.02f, 0.04f, 0}, .width = 48});

  Scene scene;
  const SkeletonId skeleton = *required(scene.addSkeleton({.name = "walker"}));
  const ColliderId collider =
      *required(scene.addCollider(mesh, {.name = "body", .cellSize = 0.01f, .skeleton = skeleton}));
  apply(settings.collider, scene.collider(collider));
  const auto follows = required(asset.generateFollowHairs(settings.follow));
  HairDef def = {.name = "hair", .settings = settings.simulation, .material = settings.material};
  def.skeleton = skeleton;
  def.followHairs = *follows;
  const HairId hair = *required(scene.addHair(asset, def));
  apply(settings.object, scene.hair(hair));

  Handle<pelage_settings> cSettings(pelage_settings_create);
  expectOk(pelage_settings_load(cSettings, "text", text));
  auto cAssetDef = made(pelage_asset_def_init);
  cAssetDef.strand_count = asset.strandCount;
  cAssetDef.vertices_per_strand = asset.verticesPerStrand;
  cAssetDef.positions = &asset.positions.data()->x;
  Handle<pelage_asset> cAsset(pelage_asset_create, &cAssetDef);
  Handle<pelage_mesh> cMesh(pelage_mesh_create, &mesh.positions.data()->x, nullptr, 4u,
                            mesh.indices.data(), 12u);
  Handle<pelage_scene> cScene(pelage_scene_create);
  expectOk(pelage_scene_set_tier_of(cScene, cDevice_));
  pelage_id cSkeleton = 0, cCollider = 0, cHair = 0;
  expectOk(pelage_scene_add_skeleton(cScene, "walker", 1, &cSkeleton));
  auto cColliderDef = made(pelage_collider_def_init);
  cColliderDef.cell_size = 0.01f;
  cColliderDef.skeleton = cSkeleton;
  cColliderDef.settings = cSettings;
  expectOk(pelage_scene_add_collider(cScene, cMesh, &cColliderDef, &cCollider));
  auto cDef = made(pelage_hair_def_init);
  cDef.settings = cSettings;
  cDef.skeleton = cSkeleton;
  expectOk(pelage_scene_add_hair(cScene, cAsset, &cDef, &cHair));
  EXPECT_EQ(infoOf(cScene, cHair).follow_count, 10u);

  pelage_capsule cCapsule;
  std::memcpy(&cCapsule, &capsule, sizeof(cCapsule));
  for (int frame = 0; frame < 12; ++frame) {
    const AffineTransform pose = poseOf(frame);
    const pelage_transform cPose = toC(pose);
    scene.skeleton(skeleton).setBones({&pose, 1});
    expectOk(pelage_scene_set_bones(cScene, cSkeleton, &cPose, 1));
    if (frame == 4) {
      scene.hair(hair).setColliders({&capsule, 1});
      expectOk(pelage_scene_set_capsules(cScene, cHair, &cCapsule, 1));
    }
    if (frame == 6) {
      scene.hair(hair).setMeshColliders({});
      expectOk(pelage_scene_set_mesh_colliders(cScene, cHair, &cCollider, 0));
      required(scene.shiftOrigin({1, 0, 0}));
      const float shift[3] = {1, 0, 0};
      expectOk(pelage_scene_shift_origin(cScene, shift));
    }
    if (frame == 8) {
      const double soft = 0.01;
      expectOk(pelage_settings_set(cSettings, "simulation.bendLength", &soft, 1));
      expectOk(pelage_scene_set_settings(cScene, cHair, cSettings));
      scene.hair(hair).settings.bendLength = 0.01f;
      scene.hair(hair).useAllMeshColliders();
      expectOk(pelage_scene_set_mesh_colliders(cScene, cHair, nullptr, 0));
    }
    const View* seen = frame == 5 ? &view : nullptr;
    const std::vector<Float4> picture = run(scene, kDt, seen, settings);
    const std::vector<Float4> cPicture = run(cDevice_, cScene, kDt, seen, cSettings);
    if (seen != nullptr) {
      EXPECT_GT(coverage(picture), 10);
      EXPECT_TRUE(sameBits(picture, cPicture));
    }
    ASSERT_TRUE(sameBits(positions(scene, hair), positions(cDevice_, cScene, cHair))) << frame;
  }
}

// Forces of the application in a buffer; then a snapshot, and a device that takes over.
TEST_P(CScene, GoesOnFromASnapshotOnAnotherDevice) {
  const HairAsset asset = makeAsset(3, 6);
  auto def = made(pelage_asset_def_init);
  def.strand_count = 3;
  def.vertices_per_strand = 6;
  def.positions = &asset.positions.data()->x;
  Handle<pelage_asset> cAsset(pelage_asset_create, &def);
  auto headless = made(pelage_headless_def_init);
  headless.api = static_cast<uint32_t>(GetParam());
  const std::vector<Float4> forces(18, Float4{3, 0, 0, 0});
  const pelage_reader read = [](void* user, pelage_buffer_id of, void* bytes, uint64_t size) {
    return pelage_read(user, of, 0, bytes, size);
  };
  const pelage_reader fail = [](void*, pelage_buffer_id, void*, uint64_t) {
    return PELAGE_ERROR_DEVICE_LOST;
  };

  std::vector<Float4> results[2];
  for (const bool moves : {false, true}) {
    Handle<pelage_scene> scene(pelage_scene_create);
    Handle<pelage_headless> first(pelage_headless_create, &headless);
    pelage_id hair = 0;
    pelage_buffer_id buffer = 0;
    expectOk(pelage_scene_add_hair(scene, cAsset, nullptr, &hair));
    expectOk(pelage_scene_add_buffer(scene, "forces", 18 * sizeof(Float4), forces.data(), &buffer));
    expectOk(pelage_scene_set_forces(scene, hair, buffer));
    pelage_headless* device = first;
    for (int frame = 0; frame < 10; ++frame) {
      if (moves && frame == 5) {
        void* user = device;
        pelage_scene* const of = scene;
        pelage_snapshot* none = nullptr;
        expectError(pelage_scene_take_snapshot(scene, fail, nullptr, &none),
                    PELAGE_ERROR_DEVICE_LOST, {"reader"});
        Handle<pelage_snapshot> snapshot(pelage_scene_take_snapshot, of, read, user);
        first.destroy();
        uint32_t kept = 0;
        expectOk(pelage_scene_recover(scene, snapshot, &kept));
        EXPECT_EQ(kept, 1u);
        device = cDevice_;
      }
      run(device, scene, kDt, nullptr, nullptr);
    }
    results[moves ? 1 : 0] = positions(device, scene, hair);
  }
  EXPECT_GT(results[0][5].x, asset.positions[5].x + 0.001f) << "forces have an effect";
  EXPECT_TRUE(sameBits(results[0], results[1]));
}

#ifdef PELAGE_HELLO_C
// The picture of a program, the bottom row first: RGB.
std::vector<float> readPfm(const std::filesystem::path& path, uint32_t size) {
  const std::string text = textOf(path), head = "PF\n256 256\n-1\n";
  std::vector<float> all(size_t{3} * size * size);
  EXPECT_EQ(text.substr(0, head.size()), head);
  EXPECT_EQ(text.size(), head.size() + all.size() * sizeof(float));
  if (text.size() == head.size() + all.size() * sizeof(float))
    std::memcpy(all.data(), text.data() + head.size(), all.size() * sizeof(float));
  return all;
}

// sample/hello_c and sample/hello: the same tip, and the picture that C++ draws.
TEST(CHello, HasTheBitsOfCpp) {
  const auto device = createDeviceOfPelage({});
  if (!device) PELAGE_SKIP_WITHOUT_DEVICE() << device.error().message;
  const TestFolder folder;
  const ProgramOutput c = runIn(folder.path(), PELAGE_HELLO_C " hello.pfm");
  const ProgramOutput cpp = runIn(folder.path(), PELAGE_HELLO);
  ASSERT_EQ(c.code, 0) << c.errors;
  ASSERT_EQ(cpp.code, 0) << cpp.errors;
  const std::string tip = "tip of strand 0: ";
  ASSERT_EQ(c.out.substr(0, tip.size()), tip);
  EXPECT_NE(cpp.out.find(" to " + c.out.substr(tip.size())), std::string::npos) << c.out << cpp.out;

  Result<Groom> groom = required(generateGroom({.seed = 7, .strandCount = 500}));
  expectOk(groom->hair.process());
  Scene scene;
  const HairId hair = *required(scene.addHair(groom->hair, {.name = "hello"}));
  const View view = cameraView({.eye = {0, 0.3f, 0.9f},
                                .target = {0, 0.2f, 0},
                                .fov = 0.6f,
                                .width = 256,
                                .nearPlane = 0.1f,
                                .farPlane = 10});
  const RenderTargetDef target = {.width = 256, .height = 256};
  std::vector<float> expected;
  for (int i = 0; i < 60; ++i) {
    Result<Frame> frame = required(scene.simulate(kDt));
    if (i < 59) {
      expectOk((*device)->run(*frame));
      continue;
    }
    const Light light;
    ASSERT_TRUE(frame->draw(view, {&light, 1}));
    const auto images = required((*device)->render(*frame, {&target, 1}));
    EXPECT_GT(coverage(images->front()), 1000);
    for (size_t y = 256; y-- > 0;)
      for (size_t x = 0; x < 256; ++x) {
        const Float4& pixel = images->front().pixels[y * 256 + x];
        expected.insert(expected.end(), {pixel.x, pixel.y, pixel.z});
      }
  }
  EXPECT_EQ(readPfm(folder / "hello.pfm", 256), expected);

  // And all positions.
  Handle<pelage_asset> asset(pelage_asset_generate, uint64_t{7}, 500u);
  Handle<pelage_scene> cScene(pelage_scene_create);
  Handle<pelage_headless> cDevice(pelage_headless_create, nullptr);
  pelage_id cHair = 0;
  expectOk(pelage_scene_add_hair(cScene, asset, nullptr, &cHair));
  for (int i = 0; i < 60; ++i) {
    Handle<pelage_frame> frame(pelage_scene_simulate, static_cast<pelage_scene*>(cScene), kDt);
    expectOk(pelage_headless_run(cDevice, frame, nullptr, 0));
  }
  const auto bytes = required((*device)->read(scene.hair(hair).buffers().positions));
  std::vector<std::byte> cBytes(bytes->size());
  expectOk(pelage_read(cDevice, infoOf(cScene, cHair).positions, 0, cBytes.data(), cBytes.size()));
  EXPECT_EQ(*bytes, cBytes);
}
#endif

}  // namespace
}  // namespace pelage::test
