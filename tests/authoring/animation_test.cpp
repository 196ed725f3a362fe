// Clips of glTF files.
#include "pelage/authoring/animation.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <functional>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "support/errors.h"
#include "support/not_numbers.h"

namespace pelage {
namespace {

using nlohmann::json;
using test::expectError;
using test::kNan;
using test::required;

std::string base64(const std::vector<uint8_t>& bytes) {
  constexpr const char* kDigits =
      "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string text;
  for (size_t i = 0; i < bytes.size(); i += 3) {
    uint32_t bits = 0;
    for (size_t k = 0; k < 3; ++k) bits = bits << 8 | (i + k < bytes.size() ? bytes[i + k] : 0u);
    for (int shift = 18; shift >= 0; shift -= 6) text += kDigits[bits >> shift & 63];
  }
  return text;
}

/// A glTF file with its buffer inside.
class File {
 public:
  json root = {{"asset", {{"version", "2.0"}}}, {"nodes", json::array()}};

  uint32_t add(const std::vector<float>& values, const char* type, size_t components) {
    root["bufferViews"].push_back(
        {{"buffer", 0}, {"byteOffset", bytes_.size()}, {"byteLength", values.size() * 4}});
    root["accessors"].push_back({{"bufferView", root["bufferViews"].size() - 1},
                                 {"componentType", 5126},
                                 {"count", values.size() / components},
                                 {"type", type}});
    for (const float value : values) {
      uint8_t raw[4];
      std::memcpy(raw, &value, 4);
      bytes_.insert(bytes_.end(), raw, raw + 4);
    }
    return static_cast<uint32_t>(root["accessors"].size() - 1);
  }

  /// Adds keys to the first clip.
  void animate(uint32_t node, const char* path, const std::vector<float>& times,
               const std::vector<float>& values, const char* interpolation = "LINEAR") {
    if (!root.contains("animations"))
      root["animations"] = {
          {{"name", "walk"}, {"channels", json::array()}, {"samplers", json::array()}}};
    json& clip = root["animations"][0];
    const bool turns = std::string(path) == "rotation";
    const uint32_t input = add(times, "SCALAR", 1);
    const uint32_t output = add(values, turns ? "VEC4" : "VEC3", turns ? 4 : 3);
    clip["channels"].push_back(
        {{"sampler", clip["samplers"].size()}, {"target", {{"node", node}, {"path", path}}}});
    clip["samplers"].push_back(
        {{"input", input}, {"output", output}, {"interpolation", interpolation}});
  }

  std::string text() const {
    json file = root;
    file["buffers"] = {{{"byteLength", bytes_.size()},
                        {"uri", "data:application/octet-stream;base64," + base64(bytes_)}}};
    return file.dump();
  }
  Result<SkeletonAnimation> load(std::string_view clip = {}) const {
    const std::string bytes = text();
    return loadAnimation(std::as_bytes(std::span(bytes)), "test.gltf", clip);
  }

