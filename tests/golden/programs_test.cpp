// Each sample runs on each API, and its picture is judged: it is not empty, not black, has no one
// color, and hair covers a share of it that can be.
#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <regex>
#include <set>
#include <string>
#include <vector>

#include "asset_files.h"
#include "device.h"
#include "pelage/asset_cache.h"
#include "pelage/hair_asset.h"
#include "png_file.h"
#include "support/errors.h"
#include "support/gpu_fixture.h"
#include "support/picture_statistics.h"
#include "support/test_folder.h"

namespace {

using pelage::Api;
using pelage::test::expectHas;
using pelage::test::ProgramOutput;
using pelage::test::required;
using pelage::test::runIn;
using pelage::test::TestFolder;

/// Host code runs on the first API; Programs below, on every one, draws the same pictures there.
class ProgramsOnce : public testing::Test {
 protected:
  explicit ProgramsOnce(Api api = pelage::test::kFirstApi) : api_(api) {}
  void SetUp() override {
    if (auto device = sample::createDevice({.api = api_}); !device)
      GTEST_SKIP() << "skipped: " << device.error().message;
  }

  std::string api() const { return pelage::apiName(api_); }
  std::filesystem::path file(const std::string& name) const { return folder_ / name; }

  ProgramOutput run(const std::string& program, const std::string& arguments) const {
    return runIn(folder_.path(), "'" + program + "' " + arguments);
  }

  /// Small pictures of a few frames.
  ProgramOutput headless(const std::string& arguments) const {
    return run(PELAGE_HEADLESS, "--api " + api() +
                                    " --width 96 --height 96 --supersample 1 --frames 6 --every 3 "
                                    "--out out " +
                                    arguments);
  }

  void expectPicture(const std::string& name, double leastShare, double mostShare) const {
    const auto image = required(sample::readPng(file(name).string()));
    const auto s = pelage::test::statisticsOf(*image);
    EXPECT_GE(s.drawnShare, leastShare) << name;
    EXPECT_LE(s.drawnShare, mostShare) << name;
    EXPECT_GE(s.mean, 8) << name << " is black";
    EXPECT_LE(s.mean, 247) << name << " is white";
    EXPECT_GE(s.colors, 50u) << name;
  }

  /// The share of hair that the program states for its first and its last picture.
  static std::vector<double> hairShares(const ProgramOutput& output) {
    std::vector<double> shares;
    const std::regex line(R"(hair: +([0-9.]+) % of the pixels of frame [0-9]+)");
    for (std::sregex_iterator it(output.out.begin(), output.out.end(), line), end; it != end; ++it)
      shares.push_back(std::stod((*it)[1]) / 100);
    return shares;
  }

  static void expectHair(const ProgramOutput& output, double least, double most) {
    ASSERT_EQ(output.code, 0) << output.errors;
    EXPECT_EQ(output.errors, "");
    const std::vector<double> shares = hairShares(output);
    ASSERT_EQ(shares.size(), 2u) << output.out;
    for (const double share : shares) {
      EXPECT_GE(share, least);
      EXPECT_LE(share, most);
    }
  }

  /// The grooms, the colliders and the animations of a small character: "assets".
  void writeCharacter() const {
    const ProgramOutput output =
        run(PELAGE_HEADLESS, "--api " + api() +
                                 " --guides 60 --follow 0 --motion bind --frames 1 --no-images "
                                 "--write-asset assets --quiet");
    ASSERT_EQ(output.code, 0) << output.errors;
  }

  /// A groom of 24 hanging strands in centimeters, on a circle: "cm.tfx".
  void writeCentimeters() const {
    pelage::HairAsset hair;
    hair.strandCount = 24;
    hair.verticesPerStrand = 8;
    for (uint32_t s = 0; s < hair.strandCount; ++s)
      for (uint32_t v = 0; v < hair.verticesPerStrand; ++v) {
        const float angle = 0.26f * static_cast<float>(s);
        hair.positions.push_back({2 * std::cos(angle), -4.0f * static_cast<float>(v),
                                  2 * std::sin(angle), v < 2 ? 0.0f : 1.0f});
      }
    ASSERT_TRUE(pelage::saveTfx(hair, file("cm.tfx")));
  }

