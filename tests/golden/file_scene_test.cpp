// The scene of grooms and meshes from files: meshes collide, drawing changes nothing, an animation
// moves each bone.
#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <iostream>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "demo_scene.h"
#include "device.h"
#include "pelage/skeleton.h"
#include "support/errors.h"
#include "support/gpu_fixture.h"

namespace {

using pelage::Api;
using pelage::Float3;
using pelage::Float4;
using pelage::test::expectError;
using pelage::test::required;
using pelage::test::valueOf;
using sample::DemoDef;
using sample::DemoScene;
using sample::FileAssets;

constexpr uint32_t kFrames = 8;

/// A small head with its groom.
const sample::DemoAssets& head() {
  static const sample::DemoAssets assets = [] {
    pelage::GroomDef def;
    def.strandCount = 100;
    def.verticesPerStrand = 12;
    def.headCellSize = 0.007f;
    return valueOf(sample::generateAssets(def));
  }();
  return assets;
}

/// The same as from files.
FileAssets headFiles() {
  FileAssets files;
  files.assets.hairs.push_back({"groom", head().hair, head().weights, {}});
  files.assets.meshes.push_back({"head", *head().mesh});
  return files;
}

/// Soft hair, so that it falls onto what is there.
DemoDef softDef() {
  DemoDef def;
  def.followPerGuide = 1;
  auto settings =
      pelage::SettingsFile::parse(R"({"globalStiffness": 0, "bendLength": 0.02})", "soft.json");
  EXPECT_TRUE(settings);
  def.settings = *settings;
  return def;
}

class FileScene : public testing::TestWithParam<Api> {
 protected:
  /// One device and one scene for all tests of an API: software drivers take longer to compile the
  /// kernels than to run these.
  struct Stage {
    std::unique_ptr<pelage::HeadlessDevice> device;
    pelage::Scene scene;
    std::string why;  ///< there is no device
  };
  static void TearDownTestSuite() { stages_.clear(); }

  void SetUp() override {
    std::unique_ptr<Stage>& stage = stages_[GetParam()];
    if (!stage) {
      stage = std::make_unique<Stage>();
      auto made = sample::createDevice({.api = GetParam(), .maxTier = pelage::test::tierOfTests()});
      if (made)
        stage->device = *std::move(made);
      else
        stage->why = made.error().message;
    }
    if (!stage->device) GTEST_SKIP() << "skipped: " << stage->why;
  }

  static pelage::HeadlessDevice& device() { return *stages_.at(GetParam())->device; }

  static DemoDef def() {
    DemoDef result = softDef();
    result.scene = &stages_.at(GetParam())->scene;
    return result;
  }

  /// Advances, and draws in each frame if there is a view. Returns the last picture.
  static pelage::RenderedImage runAndDraw(DemoScene& demo) {
    pelage::RenderedImage last;
    run(demo, true, &last);
    return last;
  }
  static void run(DemoScene& demo, bool draws, pelage::RenderedImage* last = nullptr) {
    pelage::HeadlessDevice& on = device();
    demo.setTier(on.info().tier);
    const pelage::View view = sample::makeView(demo.camera(1), 64, 64, 1);
    for (uint32_t frame = 0; frame < kFrames; ++frame) {
      std::vector<pelage::PassList> lists(1);
      ASSERT_TRUE(demo.advance(lists[0]));
      if (draws) {
        pelage::TransparencySettings settings;
        settings.nodeCount = 1 << 18;
        required(demo.draw(view, settings, lists));
      }
      std::vector<const pelage::PassList*> pointers;
      for (pelage::PassList& list : lists) {
        demo.finish(list);
        pointers.push_back(&list);
      }
      ASSERT_TRUE(on.update(demo.resources()));
      if (draws) {
        auto image = required(on.render(pointers, {.width = 64, .height = 64}));
        if (last != nullptr) *last = *std::move(image);
      } else {
        ASSERT_TRUE(on.execute(lists[0]));
      }
    }
  }

  static std::vector<Float4> guides(const DemoScene& demo) {
    const pelage::HairObject& hair = demo.scene().hair(demo.hairs()[0]);
    const auto bytes = device().read(hair.buffers().positions, 0,
                                     uint64_t{hair.guideCount()} * hair.verticesPerStrand() * 16);
    EXPECT_TRUE(bytes);
    std::vector<Float4> positions(bytes ? bytes->size() / 16 : 0);
    if (bytes) std::memcpy(positions.data(), bytes->data(), bytes->size());
    return positions;
  }

