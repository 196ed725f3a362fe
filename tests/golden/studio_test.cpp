// The parts of the sample that need no GPU.
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <limits>
#include <sstream>
#include <utility>

#include "asset_files.h"
#include "camera.h"
#include "figures.h"
#include "groom_presets.h"
#include "head_motion.h"
#include "image.h"
#include "pelage/hair_asset.h"
#include "pelage/settings/settings_file.h"
#include "png_file.h"
#include "support/errors.h"
#include "support/extremes.h"

namespace {

using pelage::Float3;
using pelage::Float4;
using pelage::RenderedImage;
using pelage::test::expectHas;
using pelage::test::required;

RenderedImage filled(uint32_t width, uint32_t height, Float4 value) {
  RenderedImage image;
  image.width = width;
  image.height = height;
  image.pixels.assign(size_t{width} * height, value);
  return image;
}

std::filesystem::path temporary(const char* name) {
  return std::filesystem::path(testing::TempDir()) / name;
}

// Settings files say "long" for the straight preset.
TEST(GroomPresets, AreThePresetsOfSettings) {
  const std::pair<const char*, sample::GroomPreset> presets[] = {
      {"long", sample::GroomPreset::kStraight},
      {"curly", sample::GroomPreset::kCurly},
      {"fur", sample::GroomPreset::kFur},
      {"mohawk", sample::GroomPreset::kMohawk}};
  for (const auto& [name, preset] : presets) {
    const auto settings = required(pelage::presetSettings(name));
    const sample::PresetLook look = sample::presetLook(preset);
    pelage::SceneSettings expected = *settings;
    expected.material = look.material;
    expected.simulation.bendLength = look.bendLength;
    expected.simulation.globalStiffness = look.globalStiffness;
    expected.follow.countPerGuide = look.followPerGuide;
    expected.follow.maxRadius = look.followRadius;
    expected.follow.flyaways = look.flyaways;
    EXPECT_EQ(settingsText(*settings), settingsText(expected)) << name;
  }
}

TEST(HeadMotion, StartsAndEndsAtRestInTheBindPose) {
  for (const double time : {0.0, sample::kHeadMotionSeconds, 3 * sample::kHeadMotionSeconds}) {
    const sample::HeadPose pose = sample::headPose(time);
    EXPECT_NEAR(pose.yaw, 0, 1e-12);
    EXPECT_NEAR(pose.pitch, 0, 1e-12);
    EXPECT_NEAR(pose.roll, 0, 1e-12);
  }
}

TEST(HeadMotion, HasContinuousVelocityAndAcceleration) {
  // With h = 0.5 ms, a jump of the velocity would show as an acceleration of jump / h, and one of
  // the acceleration as a change between neighbours that does not shrink with h.
  const double h = 0.5e-3;
  double previous = 0, largestYaw = 0;
  for (double time = h; time < 2 * sample::kHeadMotionSeconds; time += h) {
    const auto yaw = [&](double t) { return sample::headPose(t).yaw; };
    const double acceleration = (yaw(time + h) - 2 * yaw(time) + yaw(time - h)) / (h * h);
    EXPECT_LT(std::abs(acceleration), 80) << time;
    EXPECT_LT(std::abs(acceleration - previous), 2.0) << time;
    previous = acceleration;
    pelage::test::keepLargest(largestYaw, std::abs(yaw(time)));
  }
  EXPECT_NEAR(largestYaw, 60 * M_PI / 180, 1e-3);
}

TEST(HeadMotion, TurnsAboutThePivotAndKeepsDistances) {
  const sample::HeadPose pose = {0.7, -0.3, 0.2};
  const Float3 pivot = {0.1f, 1.5f, -0.2f};
  const auto motion = sample::rotationAbout(sample::poseRotation(pose), pivot);
  const Float3 still = pelage::transformPoint(motion, pivot);
  EXPECT_NEAR(still.x, pivot.x, 1e-6);
  EXPECT_NEAR(still.y, pivot.y, 1e-6);
  EXPECT_NEAR(still.z, pivot.z, 1e-6);
  const Float3 moved = pelage::transformPoint(motion, {pivot.x + 0.3f, pivot.y + 0.4f, pivot.z});
  EXPECT_NEAR(std::hypot(moved.x - pivot.x, moved.y - pivot.y, moved.z - pivot.z), 0.5, 1e-6);
}

TEST(HeadMotion, AHeadOnANeckTurnsByTheWholePose) {
  pelage::Skeleton skeleton;
  skeleton.bones.push_back({"neck", -1, pelage::rigidTransform({}, {0, 0.05f, 0})});
  skeleton.bones.push_back({"head", 0, pelage::rigidTransform({}, {0, 0.12f, 0})});
  const auto bones = sample::poseSkeleton(skeleton, {0.8, 0, 0});
  ASSERT_EQ(bones.size(), 2u);
  // Both joints are on the axis of a yaw, so that the head simply turns by 0.8.
  const Float3 nose = pelage::transformPoint(bones[1], {0, 0.2f, 0.1f});
  EXPECT_NEAR(nose.x, 0.1 * std::sin(0.8), 1e-6);
  EXPECT_NEAR(nose.y, 0.2, 1e-6);
  EXPECT_NEAR(nose.z, 0.1 * std::cos(0.8), 1e-6);
}

TEST(Camera, SeesEveryPointAndTouchesTheMargin) {
  std::vector<Float3> points;
  for (int i = 0; i < 200; ++i) {
    const float a = 0.37f * static_cast<float>(i), r = 0.3f + 0.1f * std::sin(3.1f * a);
    points.push_back({r * std::cos(a), 1.5f + 0.2f * std::sin(1.7f * a), r * std::sin(a)});
  }
  for (const float aspect : {0.5f, 1.0f, 2.0f}) {
    sample::CameraDef def;
    def.margin = 0.1f;
    const sample::Camera camera = sample::frameAll(points, def, aspect);
    const pelage::View view = sample::makeView(camera, static_cast<uint32_t>(100 * aspect), 100, 1);
    float widest = 0;
    for (const Float3& p : points) {
      float clip[4];
      for (int row = 0; row < 4; ++row) {
        const Float4& r = view.worldToClip.rows[row];
        clip[row] = r.x * p.x + r.y * p.y + r.z * p.z + r.w;
      }
      ASSERT_GT(clip[3], 0);
      EXPECT_GE(clip[2], 0);
      EXPECT_LE(clip[2], clip[3]);
      pelage::test::keepLargest(widest, std::abs(clip[0] / clip[3]));
      pelage::test::keepLargest(widest, std::abs(clip[1] / clip[3]));
    }
    EXPECT_NEAR(widest, 0.8f, 2e-3f) << aspect;
  }
}

TEST(Camera, IsWhereItIsPutAndSeesAllPointsInDepth) {
  const std::vector<Float3> points = {{0, 1, 0}, {0.2f, 1.5f, 0.1f}, {-0.3f, 1.2f, -0.4f}};
  const sample::Camera seen =
      sample::placeCamera(points, {.eye = Float3{0, 1.2f, 3}, .verticalFov = 0.5f}, {}, 1);
  EXPECT_TRUE(seen.eye.z == 3 && seen.verticalFov == 0.5f);
  EXPECT_NEAR(seen.target.y, 1.25f, 1e-6);  // the middle of the points
  EXPECT_TRUE(seen.near > 0 && seen.near < 2.9f && seen.far > 3.4f);
  // Among the points, one is behind.
  const sample::Camera inside = sample::placeCamera(
      points, {.eye = Float3{0, 1.2f, -0.1f}, .target = Float3{0, 1.2f, 1}}, {}, 1);
  EXPECT_EQ(inside.target.z, 1);
  EXPECT_GT(inside.near, 0);
  EXPECT_GT(inside.far, inside.near);
  // Without an eye it frames the points.
  const sample::Camera framed = sample::placeCamera(points, {.verticalFov = 0.3f}, {}, 1);
  EXPECT_EQ(framed.eye, sample::frameAll(points, {.verticalFov = 0.3f}, 1).eye);
}

TEST(Camera, LooksStraightDown) {
  const sample::Camera camera =
      sample::placeCamera(std::vector<Float3>{{0, 1, 0}, {0.2f, 1.5f, 0.1f}},
                          {.eye = Float3{0, 4, 0}, .target = Float3{0, 0, 0}}, {}, 1);
  const pelage::View view = sample::makeView(camera, 16, 16, 1);
  const Float4& right = view.worldToClip.rows[0];
  const Float4& up = view.worldToClip.rows[1];
  EXPECT_TRUE(right.x > 1 && right.y == 0 && right.z == 0);
  EXPECT_TRUE(up.z < -1 && up.y == 0 && up.x == 0);
}

TEST(Image, AFlatBackdropHasItsBytesInThePicture) {
  for (const uint8_t value : std::to_array<uint8_t>({0, 1, 100, 200, 250, 255})) {
    pelage::RenderedImage image;
    image.width = image.height = 1;
    image.pixels.resize(1);
    sample::compositeOver(image, sample::flatBackdrop({value, 30, 255}));
    const sample::ByteImage bytes = sample::encodeSrgb(image);
    EXPECT_EQ(bytes.rgb, (std::vector<uint8_t>{value, 30, 255}));
  }
}

TEST(Image, TheToneCurveKeepsDarksRisesAndStaysUnderOne) {
  EXPECT_EQ(sample::toneMap(0.25f), 0.25f);
  EXPECT_EQ(sample::toneMap(-1), 0);
  EXPECT_EQ(sample::toneMap(std::numeric_limits<float>::quiet_NaN()), 0);
  EXPECT_LE(sample::toneMap(std::numeric_limits<float>::infinity()), 1);
  float previous = 0;
  for (float x = 0.01f; x < 3; x += 0.01f) {
    const float y = sample::toneMap(x);
    EXPECT_GT(y, previous);
    EXPECT_LT(y - previous, 0.0101f);
    previous = y;
  }
}

TEST(Image, EncodesMiddleGreyAsSrgb) {
  const sample::ByteImage image = sample::encodeSrgb(filled(1, 1, {0.2140411f, 0, 0.5f, 1}));
  EXPECT_EQ(image.rgb, (std::vector<uint8_t>{127, 0, 188}));
}

TEST(Image, AveragesInLinearLight) {
  RenderedImage image = filled(4, 2, {0, 0, 0, 0});
  for (const size_t lit : {0u, 5u, 2u, 3u, 6u, 7u}) image.pixels[lit] = {1, 0.5f, 0, 1};
  const RenderedImage small = sample::boxDownsample(image, 2);
  ASSERT_EQ(small.width, 2u);
  ASSERT_EQ(small.height, 1u);
  EXPECT_EQ(small.pixels[0], (Float4{0.5f, 0.25f, 0, 0.5f}));
  EXPECT_EQ(small.pixels[1], (Float4{1, 0.5f, 0, 1}));
}

TEST(Image, ShowsTheBackdropOnlyWhereNothingWasDrawn) {
  RenderedImage image = filled(2, 1, {0.25f, 0.25f, 0.25f, 1});
  image.pixels[1] = {0, 0, 0, 0};
  const sample::Backdrop grey = {{0.1f, 0.1f, 0.1f}, {0.1f, 0.1f, 0.1f}, 0};
  sample::compositeOver(image, grey);
  EXPECT_EQ(image.pixels[0], (Float4{0.25f, 0.25f, 0.25f, 1}));
  EXPECT_NEAR(image.pixels[1].x, 0.1f, 1e-6f);
  EXPECT_EQ(image.pixels[1].w, 1);
}

TEST(HairPixels, AreThoseThatHairChangesVisibly) {
  RenderedImage without = filled(10, 10, {0, 0, 0, 0});
  for (size_t i = 0; i < 50; ++i) without.pixels[i] = {0.3f, 0.2f, 0.1f, 1};  // a mesh
  EXPECT_EQ(sample::hairPixels(without, &without).count, 0u);
  RenderedImage image = without;
  image.pixels[3] = {0.1f, 0.1f, 0.1f, 1};          // hair before the mesh
  image.pixels[60] = {0.1f, 0.1f, 0.1f, 0.5f};      // and beside it
  image.pixels[61] = {0.01f, 0.01f, 0.01f, 0.03f};  // too thin to be seen
  const sample::HairPixels hair = sample::hairPixels(image, &without);
  EXPECT_EQ(hair.count, 2u);
  EXPECT_NEAR(hair.share, 0.02, 1e-9);
  EXPECT_NEAR(hair.meanLight, 0.2 / 1.5, 1e-6);
  EXPECT_EQ(hair.invalidCount, 0u);
  EXPECT_EQ(sample::hairPixels(image, nullptr).count, 51u);
}

TEST(HairPixels, DoNotTakeNumbersThatAreNoneForHair) {
  RenderedImage image = filled(4, 1, {0, 0, 0, 0});
  image.pixels[1].x = std::numeric_limits<float>::quiet_NaN();
  image.pixels[2].w = std::numeric_limits<float>::infinity();
  const sample::HairPixels hair = sample::hairPixels(image, nullptr);
  EXPECT_EQ(hair.count, 0u);
  EXPECT_EQ(hair.invalidCount, 2u);
}

TEST(Image, AContactSheetHoldsEveryPictureInOrder) {
  sample::ContactSheet sheet(5, 900, 600);
  for (int i = 0; i < 5; ++i) {
    const float grey = 0.1f * static_cast<float>(i + 1);
    sheet.add(filled(900, 600, {grey, grey, grey, 1}));
  }
  const sample::ByteImage& image = sheet.image();
  EXPECT_LE(image.width, 2100u);
  EXPECT_EQ(image.rgb.size(), size_t{image.width} * image.height * 3);
  // Read the first row of cells, then the first of the second row.
  std::vector<uint8_t> seen;
  for (uint32_t x = 0; x < image.width; ++x) {
    const uint8_t value = image.rgb[size_t{20} * image.width * 3 + x * 3];
    if (value > 40 && (seen.empty() || seen.back() != value)) seen.push_back(value);
  }
  EXPECT_GE(seen.size(), 2u);
  EXPECT_TRUE(std::is_sorted(seen.begin(), seen.end()));
}

TEST(PngFile, GivesBackWhatWasWritten) {
  sample::ByteImage image;
  image.width = 5;
  image.height = 3;
  for (int i = 0; i < 45; ++i) image.rgb.push_back(static_cast<uint8_t>(i * 5));
  const std::string path = temporary("round_trip.png").string();
  ASSERT_TRUE(sample::writePng(path, image).ok());
  EXPECT_FALSE(std::filesystem::exists(path + ".part"));
  const auto read = required(sample::readPng(path));
  EXPECT_EQ(read->width, 5u);
  EXPECT_EQ(read->rgb, image.rgb);
}

TEST(PngFile, NamesTheFileThatItCannotReadOrWrite) {
  const auto missing = sample::readPng(temporary("no_such.png").string());
  ASSERT_FALSE(missing.ok());
  expectHas(missing.error().message, "no_such.png");
  const auto written = sample::writePng(temporary("no_such_folder/a.png").string(), {});
  ASSERT_FALSE(written.ok());
  expectHas(written.error().message, "no_such_folder");
}

TEST(Figures, SumsPassesByNameAndLeavesOutWhatWasNotTimed) {
  pelage::PassList list;
  list.passes.resize(3);
  list.passes[0].name = "first";
  list.passes[0].bytes = 4'000'000;
  list.passes[1].name = "second";
  list.passes[2].name = "first";
  list.passes[2].bytes = 2'000'000;
  sample::Figures figures;
  figures.add(list, {{"first", 1.0}, {"second", -1.0}, {"first", 3.0}});
  ASSERT_EQ(figures.passes().size(), 2u);
  const sample::PassFigure& first = figures.passes()[0];
  EXPECT_EQ(first.passes, 2u);
  EXPECT_DOUBLE_EQ(first.totalMilliseconds(), 4);
  EXPECT_DOUBLE_EQ(first.medianMilliseconds(), 2);
  EXPECT_DOUBLE_EQ(first.minMilliseconds(), 1);
  EXPECT_DOUBLE_EQ(first.gigabytesPerSecond(), 1.5);
  EXPECT_TRUE(figures.passes()[1].milliseconds.empty());
  expectHas(figures.table(), "second");
}

TEST(Figures, AppendsRowsUnderOneHeader) {
  pelage::PassList list;
  list.passes.resize(1);
  list.passes[0].name = "first";
  sample::Figures figures;
  figures.add(list, {{"first", 2.0}});
  pelage::DeviceInfo device;
  device.name = "A \"GPU\", large";
  const std::string path = temporary("figures.csv").string();
  std::filesystem::remove(path);
  for (int i = 0; i < 2; ++i)
    ASSERT_TRUE(sample::appendCsv(path, figures, device, {"abc", "groom", 10, 20, 30, 1}).ok());
  std::ifstream file(path);
  std::stringstream text;
  text << file.rdbuf();
  std::string line;
  std::vector<std::string> lines;
  while (std::getline(text, line)) lines.push_back(line);
  ASSERT_EQ(lines.size(), 3u);
  EXPECT_EQ(lines[0].substr(0, 14), "commit,device,");
  EXPECT_EQ(lines[1], lines[2]);
  EXPECT_EQ(lines[1],
            "abc,\"A \"\"GPU\"\", large\",,vulkan,groom,10,20,30,30,1,first,1,2.000000,2.000000,"
            "2.000000,0,0.000");
}

class AssetFilesTest : public testing::Test {
 protected:
  /// Two strands of 25 and 35 units, on bone 0, with a follow hair, and a triangle.
  void SetUp() override {
    pelage::HairAsset hair;
    hair.strandCount = 2;
    hair.verticesPerStrand = 3;
    for (const float length : {25.0f, 35.0f})
      for (const float share : {0.0f, 0.1f, 1.0f})
        hair.positions.push_back({0, share * length, 0, share > 0.5f ? 1.0f : 0.0f});
    ASSERT_TRUE(pelage::saveTfx(hair, files_.hairs.emplace_back(temporary("long.tfx"))));
    pelage::BoneWeights weights;
    weights.bones = {{0, "head"}};
    weights.strands.assign(2, {{0, 0, 0, 0}, {1, 0, 0, 0}});
    ASSERT_TRUE(pelage::saveTfxBone(weights, files_.bones.emplace_back(temporary("long.tfxbone"))));
    pelage::FollowHair follow;
    follow.guide = 1;
    follow.offset = {0.5f, 0, -0.5f, 2};
    ASSERT_TRUE(pelage::saveFollowHairs(
        {&follow, 1}, 2, files_.followHairs.emplace_back(temporary("long.tfxfollow"))));
    pelage::CollisionMesh mesh;
    mesh.bones = {{0, "head"}};
    mesh.positions = {{0, 0, 0}, {10, 0, 0}, {0, 0, 10}};
    mesh.normals.assign(3, {0, 1, 0});
    mesh.influences.assign(3, {{0, 0, 0, 0}, {1, 0, 0, 0}});
    mesh.indices = {0, 2, 1};
    ASSERT_TRUE(pelage::saveTfxMesh(mesh, files_.meshes.emplace_back(temporary("ground.tfxmesh"))));
  }

