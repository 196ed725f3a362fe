// Fields in files.
#include <gtest/gtest.h>

#include <cstring>
#include <filesystem>
#include <limits>
#include <vector>

#include "pelage/sdf_collider.h"
#include "support/errors.h"
#include "support/test_folder.h"

namespace pelage {
namespace {

constexpr size_t kHeaderBytes = 52;

SdfData sampleData() {
  SdfData data;
  data.grid = {.origin = {-1, 2, 0.5f}, .cellSize = 0.25f, .nodes = {4, 3, 2}};
  data.band = 2;
  data.farRange = 12;
  data.triangleBits = 2;
  data.triangleCount = 3;
  for (uint32_t i = 0; i < 24; ++i)
    data.keys.push_back(i % 5 == 0 ? 0xffffffffu : ((i << 2) | (i % 3)));
  for (uint32_t t = 0; t < 3; ++t) {
    for (uint32_t w = 0; w < 16; ++w)
      data.surface.push_back(w == 12 ? 0xffffffffu : (w == 13 || w == 14 ? t : 0x3f800000u + w));
  }
  return data;
}

class SdfDataTest : public testing::Test {
 protected:
  void SetUp() override { test::required(saveSdf(sampleData(), path_)); }
  template <class T>
  static void expectRefused(std::vector<std::byte> bytes, size_t at, T value, const char* what) {
    std::memcpy(bytes.data() + at, &value, sizeof(value));
    test::expectError(loadSdf(bytes, "bad.psdf"), ErrorCode::kInvalidFile, {"bad.psdf", what});
  }

  const test::TestFolder folder_;
  const std::filesystem::path path_ = folder_ / "sample.psdf";
};

TEST_F(SdfDataTest, WhatIsSavedIsWhatIsLoaded) {
  EXPECT_EQ(test::valueOf(loadSdf(path_)), sampleData());
}

TEST_F(SdfDataTest, NodesInsideMayHaveNoTriangle) {
  SdfData data = sampleData();
  data.keys[1] = 0x80000000u | (5u << 2) | 3u;
  ASSERT_TRUE(saveSdf(data, path_));
  EXPECT_EQ(test::valueOf(loadSdf(path_)), data);
}

TEST_F(SdfDataTest, EveryFaultOfAFileIsNamedWithItsPlace) {
  const std::vector<std::byte> good = test::bytesOf(path_);
  ASSERT_EQ(good.size(), kHeaderBytes + 24 * 4 + 3 * 64);
  expectRefused(good, 0, uint32_t{1}, "byte 0: is no .psdf file");
  expectRefused(good, 4, uint32_t{7}, "byte 4: has version 7");
  expectRefused(good, 8, std::numeric_limits<float>::quiet_NaN(), "out of range");
  expectRefused(good, 20, 0.0f, "out of range");
  expectRefused(good, 24, uint32_t{5}, "5 x 3 x 2 nodes");
  expectRefused(good, 24, uint32_t{0x80000000u}, "nodes is none");
  expectRefused(good, 28, uint32_t{4}, "its header asks for");
  expectRefused(good, 44, uint32_t{33}, "do not fit 33 bits");
  expectRefused(good, 48, uint32_t{4}, "4 triangles do not fit 2 bits");
  expectRefused(good, kHeaderBytes + 4, uint32_t{3}, "byte 56: node 1 refers to triangle 3 of 3");
  expectRefused(good, kHeaderBytes + 96 + 48, uint32_t{3}, "byte 196: triangle 0 has triangle 3");
  for (const size_t size : {size_t{0}, size_t{51}, size_t{60}, good.size() - 1}) {
    const Result<SdfData> loaded = loadSdf(std::span(good).first(size), "short.psdf");
    EXPECT_FALSE(loaded) << size;
  }
}

TEST_F(SdfDataTest, WhatDoesNotFitTogetherIsNotSaved) {
  SdfData data = sampleData();
  data.keys.pop_back();
  EXPECT_FALSE(saveSdf(data, path_));
  data = sampleData();
  data.band = 0;
  EXPECT_FALSE(saveSdf(data, path_));
  const Result<SdfData> kept = loadSdf(path_);
  ASSERT_TRUE(kept) << "the file that was there is lost";
}

TEST_F(SdfDataTest, AMissingFileIsAnError) {
  const Result<SdfData> loaded = loadSdf(path_ / "nothing.psdf");
  ASSERT_FALSE(loaded);
  EXPECT_EQ(loaded.error().code, ErrorCode::kFileNotFound);
}

}  // namespace
}  // namespace pelage