 private:
  static inline std::map<Api, std::unique_ptr<Stage>> stages_;
};

TEST_P(FileScene, HasTheSameHairWhateverIsDrawn) {
  std::vector<std::vector<Float4>> results;
  for (const bool ofFiles : {true, false})
    for (const auto& [draws, drawSdf] : {std::pair(false, false), {true, false}, {true, true}}) {
      DemoDef from = def();
      from.drawSdf = drawSdf;
      from.headCollider = sample::HeadCollider::kMesh;
      auto demo = required(ofFiles ? DemoScene::create(headFiles(), from)
                                   : DemoScene::create(head(), from));
      run(*demo, draws);
      ASSERT_FALSE(HasFatalFailure());
      results.push_back(guides(*demo));
    }
  // It has moved, and by numbers.
  double moved = 0;
  for (size_t i = 0; i < results[0].size(); ++i) {
    const Float4 &a = results[0][i], &b = head().hair.positions[i];
    moved += std::hypot(double{a.x} - b.x, double{a.y} - b.y, double{a.z} - b.z);
  }
  EXPECT_GT(moved / static_cast<double>(results[0].size()), 1e-4);
  for (const size_t first : {0u, 3u})
    for (size_t i = first + 1; i < first + 3; ++i) {
      ASSERT_EQ(results[i].size(), results[first].size());
      EXPECT_EQ(std::memcmp(results[i].data(), results[first].data(), results[i].size() * 16), 0)
          << i;
    }
}

// The others look at what the sample sets up, on one API: golden pictures show that all draw the
// same.
//
// The light is black, so that its shadow takes nothing from it: what is darker under the hair is
// the ambient term of the mesh.
TEST_P(FileScene, HairTakesAmbientLightFromTheMeshUnderIt) {
  if (GetParam() != pelage::test::kFirstApi) GTEST_SKIP() << "skipped: not the first API";
  const auto drawnWith = [](pelage::HairShadow shadow) {
    auto demo = DemoScene::create(head(), def());
    EXPECT_TRUE(demo) << demo.error().message;
    demo->light.color = {0, 0, 0};
    demo->light.shadow = shadow;
    demo->light.shadowSize = 256;
    return runAndDraw(*demo);
  };
  const pelage::RenderedImage open = drawnWith(pelage::HairShadow::kNone),
                              shadowed = drawnWith(pelage::HairShadow::kDeep);
  ASSERT_FALSE(HasFailure());
  ASSERT_EQ(open.pixels.size(), shadowed.pixels.size());
  size_t darker = 0, brighter = 0;
  for (size_t i = 0; i < open.pixels.size(); ++i) {
    const float without = open.pixels[i].y, with = shadowed.pixels[i].y;
    ASSERT_TRUE(std::isfinite(with) && std::isfinite(without));
    darker += with < 0.95f * without ? 1 : 0;
    brighter += with > 1.01f * without + 1e-3f ? 1 : 0;
  }
  std::cout << darker << " pixels are darker\n";
  EXPECT_GT(darker, 10u);
  EXPECT_EQ(brighter, 0u);
}

TEST_P(FileScene, HairCollidesWithEachMesh) {
  if (GetParam() != pelage::test::kFirstApi) GTEST_SKIP() << "skipped: not the first API";
  FileAssets files = headFiles();
  // Another one, far away.
  pelage::CollisionMesh aside = *head().mesh;
  for (Float3& p : aside.positions) p.x += 3;
  files.assets.meshes.push_back({"aside", aside});
  {
    auto demo = required(DemoScene::create(files, def()));
    EXPECT_EQ(demo->colliders().size(), 2u);
    run(*demo, false);
    ASSERT_FALSE(HasFatalFailure());
    const auto figures = required(demo->contactFigures(demo->hairs()[0], device()));
    ASSERT_TRUE(*figures) << "no collider has been in reach";
    EXPECT_GT((*figures)->counters.records, 20u);
    EXPECT_LT((*figures)->deepest, 0.002f);
  }
  files.assets.meshes.clear();
  auto alone = required(DemoScene::create(files, def()));
  run(*alone, false);
  ASSERT_FALSE(HasFatalFailure());
  EXPECT_FALSE(*alone->contactFigures(alone->hairs()[0], device()));
}

TEST_P(FileScene, AnAnimationMovesEachBoneByItsName) {
  if (GetParam() != pelage::test::kFirstApi) GTEST_SKIP() << "skipped: not the first API";
  FileAssets files = headFiles();
  pelage::CachedHair& hair = files.assets.hairs[0];
  // The first half of the strands on a bone that stays, the others on one that rises.
  hair.bones->bones = {{0, "rising"}, {1, "still"}};
  const uint32_t half = hair.asset.strandCount / 2;
  for (uint32_t strand = 0; strand < hair.asset.strandCount; ++strand)
    hair.bones->strands[strand] = {{strand < half ? 1u : 0u, 0, 0, 0}, {1, 0, 0, 0}};
  files.assets.meshes.clear();
  sample::BoneMotion motion;
  motion.name = "lift.gltf";
  motion.seconds = 100;
  motion.bones = {"still", "other", "rising"};
  motion.pose = [](double seconds) {
    return std::vector<pelage::AffineTransform>{
        {},
        pelage::rigidTransform({}, {9, 9, 9}),
        pelage::rigidTransform({}, {0, 0.3f * static_cast<float>(seconds), 0})};
  };
  files.motion = motion;
  auto demo = required(DemoScene::create(files, def()));
  run(*demo, false);
  ASSERT_FALSE(HasFatalFailure());
  const std::vector<Float4> positions = guides(*demo);
  const float rise = 0.3f * kFrames / 60;
  for (uint32_t strand = 0; strand < hair.asset.strandCount; ++strand) {
    const size_t root = size_t{strand} * hair.asset.verticesPerStrand;
    ASSERT_NEAR(positions[root].y - hair.asset.positions[root].y, strand < half ? 0 : rise, 1e-5f)
        << strand;
    ASSERT_NEAR(positions[root].x, hair.asset.positions[root].x, 1e-5f) << strand;
  }
}

INSTANTIATE_TEST_SUITE_P(Apis, FileScene, testing::ValuesIn(pelage::test::kRuntimeApis),
                         pelage::test::apiTestName);

TEST(FileAssetsScene, RefusesAnAnimationThatLacksABone) {
  FileAssets files = headFiles();
  files.motion = sample::BoneMotion{
      "walk.gltf", {"hips"}, 1, [](double) { return std::vector<pelage::AffineTransform>(1); }};
  expectError(DemoScene::create(files, {}), "walk.gltf: there is no node for the bone '");
}

TEST(FileAssetsScene, RefusesAnAnimationOfHairWithoutBones) {
  FileAssets files = headFiles();
  files.assets.hairs[0].bones.reset();
  files.motion = sample::BoneMotion{"walk.gltf", {}, 1, {}};
  expectError(DemoScene::create(files, {}), "'groom' has no bones");
}

TEST(FileAssetsScene, KeepsColorsAndThicknessOfFilesAndIsBrownWithout) {
  FileAssets files = headFiles();
  pelage::HairAsset& asset = files.assets.hairs[0].asset;
  asset.vertexColor.clear();
  const auto materialOf = [](const FileAssets& from) {
    const auto demo = required(DemoScene::create(from, {}));
    return demo->scene().hair(demo->hairs()[0]).material;
  };
  const pelage::StrandMaterial plain = materialOf(files);
  EXPECT_EQ(plain.fiberRadius, 40e-6f);  // 80 um across; strandThickness is a factor on it
  for (const Float3& color : {plain.rootColor, plain.tipColor}) {
    EXPECT_TRUE(color.x > color.y && color.y > color.z) << "brown";
    EXPECT_LT(color.x, 2 * color.y) << "neither red nor orange";
  }
  // Colors of vertices are multiplied with the material's.
  asset.vertexColor.assign(asset.positions.size(), {0.1f, 0.5f, 0.2f, 1});
  const pelage::StrandMaterial colored = materialOf(files);
  for (const Float3& color : {colored.rootColor, colored.tipColor})
    EXPECT_TRUE(color.x == 1 && color.y == 1 && color.z == 1);
}

TEST(FileAssetsScene, ShowsMeshesAsAWhole) {
  FileAssets files = headFiles();
  pelage::CollisionMesh& mesh = files.assets.meshes[0].mesh;
  Float3& foot = mesh.positions[mesh.indices[0]];
  foot.y -= 1;
  const auto demo = required(DemoScene::create(files, {}));
  const pelage::View view = sample::makeView(demo->camera(1), 64, 64, 1);
  for (const Float3& p : mesh.positions) {
    const auto row = [&](int i) {
      const Float4& r = view.worldToClip.rows[i];
      return r.x * p.x + r.y * p.y + r.z * p.z + r.w;
    };
    ASSERT_TRUE(std::abs(row(0)) < row(3) && std::abs(row(1)) < row(3))
        << p.x << ' ' << p.y << ' ' << p.z;
  }
}

TEST(FileAssetsScene, RefusesFilesWithoutHairAndFieldsThatAreNotThere) {
  EXPECT_FALSE(DemoScene::create(FileAssets{}, {}));
  DemoDef def;
  def.drawSdf = true;
  FileAssets files = headFiles();
  files.assets.meshes.clear();
  EXPECT_FALSE(DemoScene::create(files, def));
  EXPECT_FALSE(DemoScene::create(head(), def));  // it collides with capsules
}

}  // namespace
