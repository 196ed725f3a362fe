// Motion of a bake's hair: streams of bone transforms, point caches, and the mesh that these move.
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstring>
#include <numbers>
#include <string>
#include <vector>

#include "bake/point_file.h"
#include "bone_stream.h"
#include "obj_mesh.h"
#include "pelage/skeleton.h"
#include "point_cache.h"
#include "skin_mesh.h"
#include "support/errors.h"
#include "support/not_numbers.h"
#include "support/plain_asset.h"
#include "support/test_folder.h"

namespace pelage::bake {
namespace {

using test::bytesOfFloats;
using test::expectError;
using test::expectHas;
using test::kNan;
using test::pointFile;
using test::required;
using test::TestFolder;

// 90 degrees about z, then to x = 2.
constexpr std::array<float, 12> kTurned = {0, -1, 0, 2, 1, 0, 0, 0, 0, 0, 1, 0};
constexpr std::array<float, 12> kUnmoved = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0};

class Stream : public testing::Test {
 protected:
  Result<BoneStream> load(const std::string& header, const std::vector<float>& floats) {
    (void)folder_.write("b.bin", bytesOfFloats(floats));
    return loadBoneStream(folder_.write("b.json", header));
  }
  std::string errorOf(const std::string& header, const std::vector<float>& floats) {
    const auto stream = load(header, floats);
    return stream ? "accepted" : stream.error().message;
  }
  TestFolder folder_;
};

constexpr const char* kHeader =
    R"({"version": 1, "fps": 10, "bones": ["a", "b"], "data": "b.bin"})";

std::vector<float> joined(std::initializer_list<std::array<float, 12>> transforms) {
  std::vector<float> all;
  for (const auto& one : transforms) all.insert(all.end(), one.begin(), one.end());
  return all;
}

TEST_F(Stream, HasItsTransformsAtItsFramesAndTurnsOnTheShortestArcBetween) {
  const auto stream = required(load(kHeader, joined({kUnmoved, kUnmoved, kTurned, kUnmoved})));
  EXPECT_EQ(stream->bones, (std::vector<std::string>{"a", "b"}));
  ASSERT_EQ(stream->frameCount(), 2u);
  for (const double early : {-1.0, 0.0})
    EXPECT_EQ(transformsAt(*stream, early)[0], AffineTransform());
  for (const double late : {0.1, 7.0}) {
    const Float3 p = transformPoint(transformsAt(*stream, late)[0], {1, 0, 0});
    EXPECT_EQ(p, (Float3{2, 1, 0})) << "at " << late;
  }
  const auto third = transformsAt(*stream, 0.1 / 3);
  const Float3 p = transformPoint(third[0], {1, 0, 0});
  EXPECT_NEAR(p.x, 2.0f / 3 + std::cos(std::numbers::pi_v<float> / 6), 1e-6f);
  EXPECT_NEAR(p.y, std::sin(std::numbers::pi_v<float> / 6), 1e-6f);
  EXPECT_EQ(transformPoint(third[1], {1, 2, 3}), (Float3{1, 2, 3}));
}

TEST_F(Stream, ScaleStaysOnTheLineBetweenItsValues) {
  std::array<float, 12> scaled = kTurned;
  for (const size_t i : {1u, 4u}) scaled[i] *= 3;
  const auto stream = required(load(R"({"version": 1, "fps": 10, "bones": ["a"], "data": "b.bin"})",
                                    joined({kUnmoved, scaled})));
  const AffineTransform half = transformsAt(*stream, 0.05)[0];
  const Float3 p = transformPoint(half, {1, 0, 0});
  EXPECT_NEAR(std::hypot(p.x - 1, p.y), 2, 1e-6f);
  EXPECT_NEAR(p.x - 1, p.y, 1e-6f) << "45 degrees";
}

TEST_F(Stream, BindTransformsAreTakenOff) {
  const auto stream = required(load(
      R"({"version": 1, "fps": 10, "bones": ["a"], "bind": [[1,0,0,0, 0,1,0,5, 0,0,1,0]],
          "data": "b.bin"})",
      joined({{1, 0, 0, 0, 0, 1, 0, 7, 0, 0, 1, 0}})));
  EXPECT_EQ(transformPoint(stream->transforms[0], {0, 5, 0}), (Float3{0, 7, 0}));
}