 private:
  std::vector<uint8_t> bytes_;
};

Float3 positionOf(const SkeletonAnimation& animation, double seconds, size_t node = 0) {
  return transformPoint(poseAt(animation, seconds)[node], {});
}

void expectNear(const Float3& a, const Float3& b, float tolerance = 1e-6f) {
  EXPECT_NEAR(a.x, b.x, tolerance);
  EXPECT_NEAR(a.y, b.y, tolerance);
  EXPECT_NEAR(a.z, b.z, tolerance);
}

TEST(Animation, IsLinearBetweenKeysAndStaysOutsideOfThem) {
  File file;
  file.root["nodes"] = {{{"name", "hip"}, {"translation", {9, 9, 9}}}};
  file.animate(0, "translation", {0.5f, 1.5f, 2}, {0, 0, 0, 2, 0, 0, 2, 4, 0});
  const auto animation = required(file.load());
  EXPECT_EQ(animation->name, "walk");
  EXPECT_EQ(animation->nodes[0].name, "hip");
  EXPECT_NEAR(animation->seconds, 2, 1e-9);
  expectNear(positionOf(*animation, 0), {0, 0, 0});
  expectNear(positionOf(*animation, 0.5), {0, 0, 0});
  expectNear(positionOf(*animation, 0.75), {0.5f, 0, 0});
  expectNear(positionOf(*animation, 1.5), {2, 0, 0});
  expectNear(positionOf(*animation, 1.75), {2, 2, 0});
  expectNear(positionOf(*animation, 7), {2, 4, 0});
}

TEST(Animation, HoldsStepsAndFollowsSplines) {
  File file;
  file.root["nodes"] = {{{"name", "a"}}, {{"name", "b"}}};
  file.animate(0, "translation", {0, 1}, {1, 0, 0, 2, 0, 0}, "STEP");
  // t^3 with its derivative as tangents: Hermite splines have the polynomial itself.
  std::vector<float> spline;
  for (const float t : {0.0f, 0.5f, 2.0f})
    for (const float value : {3 * t * t, t * t * t, 3 * t * t})
      spline.insert(spline.end(), {value, 0, -value});
  file.animate(1, "translation", {0, 0.5f, 2}, spline, "CUBICSPLINE");
  const auto animation = required(file.load());
  expectNear(positionOf(*animation, 0.99), {1, 0, 0});
  expectNear(positionOf(*animation, 1), {2, 0, 0});
  for (const float t : {0.0f, 0.1f, 0.5f, 0.9f, 1.7f, 2.0f})
    expectNear(positionOf(*animation, t, 1), {t * t * t, 0, -t * t * t}, 2e-6f);
}

TEST(Animation, TurnsOnTheShortestArc) {
  File file;
  file.root["nodes"] = {{{"name", "neck"}}};
  const float s = std::sin(0.4f), c = std::cos(0.4f);  // 0.8 about z, with the other sign
  file.animate(0, "rotation", {0, 1}, {0, 0, 0, 1, 0, 0, -s, -c});
  const auto animation = required(file.load());
  const Float3 half = transformPoint(poseAt(*animation, 0.5)[0], {1, 0, 0});
  expectNear(half, {std::cos(0.4f), std::sin(0.4f), 0});
}

TEST(Animation, PutsParentsFirstAndChildrenOntoThem) {
  File file;
  // The file has the child before its parent, and a scale between.
  file.root["nodes"] = {
      {{"name", "hand"}, {"translation", {0, 1, 0}}},
      {{"name", "arm"}, {"children", {0}}, {"scale", {2, 2, 2}}, {"translation", {1, 0, 0}}}};
  file.animate(1, "translation", {0, 1}, {1, 0, 0, 5, 0, 0});
  const auto animation = required(file.load());
  ASSERT_EQ(animation->nodes[0].name, "arm");
  EXPECT_EQ(animation->nodes[1].parent, 0);
  expectNear(positionOf(*animation, 1, 1), {5, 2, 0});
  const Skeleton skeleton = skeletonOf(*animation);
  expectNear(transformPoint(skeleton.bones[1].bind, {}), {1, 2, 0});
  // In the pose of the file nothing moves.
  for (const AffineTransform& bone : skinningTransforms(skeleton, poseAt(*animation, 0)))
    expectNear(transformPoint(bone, {0.3f, -0.2f, 0.7f}), {0.3f, -0.2f, 0.7f});
  expectNear(transformPoint(skinningTransforms(skeleton, poseAt(*animation, 1))[1], {0, 0, 0}),
             {4, 0, 0});
}

TEST(Animation, FindsClipsByNameAndListsThemOtherwise) {
  File file;
  file.root["nodes"] = {{{"name", "a"}}};
  file.animate(0, "translation", {0, 1}, {0, 0, 0, 1, 0, 0});
  file.root["animations"].push_back(file.root["animations"][0]);
  file.root["animations"][1]["name"] = "jump";
  ASSERT_TRUE(file.load("jump"));
  EXPECT_EQ(file.load("jump")->name, "jump");
  expectError(file.load("fly"), "there is no 'fly'; there are: walk, jump");
}

TEST(Animation, RefusesWhatDoesNotFitTogether) {
  struct Case {
    const char* expected;
    std::function<void(File&)> damage;
  };
  const Case cases[] = {
      {"animations: there are none", [](File& f) { f.root.erase("animations"); }},
      {"moves no node", [](File& f) { f.root["animations"][0]["channels"] = json::array(); }},
      {"two parents",
       [](File& f) {
         f.root["nodes"][1]["children"] = {2, 2};
       }},
      {"below itself",
       [](File& f) {
         f.root["nodes"][2]["children"] = {1};
         f.root["nodes"][1]["children"] = {2};
       }},
      {"not the number of a node", [](File& f) { f.root["nodes"][0]["children"] = {99}; }},
      {"there is no node 7",
       [](File& f) { f.root["animations"][0]["channels"][0]["target"]["node"] = 7; }},
      {"no sampler 3", [](File& f) { f.root["animations"][0]["channels"][0]["sampler"] = 3; }},
      {"interpolation 'X' is none",
       [](File& f) { f.root["animations"][0]["samplers"][0]["interpolation"] = "X"; }},
      {"instead of",
       [](File& f) { f.root["animations"][0]["samplers"][0]["interpolation"] = "CUBICSPLINE"; }},
      {"has a matrix",
       [](File& f) {
         f.root["nodes"][0]["matrix"] = {2, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1};
       }},
      {"not 3 numbers",
       [](File& f) {
         f.root["nodes"][0]["translation"] = {1, "2", 3};
       }},
      {"animated twice",
       [](File& f) {
         f.animate(0, "translation", {0, 1}, {0, 0, 0, 1, 0, 0});
       }},
      {"must ascend",
       [](File& f) {
         f.animate(1, "translation", {1, 1}, {0, 0, 0, 1, 0, 0});
       }},
      {"must ascend",
       [](File& f) {
         f.animate(1, "translation", {0, kNan}, {0, 0, 0, 1, 0, 0});
       }},
      {"must ascend",
       [](File& f) {
         f.animate(1, "translation", {-1, 1}, {0, 0, 0, 1, 0, 0});
       }},
      {"not finite",
       [](File& f) {
         f.animate(1, "translation", {0, 1}, {0, 0, 0, 1, kNan, 0});
       }},
  };
  for (const Case& c : cases) {
    File file;
    file.root["nodes"] = {{{"name", "a"}}, {{"name", "b"}}, {{"name", "c"}}};
    file.animate(0, "translation", {0, 1}, {0, 0, 0, 1, 0, 0});
    ASSERT_TRUE(file.load());
    c.damage(file);
    expectError(file.load(), {"test.gltf: ", c.expected});
  }
}

TEST(Animation, TakesNoMoreMemoryThanAFileOfItsSizeMayWant) {
  File file;
  constexpr uint32_t kNodes = 3000, kKeys = 3000;
  for (uint32_t i = 0; i < kNodes; ++i) file.root["nodes"].push_back(json::object());
  std::vector<float> times, values(3 * kKeys);
  for (uint32_t i = 0; i < kKeys; ++i) times.push_back(static_cast<float>(i));
  file.animate(0, "translation", times, values);
  json& channels = file.root["animations"][0]["channels"];
  for (uint32_t i = 1; i < kNodes; ++i) {
    channels.push_back(channels[0]);
    channels.back()["target"]["node"] = i;
  }
  expectError(file.load(), "too many channels share");
}

TEST(Animation, NamesAFileThatIsNotThere) {
  expectError(loadAnimation(std::filesystem::path("no_such.gltf")), "no_such.gltf");
}

}  // namespace
}  // namespace pelage