  const Api api_;
  const TestFolder folder_;
};

class Programs : public ProgramsOnce, public testing::WithParamInterface<Api> {
 protected:
  Programs() : ProgramsOnce(GetParam()) {}
};

TEST_P(Programs, HeadlessDrawsTheCharacter) {
  const ProgramOutput output = headless("--guides 80 --follow 3 --motion shake");
  expectHair(output, 0.02, 0.6);
  for (const char* picture : {"out/frame_0003.png", "out/frame_0006.png"})
    expectPicture(picture, 0.15, 0.95);
  EXPECT_TRUE(std::filesystem::exists(file("out/contact_sheet.png")));
}

TEST_P(Programs, HeadlessDrawsAHeadAndItsField) {
  const ProgramOutput output =
      headless("--scene head --guides 100 --colliders sdf --draw-sdf --draw-contacts --follow 3");
  expectHair(output, 0.02, 0.7);
  expectPicture("out/frame_0006.png", 0.1, 0.95);
}

TEST_F(ProgramsOnce, HeadlessDrawsFewerFibersWhereTheyAreThinButTheSamePicture) {
  const auto pictureWith = [&](const std::string& arguments) {
    const ProgramOutput output = headless("--scene head --guides 400 --follow 12 " + arguments);
    EXPECT_EQ(output.code, 0) << output.errors;
    return required(sample::readPng(file("out/frame_0006.png").string()));
  };
  const auto all = pictureWith("--detail 0"), fewer = pictureWith("");
  EXPECT_NE(all->rgb, fewer->rgb);
  EXPECT_GT(sample::psnrOf(*all, *fewer), 38);
}

TEST_F(ProgramsOnce, HeadlessDrawsAHeadByEachSolver) {
  for (const char* solver : {"exact", "classic"}) {
    expectHair(headless(std::string("--scene head --guides 100 --follow 3 --solver ") + solver),
               0.02, 0.7);
    expectPicture("out/frame_0006.png", 0.1, 0.95);
  }
}

TEST_F(ProgramsOnce, HeadlessShowsFilesWithSeveralMeshesAnAnimationAndSettings) {
  writeCharacter();
  std::ofstream(file("soft.json")) << R"({
      "simulation": {"bendLength": 0.03, "wind": {"velocity": [1, 0, 0]}},
      "material": {"model": "fiber"}, "object": {"drawnShare": 0.9},
      "collider": {"margin": 0.002}, "follow": {"maxRadius": 0.003},
      "lights": [{"shadow": "depth"}, {"color": [0.2, 0.2, 0.3], "shadow": "deep"}],
      "transparency": {"method": "hybrid8"}})";
  const ProgramOutput output = headless(
      "--asset assets/long.tfx --bones assets/long.tfxbone --asset assets/mohawk.tfx "
      "--bones assets/mohawk.tfxbone --mesh assets/body.tfxmesh --mesh assets/leftArm.tfxmesh "
#ifdef PELAGE_ANIMATIONS
      "--animation assets/character.gltf --clip headShake "
#endif
      "--settings soft.json --follow 3");
  expectHair(output, 0.002, 0.7);
  expectHas(output.out, "contacts: long");
  expectPicture("out/frame_0006.png", 0.05, 0.95);
}

TEST_F(ProgramsOnce, HeadlessShowsFollowHairsOfAFileCachesAndFields) {
  writeCharacter();
  std::vector<std::string> warnings;
  auto assets = required(pelage::program::loadAssetFiles(
      {.hairs = {file("assets/long.tfx")}, .bones = {file("assets/long.tfxbone")}}, warnings));
  pelage::CachedHair& hair = assets->hairs[0];
  const auto follow =
      required(hair.asset.generateFollowHairs({.countPerGuide = 4, .maxRadius = 0.005f}));
  ASSERT_TRUE(pelage::saveFollowHairs(*follow, hair.asset.strandCount, file("long.tfxfollow")));
  hair.followHairs = *follow;
  ASSERT_TRUE(pelage::saveAssetCache(*assets, file("long.pelage")));
  const std::string mesh = " --mesh assets/body.tfxmesh";
  const std::string count = std::to_string(follow->size()) + " follow hairs";
  for (const std::string& arguments :
       {"--asset assets/long.tfx --bones assets/long.tfxbone --follow-file long.tfxfollow" + mesh,
        "--pelage long.pelage --draw-sdf" + mesh}) {
    const ProgramOutput output = headless(arguments);
    expectHair(output, 0.003, 0.7);  // few fibers of 80 um, with the body in the picture
    expectHas(output.out, count);
  }
  const ProgramOutput one = headless("--pelage long.pelage --follow 1 --no-images");
  EXPECT_EQ(one.code, 0) << one.errors;
  expectHas(one.out, ", " + std::to_string(hair.asset.strandCount) + " follow hairs");
}

TEST_F(ProgramsOnce, HeadlessWarnsOfHairInCentimetersAndTakesAScale) {
  writeCentimeters();
  const ProgramOutput wrong = headless("--asset cm.tfx");
  EXPECT_EQ(wrong.code, 0) << wrong.errors;
  expectHas(wrong.errors,
            "pelage-headless: warning: cm: the strands have a mean length of 28 "
            "m; hair is shorter than that. Is it in centimeters (a scale of "
            "0.01 makes it 0.28 m)");
  expectHas(wrong.errors, "--scale");
  const ProgramOutput right = headless("--asset cm.tfx --scale 0.01");
  expectHair(right, 0.01, 0.7);
  expectPicture("out/frame_0006.png", 0.01, 0.7);
}

TEST_F(ProgramsOnce, HeadlessSaysWhereAPictureShowsNoHair) {
  writeCentimeters();
  // Hair of kilometers is less than a hundredth of a percent of a pixel wide.
  const ProgramOutput output = headless("--asset cm.tfx --scale 1000 --quiet");
  EXPECT_EQ(output.code, 0) << output.errors;
  expectHas(output.errors, "warning: no hair can be seen in frames 3, 6: ");
  const ProgramOutput none =
      run(PELAGE_HEADLESS, "--api " + api() + " --asset cm.tfx --scale 0.01 --quiet --frames 2");
  EXPECT_EQ(none.code, 0) << none.errors;
  expectHas(none.errors, "warning: there is no picture");
}

