// Writes the corpus: small files of each format that are valid and have all of its parts. Their
// names start with "valid"; what the fuzzers find goes beside them under other names.
#include <array>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <span>
#include <string>

#include "pelage/asset_cache.h"
#include "pelage/authoring/hair_files.h"
#include "pelage/hair_asset.h"
#include "pelage/hair_cache.h"
#include "pelage/sdf_collider.h"
#include "pelage/skin_table.h"

namespace {

using namespace pelage;

std::filesystem::path folderOf(const std::filesystem::path& root, const char* target) {
  std::filesystem::create_directories(root / target);
  return root / target;
}

void write(const std::filesystem::path& path, std::string_view text) {
  std::ofstream(path, std::ios::binary) << text;
}
void write(const std::filesystem::path& path, const std::vector<std::byte>& bytes) {
  write(path, std::string_view(reinterpret_cast<const char*>(bytes.data()), bytes.size()));
}

HairAsset makeAsset(bool full) {
  HairAsset asset;
  asset.strandCount = 2;
  asset.verticesPerStrand = 3;
  for (uint32_t s = 0; s < 2; ++s) {
    for (uint32_t v = 0; v < 3; ++v) {
      const float t = 0.1f * static_cast<float>(v);
      asset.positions.push_back({static_cast<float>(s), t, t * t, v < 2 ? 0.0f : 1.0f});
      if (full) asset.vertexUv.push_back({t, 0.5f});
      if (full) asset.vertexColor.push_back({1, t, 0, 1});
    }
    if (full) asset.strandUv.push_back({0.25f, static_cast<float>(s)});
    if (full) asset.strandThickness.push_back(1 + static_cast<float>(s));
  }
  return asset;
}

BoneWeights makeWeights() {
  BoneWeights weights;
  weights.bones = {{1, "head"}, {0, "neck"}};
  weights.strands = {{{0, 1, 0, 0}, {0.5f, 0.5f, 0, 0}}, {{1, 0, 0, 0}, {1, 0, 0, 0}}};
  return weights;
}

CollisionMesh makeMesh() {
  CollisionMesh mesh;
  mesh.bones = {{0, "neck"}, {1, "the head"}};
  mesh.positions = {{0, 0, 0}, {0.5f, 0, 0}, {0, 0.5f, 0}, {0, 0, 0.5f}};
  mesh.normals = {{0, 0, 1}, {1, 0, 0}, {0, 1, 0}, {0, 0, -1}};
  mesh.influences.assign(4, {{0, 1, 0, 0}, {0.75f, 0.25f, 0, 0}});
  mesh.indices = {0, 2, 1, 0, 3, 2, 0, 1, 3, 1, 2, 3};
  return mesh;
}

std::vector<FollowHair> makeFollowHairs() {
  return {{.guide = 0, .offset = {0.001f, 0, 0, 1}},
          {.guide = 1,
           .offset = {0, 0.001f, 0, 0.5f},
           .otherGuides = {0, 1},
           .otherWeights = {0.25f, 0.125f}}};
}

HairCurves makeCurves() {
  HairCurves curves;
  curves.vertexCounts = {3, 2};
  curves.positions = {{0, 0, 0}, {0, 0.1f, 0}, {0, 0.2f, 0.1f}, {1, 0, 0}, {1, 0.5f, 0}};
  curves.radii = {1e-4f, 1e-4f, 0, 1e-4f, 0};
  curves.colors.assign(5, {1, 0.5f, 0, 1});
  curves.vertexUv.assign(5, {0.5f, 0.25f});
  return curves;
}

// A bone that is translated (linear), one below it that is rotated (steps) and scaled (cubic). The
// buffer has the times 0 and 1, then two translations; the others share its zeros and ones.
std::string animationText() {
  return R"({"asset":{"version":"2.0"},"nodes":[{"name":"a","children":[1],"scale":[1,2,1]},)"
         R"({"rotation":[0,0,0,1]}],"animations":[{"name":"turn","channels":[)"
         R"({"sampler":0,"target":{"node":0,"path":"translation"}},)"
         R"({"sampler":1,"target":{"node":1,"path":"rotation"}},)"
         R"({"sampler":2,"target":{"node":1,"path":"scale"}}],"samplers":[)"
         R"({"input":0,"output":1},{"input":0,"output":2,"interpolation":"STEP"},)"
         R"({"input":0,"output":3,"interpolation":"CUBICSPLINE"}]}],"accessors":[)"
         R"({"bufferView":0,"componentType":5126,"count":2,"type":"SCALAR"},)"
         R"({"bufferView":0,"componentType":5126,"count":2,"type":"VEC3"},)"
         R"({"bufferView":0,"componentType":5126,"count":2,"type":"VEC4"},)"
         R"({"bufferView":0,"componentType":5126,"count":6,"type":"VEC3"}],)"
         R"("bufferViews":[{"buffer":0,"byteLength":72}],"buffers":[{"byteLength":72,)"
         R"("uri":"data:application/octet-stream;base64,)"
         R"(AAAAAAAAgD8AAAAAAACAPwAAAAAAAIA/AAAAAAAAgD8AAAAAAACAPwAAAAAAAIA/)"
         R"(AAAAAAAAgD8AAAAAAACAPwAAAAAAAIA/"}]})";
}