TEST_F(Stream, WhatIsWrongIsNamedByFileAndPlace) {
  const std::vector<float> one = joined({kUnmoved, kUnmoved});
  struct Case {
    const char *from, *to, *message;
  };
  for (const Case& c : std::vector<Case>{
           {"\"fps\": 10", "\"fps\": 0", "b.json: /fps: must be a number from"},
           {"\"fps\": 10", "\"fps\": \"x\"", "b.json: /fps: must be a number from"},
           {"\"fps\": 10, ", "", "b.json: /fps: is missing"},
           {"\"version\": 1", "\"version\": 3", "b.json: /version"},
           {"\"a\", \"b\"", "", "b.json: /bones: must be 1 to"},
           {"\"a\", \"b\"", "\"a\", \"a\"", "b.json: /bones: has 'a' twice"},
           {"\"data\"", "\"dat\"", "b.json: /data: is missing"},
           {"\"bones\"", "\"bind\": [[]], \"bones\"", "b.json: /bind: must have a transform"},
           {"\"bones\"", "\"bind\": [[1,0,0,0,2,0,0,0,0,0,1,0], 5], \"bones\"",
            "b.json: /bind/0: must be 12 finite"}}) {
    std::string text = kHeader;
    const size_t at = text.find(c.from);
    ASSERT_NE(at, std::string::npos) << c.from;
    text.replace(at, std::string(c.from).size(), c.to);
    const std::string error = errorOf(text, one);
    expectHas(error, c.message);
  }
  std::vector<float> floats = one;
  expectHas(errorOf(kHeader, {}), "b.bin: has 0 bytes");
  floats.pop_back();
  expectHas(errorOf(kHeader, floats), "b.bin: has 92 bytes");
  floats = joined({kUnmoved, kUnmoved, kUnmoved, kUnmoved});
  floats[40] = kNan;
  expectHas(errorOf(kHeader, floats), "b.bin: byte 144: frame 1: the transform of 'b' is not");
  EXPECT_FALSE(loadBoneStream(folder_ / "none.json"));
}

TEST(Points, AreThoseOfTheSamplesAndOnTheLineBetween) {
  const TestFolder folder;
  const auto path =
      folder.write("a.pc2", pointFile(2, 2.0f, {{{0, 0, 0}, {1, 0, 0}}, {{0, 4, 0}, {1, 0, 8}}}));
  auto cache = required(PointCache::open(path));
  EXPECT_EQ(cache->pointCount(), 2u);
  EXPECT_EQ(cache->sampleCount(), 2u);
  EXPECT_EQ(*cache->positionsAt(-3), (std::vector<Float3>{{0, 0, 0}, {1, 0, 0}}));
  EXPECT_EQ(*cache->positionsAt(0.5), (std::vector<Float3>{{0, 1, 0}, {1, 0, 2}}));
  EXPECT_EQ(*cache->positionsAt(2), (std::vector<Float3>{{0, 4, 0}, {1, 0, 8}}));
  EXPECT_EQ(*cache->positionsAt(99), *cache->positionsAt(2));
}