  pelage::program::AssetFiles files_;
  std::vector<std::string> warnings_;
};

TEST_F(AssetFilesTest, WarnOfAGroomInCentimetersAndNameTheScale) {
  const auto assets = required(pelage::program::loadAssetFiles(files_, warnings_));
  EXPECT_TRUE(warnings_.empty());
  const auto units = pelage::program::unitWarnings(*assets, 1);
  ASSERT_EQ(units.size(), 1u);
  expectHas(units[0], "long: the strands have a mean length of 30 m");
  expectHas(units[0], "centimeters (a scale of 0.01 makes it 0.3 m)");
  expectHas(units[0], "--scale");
}

TEST_F(AssetFilesTest, ScaleHairFollowHairsAndMeshesAlike) {
  files_.scale = 0.01f;
  const auto assets = required(pelage::program::loadAssetFiles(files_, warnings_));
  EXPECT_TRUE(pelage::program::unitWarnings(*assets, 0.01f).empty());
  const pelage::CachedHair& hair = assets->hairs.at(0);
  EXPECT_EQ(hair.name, "long");
  EXPECT_NEAR(hair.asset.positions.back().y, 0.35f, 1e-6f);
  EXPECT_NEAR(hair.asset.restLengths[0], 0.025f, 1e-7f);
  EXPECT_NEAR(hair.followHairs.at(0).offset.z, -0.005f, 1e-8f);
  EXPECT_EQ(hair.followHairs[0].offset.w, 2);
  EXPECT_NEAR(assets->meshes.at(0).mesh.positions[1].x, 0.1f, 1e-7f);
  EXPECT_TRUE(hair.bones.has_value());
}

TEST_F(AssetFilesTest, TakeACacheWithAScaleOfItsOwn) {
  files_.process.tipThickness = 0.8f;
  const auto made = required(pelage::program::loadAssetFiles(files_, warnings_));
  pelage::program::AssetFiles cached;
  cached.cache = temporary("long.pelage");
  ASSERT_TRUE(pelage::saveAssetCache(*made, cached.cache));
  cached.scale = 0.01f;
  const auto assets = required(pelage::program::loadAssetFiles(cached, warnings_));
  ASSERT_EQ(assets->hairs.size(), 1u);
  EXPECT_NEAR(assets->hairs[0].asset.positions.back().y, 0.35f, 1e-6f);
  EXPECT_EQ(assets->hairs[0].asset.vertexThickness, made->hairs[0].asset.vertexThickness);
  EXPECT_EQ(assets->meshes.size(), 1u);
}

TEST_F(AssetFilesTest, RefuseScalesOutOfRangeAndFilesWithoutHair) {
  for (const float scale : {0.0f, -1.0f, std::numeric_limits<float>::quiet_NaN(), 1e30f}) {
    files_.scale = scale;
    EXPECT_FALSE(pelage::program::loadAssetFiles(files_, warnings_)) << scale;
  }
  files_.scale = 1e8f;
  EXPECT_FALSE(pelage::program::loadAssetFiles(files_, warnings_)) << "beyond the coordinates";
  files_.scale = 1;
  files_.bones.push_back("second.tfxbone");
  EXPECT_FALSE(pelage::program::loadAssetFiles(files_, warnings_));
}

}  // namespace