// Three frames of two strands: a key frame and those that it predicts.
bool writeHairCache(const std::filesystem::path& path, HairCacheDef def) {
  auto writer = HairCacheWriter::create(path, std::move(def));
  if (!writer) return false;
  for (int f = 0; f < 3; ++f) {
    const float t = 0.1f * static_cast<float>(f);
    const std::vector<Float3> frame = {
        {0, t, 0}, {0, t, 0.1f}, {0.01f, t, 0.2f}, {1, t, 0}, {1, t, t}};
    if (!writer->append(frame)) return false;
  }
  return writer->close().ok();
}

// Two samples of two points, two frames apart.
std::vector<std::byte> pointCache() {
  std::vector<std::byte> bytes;
  const auto put = [&](const auto& value) {
    const auto part = std::as_bytes(std::span(&value, 1));
    bytes.insert(bytes.end(), part.begin(), part.end());
  };
  put(std::array<char, 12>{'P', 'O', 'I', 'N', 'T', 'C', 'A', 'C', 'H', 'E', '2', '\0'});
  put(std::array<int32_t, 2>{1, 2});
  put(std::array<float, 2>{1, 2});
  put(int32_t{2});
  put(std::array<float, 12>{0, 0, 0, 1, 0, 0, 0, 4, 0, 1, 0, -8});
  return bytes;
}

