// Files of USD curves: numbers that read back to the same bits, and no file where something is
// wrong. tests/usd reads such files by a program of others.
#include "pelage/authoring/usd_curves.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <limits>
#include <string>
#include <vector>

#include "support/errors.h"
#include "support/test_folder.h"

namespace pelage {
namespace {

using test::required;
using test::TestFolder;
using test::textOf;

class UsdCurves : public testing::Test {
 protected:
  std::string text(const char* name) const { return textOf(folder_ / name); }
  const TestFolder folder_;
};

UsdCurvesDef twoStrands() {
  UsdCurvesDef def;
  def.vertexCounts = {2, 3};
  return def;
}

TEST_F(UsdCurves, NumbersReadBackToTheSameBits) {
  const std::vector<Float3> frame = {{0.1f, -1.0f / 3, 1e-30f},
                                     {16777216, 3.4e38f, -0.0f},
                                     {1e-45f, 123456.789f, 5},
                                     {2, 0.3f, 7},
                                     {1e10f, -1e-10f, 0}};
  UsdCurvesDef def = twoStrands();
  def.velocities = false;
  auto writer = required(UsdCurvesWriter::create(folder_ / "a.usda", def));
  ASSERT_TRUE(writer->append(frame));
  ASSERT_TRUE(writer->close());
  const std::string file = text("a.usda");
  const char* at = file.c_str() + file.find("0: [") + 4;
  for (const Float3& p : frame) {
    for (const float expected : {p.x, p.y, p.z}) {
      at += std::strspn(at, "(), ");
      char* end = nullptr;
      const float value = std::strtof(at, &end);
      EXPECT_EQ(value, expected);
      EXPECT_EQ(std::signbit(value), std::signbit(expected));
      at = end;
    }
  }
  EXPECT_EQ(file.find("velocities"), std::string::npos);
  EXPECT_EQ(file.find("inf"), std::string::npos);
}

TEST_F(UsdCurves, SeveralThreadsWriteTheBytesOfOne) {
  UsdCurvesDef def;
  def.vertexCounts.assign(7000, 5);  // 9 pieces of text, more than 2 threads have at a time
  std::string expected;
  for (const uint32_t threads : {1u, 0u, 2u, 5u}) {
    auto writer = required(UsdCurvesWriter::create(folder_ / "a.usda", def, threads));
    std::vector<Float3> frame(35000);
    for (int f = 0; f < 2; ++f) {
      for (size_t i = 0; i < frame.size(); ++i)
        frame[i] = {0.1f * static_cast<float>(i), 1.0f / static_cast<float>(i + 3), -frame[i].x};
      ASSERT_TRUE(writer->append(frame));
    }
    ASSERT_TRUE(writer->close());
    if (threads == 1) expected = text("a.usda");
    EXPECT_TRUE(text("a.usda") == expected) << threads << " threads";
  }
  size_t parentheses = 0;
  for (const char c : expected) parentheses += c == '(' ? 1 : 0;
  EXPECT_GE(parentheses, 4 * 35000u);
}

TEST_F(UsdCurves, AFileThatWasNotClosedIsNotThere) {
  const std::vector<Float3> frame(5);
  {
    auto writer = required(UsdCurvesWriter::create(folder_ / "a.usda", twoStrands()));
    ASSERT_TRUE(writer->append(frame));
    EXPECT_FALSE(std::filesystem::exists(folder_ / "a.usda"));
  }
  EXPECT_TRUE(std::filesystem::is_empty(folder_.path()));
  for (const char* name : {"a.usda", "b.usda"}) {
    auto writer = required(UsdCurvesWriter::create(folder_ / name, twoStrands()));
    for (int f = 0; f < 3; ++f) ASSERT_TRUE(writer->append(frame));
    ASSERT_TRUE(writer->close());
    EXPECT_FALSE(writer->close());
    EXPECT_FALSE(writer->append(frame));
  }
  EXPECT_EQ(text("a.usda"), text("b.usda"));
  EXPECT_NE(text("a.usda").find("endTimeCode = 2 "), std::string::npos);
}

TEST_F(UsdCurves, RefusesWhatIsNoFileOfUsd) {
  const auto refused = [&](auto change) {
    UsdCurvesDef def = twoStrands();
    change(def);
    return !validate(def) && !UsdCurvesWriter::create(folder_ / "a.usda", def);
  };
  EXPECT_TRUE(refused([](auto& d) { d.name = ""; }));
  EXPECT_TRUE(refused([](auto& d) { d.name = "2hair"; }));
  EXPECT_TRUE(refused([](auto& d) { d.name = "a\" (b)"; }));
  EXPECT_TRUE(refused([](auto& d) { d.vertexCounts = {}; }));
  EXPECT_TRUE(refused([](auto& d) { d.vertexCounts = {2, 1}; }));
  EXPECT_TRUE(refused([](auto& d) { d.widths = {1, 2, 3}; }));
  EXPECT_TRUE(refused([](auto& d) { d.widths = {-1}; }));
  EXPECT_TRUE(refused([](auto& d) { d.widths = {std::nanf("")}; }));
  EXPECT_TRUE(refused([](auto& d) { d.strandIds = {1}; }));
  EXPECT_TRUE(refused([](auto& d) { d.strandIds = {1, uint64_t{1} << 63}; }));
  EXPECT_TRUE(refused([](auto& d) { d.framesPerSecond = 0; }));
  EXPECT_TRUE(refused([](auto& d) { d.firstFrame = int64_t{1} << 41; }));
  auto writer = required(UsdCurvesWriter::create(folder_ / "a.usda", twoStrands()));
  std::vector<Float3> frame(5);
  EXPECT_FALSE(writer->append(std::span(frame).first(4)));
  EXPECT_FALSE(writer->close()) << "without frames";
  frame[4].y = std::numeric_limits<float>::infinity();
  EXPECT_FALSE(writer->append(frame));

  const UsdClip gap[] = {{"a", 1, 2}, {"b", 4, 2}}, name[] = {{"a@b", 1, 2}},
                none[] = {{"a", 1, 0}};
  for (const std::span<const UsdClip> clips :
       {std::span<const UsdClip>(), std::span<const UsdClip>(gap), std::span<const UsdClip>(name),
        std::span<const UsdClip>(none)})
    EXPECT_FALSE(saveUsdClips(folder_ / "clips.usda", twoStrands(), clips));
  EXPECT_FALSE(std::filesystem::exists(folder_ / "clips.usda"));
}

}  // namespace
}  // namespace pelage
