// Loaders that read from streams: files, memory, an engine's functions; and from streams that fail.
#include "pelage/stream.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cstring>
#include <filesystem>
#include <functional>
#include <limits>
#include <stdexcept>
#include <string>
#include <vector>

#include "pelage/bone_weights.h"
#include "pelage/collision_mesh.h"
#include "pelage/hair_asset.h"
#include "pelage/sdf_collider.h"
#include "pelage/skin_table.h"
#include "support/errors.h"
#include "support/not_numbers.h"
#include "support/test_folder.h"

namespace pelage {
namespace {

using Bytes = std::vector<std::byte>;
using test::bytesOf;
using test::expectError;
using test::kNan;
using test::required;
using test::TestFolder;

// Memory that counts how often each byte is read, gives at most `atMost` bytes a read, fails from
// `failFrom` on, and may say another size than it has.
class TestSource final : public ByteSource {
 public:
  explicit TestSource(Bytes bytes) : counts(bytes.size()), bytes_(std::move(bytes)) {
    claimedSize = bytes_.size();
  }

  uint64_t size() override { return claimedSize; }
  size_t read(uint64_t offset, std::span<std::byte> out) override {
    const uint64_t end = std::min<uint64_t>(bytes_.size(), failFrom);
    if (offset >= end) return 0;
    const size_t count = std::min<uint64_t>({out.size(), end - offset, atMost});
    std::memcpy(out.data(), bytes_.data() + offset, count);
    for (size_t i = 0; i < count; ++i) ++counts[offset + i];
    return count;
  }
  uint64_t bytesRead() const {
    return static_cast<uint64_t>(
        std::count_if(counts.begin(), counts.end(), [](int n) { return n > 0; }));
  }
  bool readNothingTwice() const {
    return std::all_of(counts.begin(), counts.end(), [](int n) { return n <= 1; });
  }

  uint64_t claimedSize = 0, atMost = ~uint64_t{0}, failFrom = ~uint64_t{0};
  std::vector<int> counts;

