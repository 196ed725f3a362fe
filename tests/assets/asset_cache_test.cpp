// The cache of processed assets: bit for bit what was saved, and an error for everything else.
#include "pelage/asset_cache.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstring>
#include <filesystem>
#include <limits>
#include <string>
#include <vector>

#include "assets/asset_cache_format.h"
#include "assets/prepared_collider.h"
#include "base/hash.h"
#include "pelage/random.h"
#include "support/errors.h"
#include "support/not_numbers.h"
#include "support/test_folder.h"

namespace pelage {
namespace {

using detail::cache::Header;
using detail::cache::Kind;
using detail::cache::Section;
using Bytes = std::vector<std::byte>;
using test::expectError;
using test::expectHas;
using test::kNan;
using test::required;
using test::TestFolder;

// All arrays, reserved words, a gap before the positions and bytes after the last array.
HairAsset cachedAsset() {
  HairAsset asset;
  asset.strandCount = 3;
  asset.verticesPerStrand = 5;
  Random random(5);
  for (uint32_t s = 0; s < 3; ++s) {
    asset.strandUv.push_back({random.uniform(), -0.0f});
    asset.strandThickness.push_back(1 + random.uniform());
    for (uint32_t v = 0; v < 5; ++v) {
      asset.positions.push_back(
          {random.uniform(), 0.1f * static_cast<float>(v), random.uniform(), v < 2 ? 0.0f : 1.0f});
      asset.vertexUv.push_back({random.uniform(), 3});
      asset.vertexColor.push_back({random.uniform(), 0, 0, 1});
    }
  }
  Bytes file = *saveTfx(asset);
  file.insert(file.end(), 7, std::byte{9});
  file[100] = std::byte{77};
  asset = *loadTfx(file, "memory");
  asset.vertexCounts = {5, 2, 4};
  EXPECT_TRUE(asset.process());
  return asset;
}

CollisionMesh cachedTetrahedron() {
  CollisionMesh mesh;
  mesh.bones = {{1, "the head"}, {0, "neck"}};
  mesh.positions = {{0, 0, 0}, {0.1f, 0, 0}, {0, 0.1f, 0}, {0, 0, 0.1f}};
  mesh.normals = {{0, 0, 1}, {1, 0, 0}, {0, 1, 0}, {-0.0f, 0, -1}};
  mesh.influences.assign(4, {{0, 1, 0, 0}, {0.75f, 0.25f, 0, 0}});
  mesh.indices = {0, 2, 1, 0, 3, 2, 0, 1, 3, 1, 2, 3};
  mesh.repairedVertexCount = 1;
  return mesh;
}

AssetCache fullCache() {
  AssetCache cache;
  cache.sources = {{"hair.tfx", 123, 0xfedcba9876543210u}, {"options", 1, 2}};
  BoneWeights bones;
  bones.bones = {{0, "neck"}, {1, ""}};
  bones.strands.assign(3, {{1, 0, 0, 0}, {0.5f, 0.25f, 0, 0.25f}});
  bones.repairedStrandCount = 2;
  const HairAsset asset = cachedAsset();
  cache.hairs.push_back(
      {"long", asset, bones,
       *asset.generateFollowHairs({.countPerGuide = 2, .guidesPerHair = 3, .seed = 4})});
  HairAsset plain;
  plain.strandCount = 1;
  plain.verticesPerStrand = 2;
  plain.positions = {{0, 0, 0, 0}, {0, 0, 0, 0}};
  EXPECT_TRUE(plain.process());
  cache.hairs.push_back({"", plain, std::nullopt, {}});
  cache.meshes.push_back({"body", cachedTetrahedron()});
  CollisionMesh flat = cachedTetrahedron();
  flat.positions.assign(4, {1, 2, 3});  // no triangle is left
  cache.meshes.push_back({"flat", flat});
  return cache;
}

template <class T>
bool sameBits(const std::vector<T>& a, const std::vector<T>& b) {
  return a.size() == b.size() &&
         (a.empty() || std::memcmp(a.data(), b.data(), a.size() * sizeof(T)) == 0);
}

void expectSame(const CachedHair& a, const CachedHair& b) {
  EXPECT_EQ(a.name, b.name);
  EXPECT_EQ(a.asset.strandCount, b.asset.strandCount);
  EXPECT_EQ(a.asset.verticesPerStrand, b.asset.verticesPerStrand);
  EXPECT_TRUE(sameBits(a.asset.positions, b.asset.positions));
  EXPECT_TRUE(sameBits(a.asset.vertexCounts, b.asset.vertexCounts));
  EXPECT_TRUE(sameBits(a.asset.strandUv, b.asset.strandUv));
  EXPECT_TRUE(sameBits(a.asset.vertexUv, b.asset.vertexUv));
  EXPECT_TRUE(sameBits(a.asset.strandThickness, b.asset.strandThickness));
  EXPECT_TRUE(sameBits(a.asset.vertexColor, b.asset.vertexColor));
  EXPECT_TRUE(sameBits(a.asset.restLengths, b.asset.restLengths));
  EXPECT_TRUE(sameBits(a.asset.restFrames, b.asset.restFrames));
  EXPECT_TRUE(sameBits(a.asset.restVectors, b.asset.restVectors));
  EXPECT_TRUE(sameBits(a.asset.tangents, b.asset.tangents));
  EXPECT_TRUE(sameBits(a.asset.inverseMasses, b.asset.inverseMasses));
  EXPECT_TRUE(sameBits(a.asset.vertexThickness, b.asset.vertexThickness));
  EXPECT_EQ(a.asset.degenerateSegmentCount, b.asset.degenerateSegmentCount);
  EXPECT_EQ(*saveTfx(a.asset), *saveTfx(b.asset));
  ASSERT_EQ(a.bones.has_value(), b.bones.has_value());
  if (a.bones) {
    EXPECT_EQ(a.bones->bones, b.bones->bones);
    EXPECT_TRUE(sameBits(a.bones->strands, b.bones->strands));
    EXPECT_EQ(a.bones->repairedStrandCount, b.bones->repairedStrandCount);
  }
  EXPECT_TRUE(sameBits(a.followHairs, b.followHairs));
}

void expectSame(const CachedMesh& a, const CachedMesh& b) {
  EXPECT_EQ(a.name, b.name);
  EXPECT_EQ(a.mesh.bones, b.mesh.bones);
  EXPECT_TRUE(sameBits(a.mesh.positions, b.mesh.positions));
  EXPECT_TRUE(sameBits(a.mesh.normals, b.mesh.normals));
  EXPECT_TRUE(sameBits(a.mesh.influences, b.mesh.influences));
  EXPECT_TRUE(sameBits(a.mesh.indices, b.mesh.indices));
  EXPECT_EQ(a.mesh.repairedVertexCount, b.mesh.repairedVertexCount);
}

Header headerOf(const Bytes& bytes) {
  Header header;
  std::memcpy(&header, bytes.data(), sizeof(header));
  return header;
}

std::vector<Section> tableOf(const Bytes& bytes) {
  std::vector<Section> table(headerOf(bytes).sectionCount);
  std::memcpy(table.data(), bytes.data() + sizeof(Header), table.size() * sizeof(Section));
  return table;
}

// A file that somebody changed on purpose, checksums included.
void seal(Bytes& bytes) {
  std::vector<Section> table = tableOf(bytes);
  for (Section& section : table)
    section.checksum =
        detail::hash64(std::span<const std::byte>(bytes).subspan(section.offset, section.size));
  std::memcpy(bytes.data() + sizeof(Header), table.data(), table.size() * sizeof(Section));
  const size_t end = sizeof(Header) + table.size() * sizeof(Section);
  const uint64_t checksum =
      detail::cache::headerChecksum(std::span<const std::byte>(bytes).first(end));
  std::memcpy(bytes.data() + offsetof(Header, checksum), &checksum, sizeof(checksum));
}

TEST(AssetCache, GivesBackEveryBitThatWasSaved) {
  const AssetCache cache = fullCache();
  const auto bytes = required(saveAssetCache(cache));
  const auto loaded = required(loadAssetCache(*bytes, "memory"));
  EXPECT_EQ(loaded->sources, cache.sources);
  ASSERT_EQ(loaded->hairs.size(), cache.hairs.size());
  for (size_t i = 0; i < cache.hairs.size(); ++i) expectSame(loaded->hairs[i], cache.hairs[i]);
  ASSERT_EQ(loaded->meshes.size(), cache.meshes.size());
  for (size_t i = 0; i < cache.meshes.size(); ++i) expectSame(loaded->meshes[i], cache.meshes[i]);
  EXPECT_EQ(*saveAssetCache(*loaded), *bytes);
  const TestFolder folder;
  required(saveAssetCache(cache, folder / "cache"));
  EXPECT_EQ(test::bytesOf(folder / "cache"), *bytes);
  EXPECT_TRUE(loadAssetCache(folder / "cache"));

  const auto empty = required(saveAssetCache({}));
  EXPECT_EQ(empty->size(), sizeof(Header));
  EXPECT_TRUE(loadAssetCache(*empty, "empty"));
}

TEST(AssetCache, KeepsTheTopologyOfColliders) {
  const auto loaded = required(loadAssetCache(*saveAssetCache(fullCache()), "memory"));
  for (const CachedMesh& cached : loaded->meshes) {
    ASSERT_TRUE(detail::isPrepared(cached.mesh));
    const detail::ColliderTopology& kept = cached.mesh.prepared->topology;
    const auto fresh =
        required(detail::makeColliderTopology(cached.mesh.indices, 4, cached.mesh.positions));
    EXPECT_EQ(kept.report, fresh->report);
    EXPECT_EQ(kept.indices, fresh->indices);
    EXPECT_EQ(kept.sourceTriangles, fresh->sourceTriangles);
    EXPECT_EQ(kept.adjacency, fresh->adjacency);
    EXPECT_EQ(kept.weldedVertices, fresh->weldedVertices);
    EXPECT_EQ(kept.pointVertices, fresh->pointVertices);
    EXPECT_EQ(kept.pointOffsets, fresh->pointOffsets);
    EXPECT_EQ(kept.pointCorners, fresh->pointCorners);
  }
  // A mesh that was changed since does without.
  CollisionMesh changed = loaded->meshes[0].mesh;
  std::swap(changed.indices[0], changed.indices[1]);
  EXPECT_FALSE(detail::isPrepared(changed));
  changed = loaded->meshes[0].mesh;
  changed.positions[2] = changed.positions[1];
  EXPECT_FALSE(detail::isPrepared(changed));
  EXPECT_EQ(detail::topologyOf(changed)->pointCount(), 3u);
  ASSERT_TRUE(prepareCollider(changed));
  EXPECT_TRUE(detail::isPrepared(changed));
}

TEST(AssetCache, RefusesEveryTruncationWithTheByte) {  // K23
  const Bytes bytes = *saveAssetCache(fullCache());
  for (size_t size = 0; size < bytes.size(); ++size) {
    const Bytes part(bytes.begin(), bytes.begin() + static_cast<std::ptrdiff_t>(size));
    expectError(loadAssetCache(part, "cut"), ErrorCode::kInvalidFile,
                {"cut: byte " + std::to_string(size)});
  }
  Bytes longer = bytes;
  longer.push_back(std::byte{0});
  EXPECT_FALSE(loadAssetCache(longer, "long"));
}

TEST(AssetCache, RefusesEveryFlippedByteAndNamesItsSection) {
  const Bytes good = *saveAssetCache(fullCache());
  const std::vector<Section> table = tableOf(good);
  const size_t tableEnd = sizeof(Header) + table.size() * sizeof(Section);
  for (size_t at = 0; at < good.size(); ++at) {
    for (const int bit : {0, 7}) {
      Bytes bytes = good;
      bytes[at] ^= static_cast<std::byte>(1 << bit);
      const auto loaded = loadAssetCache(bytes, "flipped");
      expectError(loaded, "flipped: byte ");
      if (at < tableEnd) continue;
      const auto section = std::find_if(table.begin(), table.end(), [&](const Section& s) {
        return at >= s.offset && at < s.offset + s.size;
      });
      expectError(loaded, {"byte " + std::to_string(section->offset) + ": section '", "checksum"});
    }
  }
}

TEST(AssetCache, RefusesOtherVersionsAndFilesInPlainWords) {
  const Bytes good = *saveAssetCache(fullCache());
  const auto changed = [&](size_t at, uint32_t value) {
    Bytes bytes = good;
    std::memcpy(bytes.data() + at, &value, sizeof(value));
    seal(bytes);
    return loadAssetCache(bytes, "old").error().message;
  };
  EXPECT_EQ(changed(offsetof(Header, version), 7),
            "old: byte 8: the cache has version 7, but this library reads 1; make it again from "
            "its sources");
  expectHas(changed(offsetof(Header, byteOrder), 0x0d0c0b0a), "byte order");
  expectHas(changed(0, 0), "no .pelage file");
}

TEST(AssetCache, RefusesWrongContentsWithRightChecksums) {
  const Bytes good = *saveAssetCache(fullCache());
  const std::vector<Section> table = tableOf(good);
  const auto refused = [&](Kind kind, uint64_t at, auto value, const char* text) {
    const auto section = std::find_if(table.begin(), table.end(), [&](const Section& s) {
      return s.kind == static_cast<uint32_t>(kind) && s.item == 0;
    });
    ASSERT_NE(section, table.end()) << text;
    Bytes bytes = good;
    ASSERT_LE(at + sizeof(value), section->size);
    std::memcpy(bytes.data() + section->offset + at, &value, sizeof(value));
    seal(bytes);
    expectError(loadAssetCache(bytes, "wrong"), {text, "wrong: byte "});
  };
  refused(Kind::kPositions, 20, kNan, "'positions' of hair 0: a number is nan");
  refused(Kind::kPositions, 12, -1.0f, "a number is -1");
  refused(Kind::kVertexColor, 4, kNan, "'vertex colors'");
  refused(Kind::kRestFrames, 0, 4.0f, "no rotation");
  refused(Kind::kRestFrames, 0, kNan, "no rotation");
  refused(Kind::kStrandUv, 0, kNan, "'strand UV'");
  refused(Kind::kVertexUv, 0, kNan, "'vertex UV'");
  refused(Kind::kVertexCounts, 4, 1u, "strand 1 has 1 vertices");
  refused(Kind::kVertexCounts, 4, 6u, "strand 1 has 6 vertices");
  refused(Kind::kStrandThickness, 0, -1.0f, "'strand thickness'");
  refused(Kind::kRestLengths, 8, -1.0f, "'rest lengths'");
  refused(Kind::kRestVectors, 8, kNan, "'rest vectors'");
  refused(Kind::kTangents, 0, 2.0f, "'tangents'");
  refused(Kind::kInverseMasses, 0, kNan, "'inverse masses'");
  refused(Kind::kVertexThickness, 0, kNan, "'vertex thickness'");
  refused(Kind::kStrandBones, 0, 2u, "'bone weights' of hair 0");
  refused(Kind::kStrandBones, 16, kNan, "'bone weights' of hair 0");
  refused(Kind::kHairBones, 0, 5u, "'bone names' of hair 0");
  refused(Kind::kHairBones, 4, 1000u, "a name is too long");
  refused(Kind::kFollowHairs, 0, 3u, "a guide does not exist");
  refused(Kind::kFollowHairs, 4, kNan, "an offset is out of range");
  refused(Kind::kFollowHairs, 28, 2.0f, "weights");
  refused(Kind::kMeshPositions, 0, kNan, "'positions' of mesh 0");
  refused(Kind::kMeshNormals, 0, kNan, "'normals' of mesh 0");
  refused(Kind::kMeshInfluences, 0, 2u, "'bone weights' of mesh 0");
  refused(Kind::kMeshIndices, 0, 4u, "'indices' of mesh 0: a number is 4; it must be below 4");
  refused(Kind::kUsedIndices, 0, 4u, "'used indices'");
  refused(Kind::kSourceTriangles, 0, 4u, "'source triangles'");
  refused(Kind::kAdjacency, 0, 4u, "'adjacency'");
  refused(Kind::kWeldedVertices, 0, 4u, "'welded vertices'");
  refused(Kind::kPointVertices, 0, 4u, "'vertices of points'");
  refused(Kind::kPointCorners, 0, 12u, "'corners of points'");
  refused(Kind::kPointOffsets, 4, 13u, "'offsets of points'");
  refused(Kind::kTopologyInfo, 56, std::numeric_limits<double>::infinity(), "'topology' of mesh 0");
  refused(Kind::kSources, 16, 5000u, "section 'sources'");
  // Counts that no section fits, and layouts that would make saveTfx() take any amount of memory.
  refused(Kind::kHairInfo, 0, 4u, "elements of");
  refused(Kind::kHairInfo, 0, 0xffffffffu, "elements of");
  refused(Kind::kHairInfo, 4, 257u, "2 to 256");
  refused(Kind::kHairInfo, 8, 0xffffffffu, "out of range");
  refused(Kind::kHairInfo, 12, 0u, "no bones");
  refused(Kind::kHairInfo, 40, uint64_t{1} << 40, "layout of another .tfx file");
  refused(Kind::kMeshInfo, 0, 5u, "elements of");
  refused(Kind::kMeshInfo, 4, 0u, "out of range");
}

TEST(AssetCache, RefusesToSaveWhatItWouldNotLoad) {
  const auto refused = [](const char* text, auto change) {
    AssetCache cache = fullCache();
    change(cache);
    expectError(saveAssetCache(cache), ErrorCode::kInvalidArgument, {text});
  };
  refused("hair 0 ('long'): call process()",
          [](AssetCache& c) { c.hairs[0].asset.restLengths.clear(); });
  refused("tangents: 14 elements instead of 15",
          [](AssetCache& c) { c.hairs[0].asset.tangents.pop_back(); });
  refused("rest frames", [](AssetCache& c) { c.hairs[0].asset.restFrames[3] = {0, 0, 0, 0}; });
  refused("strand 0, vertex 1", [](AssetCache& c) { c.hairs[0].asset.positions[1].x = kNan; });
  refused("bone weights for 2", [](AssetCache& c) { c.hairs[0].bones->strands.pop_back(); });
  refused("follow hairs", [](AssetCache& c) { c.hairs[0].followHairs[1].guide = 3; });
  refused("mesh 0 ('body'): indices", [](AssetCache& c) { c.meshes[0].mesh.indices[1] = 4; });
  refused("repairedStrandCount", [](AssetCache& c) { c.hairs[0].bones->repairedStrandCount = 4; });
  refused("repairedVertexCount", [](AssetCache& c) { c.meshes[0].mesh.repairedVertexCount = 5; });
  refused("3 normals", [](AssetCache& c) { c.meshes[0].mesh.normals.pop_back(); });
  refused("bone names", [](AssetCache& c) { c.meshes[0].mesh.bones.clear(); });
  refused("more than 4095 bytes", [](AssetCache& c) { c.meshes[0].name.assign(5000, 'x'); });
}

TEST(AssetCache, ATableThatALyingStreamHasRoomForTakesNoMemory) {
  // 200 GB of table in a stream that says that it has them.
  class Liar final : public ByteSource {
   public:
    Header header;
    uint64_t size() override { return header.fileSize; }
    size_t read(uint64_t offset, std::span<std::byte> out) override {
      if (offset + out.size() > sizeof(header)) return 0;
      std::memcpy(out.data(), reinterpret_cast<const std::byte*>(&header) + offset, out.size());
      return out.size();
    }
  } liar;
  liar.header.fileSize = uint64_t{1} << 50;
  liar.header.sectionCount = 0xffffffffu;
  expectError(loadAssetCache(liar, "stream"), "sections do not fit");
}

// Counts the bytes that are read.
class CountingSource final : public ByteSource {
 public:
  explicit CountingSource(const Bytes& bytes) : memory_(bytes) {}
  uint64_t size() override { return memory_.size(); }
  size_t read(uint64_t offset, std::span<std::byte> out) override {
    ascending = ascending && offset >= end_;
    const size_t count = memory_.read(offset, out);
    end_ = offset + count;
    bytesRead += count;
    return count;
  }
  uint64_t bytesRead = 0;
  bool ascending = true;