int makeCorpus(const std::filesystem::path& root) {
  write(folderOf(root, "tfx") / "valid_plain.tfx", *saveTfx(makeAsset(false)));
  auto full = *saveTfx(makeAsset(true));
  write(folderOf(root, "tfx") / "valid_full.tfx", full);
  full.resize(full.size() + 5, std::byte{1});
  write(folderOf(root, "tfx") / "valid_extra_bytes.tfx", full);

  write(folderOf(root, "tfxbone") / "valid.tfxbone", *saveTfxBone(makeWeights()));
  write(folderOf(root, "tfxmesh") / "valid.tfxmesh", *saveTfxMesh(makeMesh()));
  write(folderOf(root, "tfxmesh") / "valid_crlf.tfxmesh",
        "# any order\r\nnumOfBones 1\r\n0 a b\r\nnumOfVertices 3\r\n"
        "2 +1 1e-50 0 0 0 1 0 0 0 0 0 0 0 0\r\n0 0 0 0 0 0 1 0 0 0 0 1 0 0 0\r\n"
        "1 0 1 0 0 0 1 0 0 0 0 1 0 0 0\r\nnumOfTriangles 1\r\n0 0 1 2");
  write(folderOf(root, "tfxfollow") / "valid.tfxfollow", *saveFollowHairs(makeFollowHairs(), 2));

  SkinTable table;
  table.parts = {{"body", "mesh", "skin", 3, 1}};
  table.roots = {{.part = 0,
                  .triangle = 0,
                  .corners = {0, 1, 2},
                  .barycentric = {0.5f, 0.25f, 0.25f},
                  .offset = {0, 0, 0.001f},
                  .bind = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}}};
  write(folderOf(root, "tfxskin") / "valid.tfxskin", *saveTfxSkin(table));

  SdfData field;
  field.grid = {.origin = {0, 0, 0}, .cellSize = 0.1f, .nodes = {4, 1, 2}};
  field.triangleBits = 1;
  field.triangleCount = 1;
  field.keys = {0x7fffffffu, 0, 2, 0x7fffffffu, 0, 0, 0x7fffffffu, 4};
  field.surface.assign(16, 0);
  if (!saveSdf(field, folderOf(root, "psdf") / "valid.psdf")) return 1;

  AssetCache cache;
  cache.sources = {{"a.tfx", 5, 7}};
  cache.hairs = {{"hair", makeAsset(true), makeWeights(), makeFollowHairs()}};
  cache.hairs[0].asset = *loadTfx(full, "full");
  if (!cache.hairs[0].asset.process()) return 1;
  cache.meshes = {{"mesh", makeMesh()}};
  write(folderOf(root, "cache") / "valid_full.pelage", *saveAssetCache(cache));
  cache.meshes.clear();
  cache.sources.clear();
  HairAsset plain = makeAsset(false);
  if (!plain.process()) return 1;
  cache.hairs = {{"", plain, std::nullopt, {}}};
  write(folderOf(root, "cache") / "valid_plain.pelage", *saveAssetCache(cache));

  HairCacheDef shot = {.name = "shot", .strandCount = 2, .vertexCounts = {3, 2}};
  if (!writeHairCache(folderOf(root, "haircache") / "valid.pelagecache", shot)) return 1;
  shot.errorBound = 0;
  shot.keyInterval = 2;
  shot.strandIds = {7, 9};
  if (!writeHairCache(folderOf(root, "haircache") / "valid_exact.pelagecache", shot)) return 1;

  write(folderOf(root, "hair") / "valid.hair", *saveYukselHair(makeCurves()));
  HairCurves bare;
  bare.vertexCounts = {2, 2};
  bare.positions = {{0, 0, 0}, {0, 1, 0}, {1, 0, 0}, {1, 1, 0}};
  write(folderOf(root, "hair") / "valid_plain.hair", *saveYukselHair(bare));
  HairCurves columns = makeCurves();
  columns.inverseMasses = {0, 0, 1, 0, 0};
  columns.strandUv = {{0, 0.5f}, {0.5f, 1}};
  write(folderOf(root, "hairtxt") / "valid_full.hairtxt", *saveHairText(columns));
  write(folderOf(root, "hairtxt") / "valid_plain.hairtxt", *saveHairText(bare));
  write(folderOf(root, "obj") / "valid.obj",
        "# lines\nv 0 0 0 1 0 0\nv 0 1 0 1 0 0\nv 0 2 1 0 0 1\nvt 0.5 0.5\nvt 1 0\n"
        "l 1/1 2/2 3/1\nl -3 -2\n");
  write(folderOf(root, "gltf") / "valid.gltf",
        R"({"asset":{"version":"2.0"},"scene":0,"scenes":[{"nodes":[0]}],)"
        R"("nodes":[{"mesh":0,"translation":[0,1,0]}],"meshes":[{"primitives":[{"mode":3,)"
        R"("attributes":{"POSITION":0}}]}],"accessors":[{"bufferView":0,"componentType":5126,)"
        R"("count":2,"type":"VEC3"}],"bufferViews":[{"buffer":0,"byteLength":24}],"buffers":)"
        R"([{"byteLength":24,"uri":"data:application/octet-stream;base64,)"
        R"(AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAA"}]})");
  write(folderOf(root, "tfxcurves") / "valid_4.tfx", *saveTfx(makeAsset(true)));
  write(folderOf(root, "animation") / "valid.gltf", animationText());
  write(folderOf(root, "pc2") / "valid.pc2", pointCache());
  write(folderOf(root, "skinobj") / "valid.obj",
        "# quad\r\nv 0 0 0\nv 1 0 0 1\nv 1 1e0 0\nv 0 1 -0.5\nvn 0 0 1\nf 1//1 2//1 3/1/1 4\n"
        "f -4 -3 -1\n");
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 2) {
    std::fprintf(stderr, "usage: make_corpus FOLDER\n");
    return 1;
  }
  return makeCorpus(argv[1]);
}