 private:
  Bytes bytes_;
};

constexpr uint32_t kStrands = 6, kVertices = 4;

HairAsset fullAsset() {
  HairAsset asset;
  asset.strandCount = kStrands;
  asset.verticesPerStrand = kVertices;
  for (uint32_t s = 0; s < kStrands; ++s) {
    asset.strandUv.push_back({static_cast<float>(s), 0.5f});
    asset.strandThickness.push_back(1 + static_cast<float>(s));
    for (uint32_t v = 0; v < kVertices; ++v) {
      asset.positions.push_back({static_cast<float>(s), static_cast<float>(v), 0, 1});
      asset.vertexUv.push_back({static_cast<float>(v), static_cast<float>(s)});
      asset.vertexColor.push_back({1, 0, static_cast<float>(s), 1});
    }
  }
  return asset;
}

Bytes tfxFile() { return *saveTfx(fullAsset()); }

Bytes boneFile() {
  BoneWeights weights;
  weights.bones = {{0, "neck"}, {1, "head"}};
  weights.strands.assign(kStrands, {{0, 1, 0, 0}, {0.5f, 0.5f, 0, 0}});
  return *saveTfxBone(weights);
}

Bytes meshFile() {
  CollisionMesh mesh;
  mesh.bones = {{0, "neck"}};
  mesh.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
  mesh.normals.assign(3, {0, 0, 1});
  mesh.influences.assign(3, {{0, 0, 0, 0}, {1, 0, 0, 0}});
  mesh.indices = {0, 1, 2};
  const std::string text = *saveTfxMesh(mesh);
  const auto bytes = std::as_bytes(std::span(text));
  return {bytes.begin(), bytes.end()};
}

Bytes followFile() {
  const std::vector<FollowHair> hairs = {{.guide = 1, .offset = {0, 0, 0.01f, 1}}};
  return *saveFollowHairs(hairs, 2);
}

Bytes skinFile() {
  SkinTable table;
  table.parts = {{"body", "mesh", "skin", 3, 1}};
  table.roots = {{.corners = {0, 1, 2},
                  .barycentric = {0.5f, 0.25f, 0.25f},
                  .offset = {0, 0, 0},
                  .bind = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}}};
  return *saveTfxSkin(table);
}

Bytes sdfFile() {
  SdfData field;
  field.grid = {.origin = {0, 0, 0}, .cellSize = 0.1f, .nodes = {4, 1, 1}};
  field.triangleBits = 1;
  field.keys.assign(4, 0x7fffffffu);
  const TestFolder folder;
  EXPECT_TRUE(saveSdf(field, folder / "field"));
  return bytesOf(folder / "field");
}

// A loader as a function of a stream that gives an error's text, or nothing.
struct Format {
  const char* name;
  Bytes file;
  std::function<std::string(ByteSource&)> load;
};

std::vector<Format> formats() {
  const auto of = [](auto loader) {
    return [loader](ByteSource& source) {
      const auto loaded = loader(source);
      return loaded ? std::string() : loaded.error().message;
    };
  };
  return {{"tfx", tfxFile(), of([](ByteSource& s) { return loadTfx(s, "stream"); })},
          {"tfxbone", boneFile(), of([](ByteSource& s) { return loadTfxBone(s, "stream"); })},
          {"tfxmesh", meshFile(), of([](ByteSource& s) { return loadTfxMesh(s, "stream"); })},
          {"tfxfollow", followFile(),
           of([](ByteSource& s) { return loadFollowHairs(s, "stream", 0); })},
          {"tfxskin", skinFile(), of([](ByteSource& s) { return loadTfxSkin(s, "stream"); })},
          {"psdf", sdfFile(), of([](ByteSource& s) { return loadSdf(s, "stream"); })}};
}

TEST(Stream, FilesMemoryAndCallbacksGiveTheSameBytes) {
  const Bytes bytes = tfxFile();
  const TestFolder folder;
  ASSERT_TRUE(saveTfx(fullAsset(), folder / "hair"));
  auto file = required(FileSource::open(folder / "hair"));
  MemorySource memory(bytes);
  uint64_t at = 0;
  CallbackSource callbacks(
      {.size = [&] { return bytes.size(); },
       .seek =
           [&](uint64_t offset) {
             at = offset;
             return true;
           },
       .read =
           [&](std::span<std::byte> out) {
             const size_t count = std::min<uint64_t>({out.size(), bytes.size() - at, 100});
             std::copy_n(bytes.begin() + static_cast<std::ptrdiff_t>(at), count, out.begin());
             at += count;
             return count;
           }});
  for (ByteSource* source : {static_cast<ByteSource*>(&*file), static_cast<ByteSource*>(&memory),
                             static_cast<ByteSource*>(&callbacks)}) {
    EXPECT_EQ(*readAll(*source, "all"), bytes);
    const auto loaded = loadTfx(*source, "again");  // goes back to the start
    ASSERT_TRUE(loaded) << loaded.error().message;
    EXPECT_EQ(*saveTfx(*loaded), bytes);
    std::array<std::byte, 4> word;
    ASSERT_EQ(source->read(4, word), word.size());
    EXPECT_TRUE(std::equal(word.begin(), word.end(), bytes.begin() + 4));
  }
}

TEST(Stream, MissingFilesAndFoldersAreErrorsThatNameThem) {
  expectError(FileSource::open("/nonexistent/hair.tfx"), ErrorCode::kFileNotFound,
              "/nonexistent/hair.tfx");
  EXPECT_FALSE(FileSource::open(std::filesystem::temp_directory_path()));
}

TEST(Stream, EveryLoaderReadsEachByteOnceEvenWhenReadsAreShort) {
  for (const Format& format : formats()) {
    for (const uint64_t atMost : {uint64_t{1}, uint64_t{7}, ~uint64_t{0}}) {
      TestSource source(format.file);
      source.atMost = atMost;
      EXPECT_EQ(format.load(source), "") << format.name;
      EXPECT_EQ(source.bytesRead(), format.file.size()) << format.name;
      EXPECT_TRUE(source.readNothingTwice()) << format.name;
    }
  }
}

TEST(Stream, AReadThatFailsAtAnyByteIsAnErrorWithThatByte) {
  for (const Format& format : formats()) {
    for (uint64_t failFrom = 0; failFrom < format.file.size(); ++failFrom) {
      TestSource source(format.file);
      source.failFrom = failFrom;
      const std::string error = format.load(source);
      ASSERT_NE(error.find("stream: byte " + std::to_string(failFrom) + ": reading failed"),
                std::string::npos)
          << format.name << " " << failFrom << ": " << error;
    }
  }
}

TEST(Stream, SizesThatLieAreErrorsAndTakeNoMemory) {
  for (const Format& format : formats()) {
    for (const uint64_t size :
         {uint64_t{0}, format.file.size() - 2, format.file.size() + 1, uint64_t{1} << 40,
          uint64_t{1} << 62, std::numeric_limits<uint64_t>::max()}) {
      TestSource source(format.file);
      source.claimedSize = size;
      // A machine that tried to reserve 2^40 bytes would throw, which reads "out of memory".
      const std::string error = format.load(source);
      ASSERT_NE(error, "") << format.name << " " << size;
      ASSERT_NE(error.find("stream:"), std::string::npos) << format.name << ": " << error;
    }
  }
  // A header that fits the lie.
  Bytes huge = tfxFile();
  const uint32_t strands = 0xfffffff0u;
  std::memcpy(huge.data() + 4, &strands, sizeof(strands));
  for (size_t at = 16; at < 32; ++at) huge[at] = std::byte{0};
  TestSource source(huge);
  source.claimedSize = uint64_t{1} << 50;
  expectError(loadTfx(source, "stream"), "reading failed");
}

TEST(Stream, ASourceThatSaysItReadMoreThanAskedIsAnError) {
  class Liar final : public ByteSource {
   public:
    uint64_t size() override { return 1000; }
    size_t read(uint64_t, std::span<std::byte> out) override { return out.size() + 1; }
  } liar;
  expectError(readAll(liar, "liar"), "liar: byte 0: ");
}

TEST(Stream, CallbacksThatThrowOrCannotSeekAreErrors) {
  CallbackSource thrower(
      {.size = [] { return uint64_t{1000}; },
       .seek = [](uint64_t) { return true; },
       .read = [](std::span<std::byte>) -> size_t { throw std::runtime_error("archive closed"); }});
  for (const Format& format : formats()) {
    const std::string error = format.load(thrower);
    EXPECT_NE(error.find("archive closed"), std::string::npos) << format.name << ": " << error;
  }
  CallbackSource fixed({.size = [] { return uint64_t{1000}; },
                        .seek = [](uint64_t) { return false; },
                        .read = [](std::span<std::byte> out) { return out.size(); }});
  expectError(readAll(fixed, "fixed"), "fixed: byte 0: reading failed");
}

// ---- parts of a .tfx file

TEST(TfxParts, TheFirstStrandsAreThoseOfTheWholeFileAndOnlyTheirBytesAreRead) {
  const HairAsset whole = fullAsset();
  for (uint32_t count = 1; count <= kStrands; ++count) {
    TestSource source(tfxFile());
    const auto part = required(loadTfx(source, "part", {.maxStrands = count}));
    EXPECT_EQ(part->strandCount, count);
    const auto isStart = [](const auto& a, const auto& b, size_t size) {
      return a.size() == size && std::equal(a.begin(), a.end(), b.begin());
    };
    EXPECT_TRUE(isStart(part->positions, whole.positions, count * kVertices));
    EXPECT_TRUE(isStart(part->strandUv, whole.strandUv, count));
    EXPECT_TRUE(isStart(part->vertexUv, whole.vertexUv, count * kVertices));
    EXPECT_TRUE(isStart(part->strandThickness, whole.strandThickness, count));
    EXPECT_TRUE(isStart(part->vertexColor, whole.vertexColor, count * kVertices));
    // Header; 16 + 8 + 16 bytes a vertex, 8 + 4 a strand.
    EXPECT_EQ(source.bytesRead(), 160u + count * (kVertices * 40 + 12));
    EXPECT_TRUE(source.readNothingTwice());
  }
}

TEST(TfxParts, ArraysThatAreNotWantedAreNotRead) {
  TestSource source(tfxFile());
  const auto part = required(loadTfx(
      source, "part",
      {.strandUv = false, .vertexUv = false, .strandThickness = false, .vertexColor = false}));
  EXPECT_EQ(part->positions, fullAsset().positions);
  EXPECT_TRUE(part->strandUv.empty() && part->vertexUv.empty() && part->strandThickness.empty() &&
              part->vertexColor.empty());
  EXPECT_EQ(source.bytesRead(), 160u + kStrands * kVertices * 16);

  const auto thickness = required(
      loadTfx(tfxFile(), "part", {.strandUv = false, .vertexUv = false, .vertexColor = false}));
  EXPECT_EQ(thickness->strandThickness, fullAsset().strandThickness);
}

TEST(TfxParts, APartIsSavedAsAFileOfItsOwn) {
  auto part = required(loadTfx(tfxFile(), "part", {.maxStrands = 2, .vertexColor = false}));
  const auto bytes = required(saveTfx(*part));
  EXPECT_EQ(bytes->size(), 160u + 2 * (kVertices * 24 + 12));
  const auto again = required(loadTfx(*bytes, "again"));
  EXPECT_EQ(again->positions, part->positions);
  EXPECT_TRUE(part->process());
}

TEST(TfxParts, WhatIsNotReadIsNotJudgedButArraysThatLeaveTheFileAre) {
  Bytes bytes = tfxFile();
  const size_t lastVertex = 160 + (kStrands * kVertices - 1) * 16;
  std::memcpy(bytes.data() + lastVertex, &kNan, sizeof(kNan));
  EXPECT_FALSE(loadTfx(bytes, "whole"));
  EXPECT_TRUE(loadTfx(bytes, "part", {.maxStrands = kStrands - 1}));
  bytes.pop_back();
  expectError(loadTfx(bytes, "cut", {.maxStrands = 1}), "file ends");
  expectError(loadTfx(tfxFile(), "none", {.maxStrands = 0}), "maxStrands");
}

}  // namespace
}  // namespace pelage