 private:
  MemorySource memory_;
  uint64_t end_ = 0;
};

TEST(AssetCache, ReadsAStreamFromTheStartToTheEndOnce) {
  const Bytes bytes = *saveAssetCache(fullCache());
  CountingSource source(bytes);
  ASSERT_TRUE(loadAssetCache(source, "stream"));
  EXPECT_TRUE(source.ascending);
  EXPECT_EQ(source.bytesRead, bytes.size());
}

TEST(AssetCache, TellsWhetherItsSourcesHaveChangedWithoutReadingTheAssets) {
  const TestFolder folder;
  const auto path = folder.write("source", "first");
  AssetCache cache = fullCache();
  cache.sources = {*sourceKeyOf(path)};
  EXPECT_EQ(cache.sources[0].size, 5u);
  cache.sources[0].name = path.filename().string();
  const Bytes bytes = *saveAssetCache(cache);

  CountingSource source(bytes);
  const auto sources = required(loadAssetCacheSources(source, "stream"));
  EXPECT_EQ(*sources, cache.sources);
  EXPECT_EQ(source.bytesRead, sizeof(Header) + tableOf(bytes).size() * sizeof(Section) + 8 + 8 + 4 +
                                  cache.sources[0].name.size());

  EXPECT_FALSE(findStaleSource(*sources, folder.path()));
  (void)folder.write("source", "fIrst");
  ASSERT_TRUE(findStaleSource(*sources, folder.path()));
  EXPECT_EQ(findStaleSource(*sources, folder.path())->name, cache.sources[0].name);
  std::filesystem::remove(path);
  EXPECT_TRUE(findStaleSource(*sources, folder.path()));
  // As published for XXH3_64bits() of no bytes and seed 0.
  EXPECT_EQ(sourceKeyOf(std::span<const std::byte>(), "").hash, 0x2d06800538d394c2u);
}

}  // namespace
}  // namespace pelage