TEST_F(ProgramsOnce, EngineShaderDrawsAHead) {
  const ProgramOutput output = run(PELAGE_ENGINE_SHADER, "head.png " + api());
  EXPECT_EQ(output.code, 0) << output.errors;
  EXPECT_EQ(output.errors, "");
  expectPicture("head.png", 0.1, 0.95);
}

TEST_F(ProgramsOnce, SamplesSayHowTheyAreUsed) {
  std::vector<std::string> programs = {PELAGE_ENGINE_SHADER, PELAGE_ENGINE_LIGHTS};
#ifdef PELAGE_HELLO
  programs.emplace_back(PELAGE_HELLO);
#endif
  for (const std::string& program : programs) {
    const ProgramOutput output = run(program, "--help");
    EXPECT_EQ(output.code, 0) << program;
    EXPECT_EQ(output.errors, "");
    expectHas(output.out, "usage: pelage-");
    EXPECT_FALSE(std::filesystem::exists(file("--help"))) << program;
  }
  EXPECT_EQ(run(PELAGE_ENGINE_SHADER, "--size").code, 1);
}

TEST_F(ProgramsOnce, EngineLightsDrawsTheCharacterInItsLights) {
  const ProgramOutput output = run(PELAGE_ENGINE_LIGHTS, "character.png " + api());
  EXPECT_EQ(output.code, 0) << output.errors;
  EXPECT_EQ(output.errors, "");
  expectPicture("character.png", 0.15, 0.95);
}

TEST_F(ProgramsOnce, ParametersRendersAStrip) {
  const ProgramOutput output =
      run(PELAGE_PARAMETERS, "--pictures strips --only StrandMaterial.fiberRadius --api " + api());
  EXPECT_EQ(output.code, 0) << output.errors;
  EXPECT_EQ(output.errors, "");
  std::vector<std::filesystem::path> strips;
  for (const auto& entry : std::filesystem::directory_iterator(file("strips")))
    strips.push_back(entry.path());
  ASSERT_EQ(strips.size(), 1u);
  const auto strip = required(sample::readPng(strips[0].string()));
  // On paper of one color, hair and head are darker.
  const uint32_t paper = strip->rgb[0];
  EXPECT_GT(paper, 128u);
  size_t dark = 0;
  std::set<uint8_t> levels;
  for (size_t i = 0; i < strip->rgb.size(); i += 3) {
    dark += strip->rgb[i] + 40u < paper ? 1u : 0u;
    levels.insert(strip->rgb[i]);
  }
  const double share = static_cast<double>(dark) / (strip->width * strip->height);
  EXPECT_GT(share, 0.02);
  EXPECT_LT(share, 0.8);
  EXPECT_GT(levels.size(), 20u);
}

#ifdef PELAGE_ANIMATIONS
// Hair of modeling programs is taken as it is, in one run with a .tfx.
TEST_F(ProgramsOnce, HeadlessTakesHairOfModelingPrograms) {
  writeCentimeters();
  std::string curves = "hairtxt 1 x y z\n";
  for (int strand = 0; strand < 12; ++strand)
    for (int v = 0; v < 5; ++v)
      curves += std::to_string(strand % 4) + " " + std::to_string(-6 * v) + " " +
                std::to_string(strand / 4) + (v == 4 ? "\n\n" : "\n");
  (void)folder_.write("curves.hairtxt", curves);
  const ProgramOutput output = headless("--scale 0.01 --asset curves.hairtxt --asset cm.tfx");
  ASSERT_EQ(output.code, 0) << output.errors;
  EXPECT_EQ(output.errors, "");
  expectHas(output.out, "curves, 12 guides");
  expectHas(output.out, "cm, 24 guides");
  const ProgramOutput bones = headless("--asset curves.hairtxt --bones cm.tfxbone");
  EXPECT_EQ(bones.code, 1);
  expectHas(bones.errors, "curves.hairtxt: --bones and --follow-file are for .tfx");
}
#endif

#ifdef PELAGE_HELLO  // Vulkan
TEST_F(ProgramsOnce, HelloSaysWhereATipWent) {
  const ProgramOutput output = run(PELAGE_HELLO, "");
  ASSERT_EQ(output.code, 0) << output.errors;
  float from[3], to[3];
  ASSERT_EQ(std::sscanf(output.out.c_str(), "tip of strand 0: from (%f, %f, %f) to (%f, %f, %f) m",
                        &from[0], &from[1], &from[2], &to[0], &to[1], &to[2]),
            6)
      << output.out;
  const float way = std::hypot(to[0] - from[0], to[1] - from[1], to[2] - from[2]);
  EXPECT_GT(way, 0.001f);
  EXPECT_LT(way, 0.5f);
}
#endif

INSTANTIATE_TEST_SUITE_P(Apis, Programs, testing::ValuesIn(pelage::test::kApis),
                         pelage::test::apiTestName);

}  // namespace