TEST(Points, WhatIsWrongIsNamedByItsByte) {
  const TestFolder folder;
  const std::string fine = pointFile(2, 1.0f, {{{0, 0, 0}, {1, 0, 0}}, {{0, 4, 0}, {1, 0, 8}}});
  struct Case {
    size_t offset;
    uint32_t word;
    const char* message;
  };
  for (const Case& c : std::vector<Case>{
           {0, 0, "byte 0: is no point cache"},
           {12, 2, "byte 12: is of another version"},
           {16, 0, "byte 16: has 0 points"},
           {16, 0xffffffff, "byte 16: has -1 points"},
           {16, 0x7fffffff, "byte 80: 2 samples of 2147483647 points have"},
           {24, 0, "byte 24: has 0 frames a sample"},
           {24, 0x7fc00000, "byte 24: has nan frames a sample"},
           {28, 0, "byte 28: has 0 samples"},
           {28, 1, "byte 56: 1 samples of 2 points have 56 bytes, and the file has 80"},
           {60, 0x7f800000, "byte 56: sample 1: point 0 is not finite"},
           {72, 0x7fc00000, "byte 68: sample 1: point 1 is not finite"}}) {
    std::string bytes = fine;
    std::memcpy(bytes.data() + c.offset, &c.word, sizeof(c.word));
    auto cache = PointCache::open(folder.write("a.pc2", bytes));
    expectError(cache ? cache->positionsAt(0.5) : cache.error(),
                {std::string("a.pc2: ") + c.message});
  }
  for (const size_t size : {0u, 31u, 32u, 79u})
    EXPECT_FALSE(PointCache::open(folder.write("a.pc2", fine.substr(0, size)))) << size;
  EXPECT_FALSE(PointCache::open(folder / "none.pc2"));
}

TEST(SkinMesh, OfAnObjFileKeepsItsVerticesInOrder) {
  const auto mesh =
      required(readObjMesh("# quad\r\no skin\nv 0 0 0\nv 1 0 0 1\nvn 0 0 1\n\tv 1 1 0\nv 0 1e0 0\n"
                           "f 1//1 2//1 3//1 4//1\nv 9 9 9\nf -5/1/1 -4/2 5",
                           "a.obj"));
  EXPECT_EQ(mesh->positions.size(), 5u);
  EXPECT_EQ(mesh->indices, (std::vector<uint32_t>{0, 1, 2, 0, 2, 3, 0, 1, 4}));
  struct Case {
    const char *text, *message;
  };
  for (const Case& c :
       std::vector<Case>{{"", "a.obj: has no faces"},
                         {"v 0 0 0\nv 1 0", "a.obj:2: a vertex needs"},
                         {"v 0 0 nan", "a.obj:1: a vertex needs"},
                         {"v 0 0 0x", "a.obj:1: a vertex needs"},
                         {"v 0 2e6 0", "a.obj:1: a vertex needs"},
                         {"v 0 0 0\nf 1 1", "a.obj:2: a face needs"},
                         {"v 0 0 0\nf 1 1 2", "a.obj:2: a corner is none"},
                         {"v 0 0 0\nf 1 1 0", "a.obj:2: a corner is none"},
                         {"v 0 0 0\nf 1 1 -2", "a.obj:2: a corner is none"},
                         {"v 0 0 0\nf 1 1 /1", "a.obj:2: a corner is none"},
                         {"v 0 0 0\nf 1 1 99999999999999999999", "a.obj:2: a corner is none"}}) {
    expectError(readObjMesh(c.text, "a.obj"), {c.message});
  }
}

TEST(SkinMesh, RootsThatAreFarFromItAreReported) {
  const TestFolder folder;
  const HairAsset hair = test::makeAsset(3, 4);
  std::string warning;
  for (const auto& [height, near] : {std::pair("0", true), std::pair("-0.02", false)}) {
    std::string text;
    for (const char* corner : {"-100 H -100", "-100 H 100", "100 H 100", "100 H -100"}) {
      text += std::string("v ") + corner + "\n";
      text.replace(text.find('H'), 1, near ? "0" : "-2");
    }
    const auto mesh = required(loadSkinMesh(folder.write("a.obj", text + "f 1 2 3 4\n"), 0.01f));
    ASSERT_EQ(mesh->influences.size(), 4u);
    EXPECT_EQ(mesh->influences[3].bones[0], 3u);
    EXPECT_EQ(mesh->positions[2], (Float3{1, near ? 0.0f : -0.02f, 1}));
    warning.clear();
    const auto table = required(bindToSkin(hair, *mesh, warning));
    EXPECT_EQ(table->roots.size(), 3u);
    EXPECT_EQ(warning.empty(), near) << warning << " at " << height;
  }
  expectHas(warning, "3 of 3 roots");
}

}  // namespace
}  // namespace pelage::bake
