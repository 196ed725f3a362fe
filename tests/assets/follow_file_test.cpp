// .tfxfollow: round trips, and what no file may do.
#include "pelage/hair_asset.h"

#include <gtest/gtest.h>

#include <cstring>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "pelage/random.h"
#include "support/errors.h"
#include "support/not_numbers.h"
#include "support/test_folder.h"

namespace pelage {
namespace {

using Bytes = std::vector<std::byte>;
using test::expectError;
using test::kNan;
using test::required;
using test::TestFolder;

constexpr size_t kHeaderSize = 24, kHairSize = 36;

std::vector<FollowHair> makeHairs(size_t count = 5) {
  Random random(4);
  std::vector<FollowHair> hairs(count);
  for (FollowHair& hair : hairs) {
    hair.guide = random.below(7);
    hair.offset = {random.uniform(), -random.uniform(), random.uniform(), 3 * random.uniform()};
    for (size_t k = 0; k < 2; ++k) {
      hair.otherGuides[k] = random.below(7);
      hair.otherWeights[k] = 0.5f * random.uniform();
    }
  }
  return hairs;
}

Bytes save(const std::vector<FollowHair>& hairs) {
  const auto bytes = saveFollowHairs(hairs, 7);
  EXPECT_TRUE(bytes);
  return bytes ? *bytes : Bytes{};
}

template <class T>
Bytes with(Bytes bytes, size_t offset, const T& value) {
  std::memcpy(bytes.data() + offset, &value, sizeof(T));
  return bytes;
}

// The error names the byte and the text.
bool refuses(const Bytes& bytes, size_t offset, std::string_view text, uint32_t guideCount = 7) {
  const auto loaded = loadFollowHairs(bytes, "wig", guideCount);
  if (loaded) return false;
  const std::string& message = loaded.error().message;
  EXPECT_EQ(message.rfind("wig: byte " + std::to_string(offset) + ": ", 0), 0u) << message;
  EXPECT_NE(message.find(text), std::string::npos) << message;
  return loaded.error().code == ErrorCode::kInvalidFile;
}

TEST(FollowFile, GivesTheSameHairsAndTheSameBytes) {
  for (const size_t count : {size_t{0}, size_t{1}, size_t{1000}}) {
    const std::vector<FollowHair> hairs = makeHairs(count);
    const Bytes bytes = save(hairs);
    EXPECT_EQ(bytes.size(), kHeaderSize + count * kHairSize);
    for (const uint32_t guideCount : {0u, 7u}) {
      const auto loaded = required(loadFollowHairs(bytes, "wig", guideCount));
      EXPECT_EQ(*loaded, hairs);
      EXPECT_EQ(save(*loaded), bytes);
    }
  }
}

TEST(FollowFile, HasTheDocumentedLayout) {
  FollowHair hair;
  hair.guide = 1;
  hair.offset = {2, 3, 4, 5};
  hair.otherGuides[0] = 6;
  hair.otherWeights[1] = 0.5f;
  const Bytes bytes = save({hair});
  EXPECT_EQ(std::memcmp(bytes.data(), "PLGFOLLW", 8), 0);
  const auto word = [&](size_t at) {
    uint32_t value;
    std::memcpy(&value, bytes.data() + at, sizeof(value));
    return value;
  };
  const auto number = [&](size_t at) {
    float value;
    std::memcpy(&value, bytes.data() + at, sizeof(value));
    return value;
  };
  EXPECT_EQ(word(8), 1u);
  EXPECT_EQ(word(12), 7u);
  EXPECT_EQ(word(16), 1u);
  EXPECT_EQ(word(20), 0u);
  EXPECT_EQ(word(24), 1u);
  for (size_t i = 0; i < 4; ++i) EXPECT_EQ(number(28 + 4 * i), 2 + static_cast<float>(i));
  EXPECT_EQ(word(44), 6u);
  EXPECT_EQ(word(48), 0u);
  EXPECT_EQ(number(52), 0);
  EXPECT_EQ(number(56), 0.5f);
}

TEST(FollowFile, RefusesEveryTruncation) {
  const Bytes bytes = save(makeHairs(3));
  for (size_t size = 0; size < bytes.size(); ++size)
    EXPECT_TRUE(refuses({bytes.begin(), bytes.begin() + static_cast<std::ptrdiff_t>(size)}, size,
                        size < kHeaderSize ? "header" : "3 follow hairs need 132 bytes"));
}

TEST(FollowFile, RefusesWhatNoSceneTakes) {
  const Bytes good = save(makeHairs());
  const size_t second = kHeaderSize + kHairSize;
  EXPECT_TRUE(refuses(with(good, 0, 'p'), 0, "no .tfxfollow file"));
  EXPECT_TRUE(refuses(with(good, 8, 2u), 8, "version is 2"));
  EXPECT_TRUE(refuses(with(good, 12, 0u), 12, "0 guides"));
  EXPECT_TRUE(refuses(good, 12, "for 7 guides, but the hair has 8", 8));
  EXPECT_TRUE(refuses(with(good, 16, 4u), good.size() - kHairSize, "36 bytes follow"));
  EXPECT_TRUE(refuses(with(good, 16, 0xffffffffu), good.size(), "file ends here"));
  EXPECT_TRUE(refuses(with(good, 20, 1u), 20, "reserved"));
  EXPECT_TRUE(refuses(with(good, second, 7u), second, "hair 1: it follows guide 7 of 7"));
  EXPECT_TRUE(refuses(with(good, second + 12, kNan), second + 12, "number 2 of its offset is nan"));
  EXPECT_TRUE(refuses(with(good, second + 16, -2e6f), second + 16, "within +-1e6"));
  EXPECT_TRUE(refuses(with(good, second + 24, 9u), second + 24, "guide 9 of 7"));
  EXPECT_TRUE(refuses(with(good, second + 28, -0.5f), second + 28, "a weight is -0.5"));
  EXPECT_TRUE(refuses(with(good, second + 32, kNan), second + 32, "a weight is nan"));
  EXPECT_TRUE(refuses(with(with(good, second + 28, 0.75f), second + 32, 0.5f), second + 28,
                      "more than 1 together"));
}

TEST(FollowFile, DoesNotWriteWhatItWouldNotRead) {
  std::vector<FollowHair> hairs = makeHairs();
  EXPECT_FALSE(saveFollowHairs(hairs, 0));
  EXPECT_FALSE(saveFollowHairs(hairs, 1));
  hairs[3].otherWeights[0] = 1.5f;
  expectError(saveFollowHairs(hairs, 7), ErrorCode::kInvalidArgument, "follow hair 3");
}

TEST(FollowFile, GoesThroughADisk) {
  const TestFolder folder;
  const auto path = folder / "hairs";
  const std::vector<FollowHair> hairs = makeHairs();
  ASSERT_TRUE(saveFollowHairs(hairs, 7, path));
  const auto loaded = required(loadFollowHairs(path, 7));
  EXPECT_EQ(*loaded, hairs);
  expectError(loadFollowHairs(folder / "none", 7), ErrorCode::kFileNotFound, "none");
  EXPECT_FALSE(saveFollowHairs(hairs, 7, path / "no_folder" / "x.tfxfollow"));
}

}  // namespace
}  // namespace pelage
