// The cache of simulated hair: within its bound everywhere, the same in any order of reading, and
// an error for everything that no writer wrote.
#include "pelage/hair_cache.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <filesystem>
#include <limits>
#include <memory>
#include <string>
#include <vector>

#include "pelage/random.h"
#include "support/errors.h"
#include "support/extremes.h"
#include "support/test_folder.h"

namespace pelage {
namespace {

using Bytes = std::vector<std::byte>;
using Frames = std::vector<std::vector<Float3>>;
using test::bytesOf;
using test::required;
using test::TestFolder;

class HairCache : public testing::Test {
 protected:
  // Writes a cache and returns its path.
  std::filesystem::path write(const HairCacheDef& def, std::span<const std::vector<Float3>> frames,
                              const char* name = "a.pelagecache") {
    const auto path = folder_ / name;
    auto writer = required(HairCacheWriter::create(path, def));
    for (const auto& frame : frames) required(writer->append(frame));
    required(writer->close());
    return path;
  }

  const TestFolder folder_;
};

// Strands of many lengths, more than a chunk of them if `many`.
HairCacheDef defOf(bool many) {
  HairCacheDef def;
  def.name = "hair";
  def.strandCount = many ? 700 : 5;
  for (uint32_t s = 0; s < def.strandCount; ++s) {
    def.vertexCounts.push_back(s == 1 ? 1 : 2 + (s * 7) % 23);
    def.strandIds.push_back(uint64_t{s} << 33);
  }
  def.keyInterval = 4;
  return def;
}

// Strands that swing, with some noise, at `offset` [m] from the origin on all axes.
Frames swing(const HairCacheDef& def, int frameCount, float offset, int first = 0) {
  Frames frames;
  for (int f = first; f < first + frameCount; ++f) {
    Random random(11);
    auto& frame = frames.emplace_back();
    for (uint32_t s = 0; s < def.strandCount; ++s) {
      const float phase = 6 * random.uniform();
      const float angle = std::sin(0.3f * static_cast<float>(f) + phase);
      for (uint32_t v = 0; v < def.vertexCounts[s]; ++v) {
        const float t = 0.01f * static_cast<float>(v), noise = 1e-4f * random.uniform();
        frame.push_back({offset + phase + t * std::cos(angle), offset + t * std::sin(angle) + noise,
                         offset - phase});
      }
    }
  }
  return frames;
}

double distance(const Float3& a, const Float3& b) {
  return std::hypot(double{a.x} - b.x, double{a.y} - b.y, double{a.z} - b.z);
}

std::vector<Float3> read(HairCacheReader& reader, uint64_t frame) {
  std::vector<Float3> out(reader.vertexCount());
  required(reader.read(frame, out));
  return out;
}

// The largest distance of a vertex from where it was written [m].
double largestError(HairCacheReader& reader, std::span<const std::vector<Float3>> frames) {
  double largest = 0;
  for (size_t f = 0; f < frames.size(); ++f) {
    const auto positions = read(reader, f);
    for (size_t v = 0; v < positions.size(); ++v)
      test::keepLargest(largest, distance(positions[v], frames[f][v]));
  }
  return largest;
}

TEST_F(HairCache, EveryVertexStaysWithinTheBoundFromTheOriginToHugeCoordinates) {
  HairCacheDef def = defOf(true);
  for (const float bound : {0.02f, 1e-4f, 1e-6f, 1e-9f, 0.0f}) {
    for (const float offset : {0.0f, 9.0f, 300.0f, 4000.0f, 1e6f, 1e9f, 1e30f, 3e38f}) {
      def.errorBound = bound;
      const Frames frames = swing(def, 6, offset);
      auto reader = required(HairCacheReader::open(write(def, frames)));
      ASSERT_EQ(reader->frameCount(), frames.size());
      EXPECT_LE(largestError(*reader, frames), bound) << "at " << offset << " m";
    }
  }
}

TEST_F(HairCache, HairThatLeavesTheOriginStaysWithinTheBound) {
  HairCacheDef def = defOf(false);
  def.keyInterval = 256;
  Frames frames;
  float offset = 0.01f;
  for (int f = 0; f < 60; ++f, offset *= 2) frames.push_back(swing(def, 1, offset, f)[0]);
  auto reader = required(HairCacheReader::open(write(def, frames)));
  EXPECT_LE(largestError(*reader, frames), def.errorBound);
}

TEST_F(HairCache, KeepsBitsWithoutABound) {
  HairCacheDef def = defOf(false);
  def.errorBound = 0;
  Frames frames = swing(def, 3, 0);
  frames[1][0] = {-0.0f, std::numeric_limits<float>::max(),
                  std::numeric_limits<float>::denorm_min()};
  frames[2][1] = {std::numeric_limits<float>::lowest(), 0.0f, -1e-40f};
  auto reader = required(HairCacheReader::open(write(def, frames)));
  EXPECT_EQ(reader->def(), def);
  for (size_t f = 0; f < 3; ++f)
    EXPECT_EQ(
        std::memcmp(read(*reader, f).data(), frames[f].data(), frames[f].size() * sizeof(Float3)),
        0);
}

TEST_F(HairCache, FramesAreTheSameInAnyOrder) {
  HairCacheDef def = defOf(true);
  def.firstFrame = -3;
  auto reader = required(HairCacheReader::open(write(def, swing(def, 14, 1))));
  Frames forwards;
  for (uint64_t f = 0; f < 14; ++f) forwards.push_back(read(*reader, f));
  for (const uint64_t f : {13, 13, 0, 5, 4, 6, 12, 1, 2, 3, 10, 9})
    EXPECT_EQ(read(*reader, f), forwards[f]) << f;
  std::vector<Float3> out(reader->vertexCount());
  EXPECT_FALSE(reader->read(14, out));
  EXPECT_FALSE(reader->read(0, std::span(out).first(1)));
  EXPECT_EQ(read(*reader, 7), forwards[7]);
}

TEST_F(HairCache, MotionThatIsSmoothCostsFewBytes) {
  HairCacheDef def = defOf(true);
  def.keyInterval = 16;
  const Frames frames = swing(def, 16, 0);
  const auto size = std::filesystem::file_size(write(def, frames));
  const double perVertex =
      static_cast<double>(size) / static_cast<double>(frames.size() * frames[0].size());
  EXPECT_LT(perVertex, 3);
}

TEST_F(HairCache, PartsJoinToTheBytesOfOneFile) {
  HairCacheDef def = defOf(true);
  def.firstFrame = 101;
  const Frames frames = swing(def, 15, 0);
  const std::span<const std::vector<Float3>> all(frames);
  const auto whole = write(def, all);
  std::vector<std::filesystem::path> parts = {write(def, all.first(3), "1")};
  def.firstFrame = 104;
  parts.push_back(write(def, all.subspan(3, 8), "2"));
  def.firstFrame = 112;
  parts.push_back(write(def, all.subspan(11, 0), "empty"));
  parts.push_back(write(def, all.subspan(11), "3"));
  required(joinHairCaches(parts, folder_ / "joined"));
  EXPECT_EQ(bytesOf(folder_ / "joined"), bytesOf(whole));

  // Parts that begin elsewhere have more key frames, and the same positions within the bound.
  def.firstFrame = 103;
  const std::vector<std::filesystem::path> odd = {write(def, all.first(1), "4")};
  def.firstFrame = 104;
  const std::vector<std::filesystem::path> both = {odd[0], write(def, all.subspan(1, 5), "5")};
  ASSERT_TRUE(joinHairCaches(both, folder_ / "odd"));
  auto reader = required(HairCacheReader::open(folder_ / "odd"));
  EXPECT_LE(largestError(*reader, all.first(6)), def.errorBound);
}

TEST_F(HairCache, SeveralThreadsWriteTheBytesOfOne) {
  HairCacheDef def = defOf(true);
  const Frames frames = swing(def, 7, 1);
  for (const float bound : {1e-4f, 0.0f}) {
    def.errorBound = bound;
    const Bytes expected = bytesOf(write(def, frames));
    for (const uint32_t threads : {0u, 2u, 64u}) {
      const auto path = folder_ / "threads.pelagecache";
      auto writer = required(HairCacheWriter::create(path, def, threads));
      for (const auto& frame : frames) ASSERT_TRUE(writer->append(frame));
      ASSERT_TRUE(writer->close());
      EXPECT_TRUE(bytesOf(path) == expected) << threads << " threads";
    }
  }
}

TEST_F(HairCache, PartsThatDoNotFitAreRefusedAndLeaveNoFile) {
  HairCacheDef def = defOf(false);
  const Frames frames = swing(def, 4, 0);
  const auto first = write(def, frames, "1");
  def.firstFrame = 5;
  const auto gap = write(def, frames, "gap");
  def.firstFrame = 4;
  def.errorBound = 1e-3f;
  const auto other = write(def, frames, "other");
  const auto result = folder_ / "joined";
  for (const auto& second : {gap, other, folder_ / "missing"}) {
    const std::vector<std::filesystem::path> parts = {first, second};
    EXPECT_FALSE(joinHairCaches(parts, result)) << second;
  }
  EXPECT_FALSE(joinHairCaches({}, result));
  EXPECT_FALSE(std::filesystem::exists(result));
  EXPECT_FALSE(std::filesystem::exists(folder_ / "joined.partial"));
}

TEST_F(HairCache, AFileThatWasNotClosedIsNotThere) {
  const HairCacheDef def = defOf(false);
  const Frames frames = swing(def, 1, 0);
  const auto path = folder_ / "a";
  {
    auto writer = required(HairCacheWriter::create(path, def));
    ASSERT_TRUE(writer->append(frames[0]));
    EXPECT_FALSE(std::filesystem::exists(path));
  }
  EXPECT_TRUE(std::filesystem::is_empty(folder_.path()));
  write(def, {}, "empty");
  auto reader = required(HairCacheReader::open(folder_ / "empty"));
  EXPECT_EQ(reader->frameCount(), 0u);
}

TEST_F(HairCache, TheWriterRefusesWhatItCannotWrite) {
  const HairCacheDef good = defOf(false);
  ASSERT_TRUE(validate(good));
  const auto refused = [&](auto change) {
    HairCacheDef def = good;
    change(def);
    return !validate(def) && !HairCacheWriter::create(folder_ / "a", def);
  };
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_TRUE(refused([](auto& d) { d.strandCount = 0; }));
  EXPECT_TRUE(refused([](auto& d) { d.vertexCounts.pop_back(); }));
  EXPECT_TRUE(refused([](auto& d) { d.vertexCounts[2] = 0; }));
  EXPECT_TRUE(refused([](auto& d) { d.vertexCounts[2] = 257; }));
  EXPECT_TRUE(refused([](auto& d) { d.vertexCounts.clear(); }));
  EXPECT_TRUE(refused([](auto& d) {
    d.vertexCounts.clear();
    d.strandIds.clear();
    d.verticesPerStrand = 256;
    d.strandCount = (1u << 20) + 1;
  }));
  EXPECT_TRUE(refused([](auto& d) { d.strandIds.pop_back(); }));
  EXPECT_TRUE(refused([&](auto& d) { d.framesPerSecond = nan; }));
  EXPECT_TRUE(refused([](auto& d) { d.errorBound = 2; }));
  EXPECT_TRUE(refused([&](auto& d) { d.errorBound = static_cast<float>(nan); }));
  EXPECT_TRUE(refused([](auto& d) { d.firstFrame = int64_t{1} << 41; }));
  EXPECT_TRUE(refused([](auto& d) { d.keyInterval = 0; }));
  EXPECT_TRUE(refused([](auto& d) { d.name.assign(4096, 'x'); }));
  EXPECT_TRUE(std::filesystem::is_empty(folder_.path()));
  EXPECT_FALSE(HairCacheWriter::create(folder_ / "missing" / "a", good));

  auto writer = required(HairCacheWriter::create(folder_ / "a", good));
  auto frame = swing(good, 1, 0)[0];
  EXPECT_FALSE(writer->append(std::span(frame).first(2)));
  frame[3].z = std::numeric_limits<float>::infinity();
  EXPECT_FALSE(writer->append(frame));
  EXPECT_EQ(writer->frameCount(), 0u);
  ASSERT_TRUE(writer->close());
  EXPECT_FALSE(writer->close());
  frame[3].z = 0;
  EXPECT_FALSE(writer->append(frame));
}

// Opens a file in memory and reads all frames.
Result<void> readEverything(const Bytes& bytes) {
  auto reader = HairCacheReader::open(std::make_unique<MemorySource>(bytes), "memory");
  if (!reader) return reader.error();
  std::vector<Float3> out(reader->vertexCount());
  for (uint64_t f = 0; f < reader->frameCount(); ++f)
    if (auto r = reader->read(f, out); !r) return r;
  return {};
}

TEST_F(HairCache, EveryChangedByteAndEveryTruncationIsAnError) {
  const HairCacheDef def = defOf(false);
  const Bytes bytes = bytesOf(write(def, swing(def, 3, 0)));
  ASSERT_TRUE(readEverything(bytes));
  for (size_t i = 0; i < bytes.size(); ++i) {
    Bytes changed = bytes;
    changed[i] ^= std::byte{0x10};
    EXPECT_FALSE(readEverything(changed)) << "byte " << i;
    changed.resize(i);
    EXPECT_FALSE(readEverything(changed)) << i << " bytes";
  }
}

}  // namespace
}  // namespace pelage
