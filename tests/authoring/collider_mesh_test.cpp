// Collision meshes from the files of modelling programs. The files are written here.
#include <assimp/scene.h>
#include <gtest/gtest.h>

#include <array>
#include <assimp/Exporter.hpp>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <string>
#include <utility>
#include <vector>

#include "pelage/mesh_import.h"
#include "support/errors.h"
#include "support/test_folder.h"

namespace pelage {
namespace {

using test::expectError;
using test::required;
using test::TestFolder;

class MeshImport : public testing::Test {
 protected:
  std::filesystem::path write(const std::string& file, std::string_view text) const {
    return folder_.write(file, text);
  }
  const TestFolder folder_;
};

std::string boneOf(const CollisionMesh& mesh, size_t vertex, size_t influence = 0) {
  return mesh.bones.at(mesh.influences.at(vertex).bones[influence]).name;
}

double sumOfWeights(const BoneInfluences& influences) {
  double sum = 0;
  for (const float weight : influences.weights) sum += weight;
  return sum;
}

// The first vertex at a place.
size_t vertexAt(const CollisionMesh& mesh, const Float3& point) {
  for (size_t v = 0; v < mesh.positions.size(); ++v) {
    const Float3& p = mesh.positions[v];
    if (std::abs(p.x - point.x) + std::abs(p.y - point.y) + std::abs(p.z - point.z) < 1e-5)
      return v;
  }
  ADD_FAILURE() << "no vertex at " << point.x << " " << point.y << " " << point.z;
  return 0;
}

constexpr std::string_view kCube =
    "o crate\nv 0 0 0\nv 1 0 0\nv 0 1 0\nv 1 1 0\nv 0 0 1\nv 1 0 1\nv 0 1 1\nv 1 1 1\n"
    "f 1 3 4 2\nf 5 6 8 7\nf 1 2 6 5\nf 3 7 8 4\nf 1 5 7 3\nf 2 4 8 6\n";

TEST_F(MeshImport, AnObjCubeOfQuadsIsAClosedMeshOfTwelveTriangles) {
  auto mesh = required(loadMesh(write("cube.obj", kCube)));
  EXPECT_EQ(mesh->indices.size(), 36u);
  EXPECT_EQ(mesh->positions.size(), 8u);
  EXPECT_EQ(boneOf(*mesh, 0), "crate");
  EXPECT_EQ(mesh->repairedVertexCount, 0u);
  auto report = required(inspectMesh(*mesh));
  EXPECT_TRUE(report->closed && report->consistentlyOriented) << describe(*report);
  EXPECT_NEAR(report->volume, 1, 1e-6);
}

TEST_F(MeshImport, WhatIsImportedCanBeSaved) {
  auto mesh = required(loadMesh(write("cube.obj", kCube)));
  auto text = required(saveTfxMesh(*mesh));
  auto again = required(loadMesh(write("cube.tfxmesh", *text)));
  EXPECT_EQ(again->positions, mesh->positions);
  EXPECT_EQ(again->indices, mesh->indices);
}

TEST_F(MeshImport, TakesAllMeshesOfAFile) {
  const std::string second = "o lid\nv 0 0 2\nv 1 0 2\nv 0 1 2\nf -3 -2 -1\nl 9 10\n";
  auto mesh = required(loadMesh(write("two.obj", std::string(kCube) + second)));
  EXPECT_EQ(mesh->indices.size(), 39u);
  EXPECT_EQ(boneOf(*mesh, vertexAt(*mesh, {0, 1, 2})), "lid");
  EXPECT_EQ(boneOf(*mesh, vertexAt(*mesh, {0, 1, 1})), "crate");
}

// A skinned quad whose mesh node has a transform that skins ignore, and a mirrored, moved cap that
// hangs on the second bone without a skin.
constexpr std::string_view kGltf = R"({
  "asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0, 3]}],
  "nodes": [
    {"name": "hip", "translation": [0, 1, 0], "children": [1]},
    {"name": "chest", "translation": [0, 2, 0], "children": [2]},
    {"name": "cap", "mesh": 1, "translation": [5, 0, 0], "scale": [-2, 2, 2]},
    {"name": "skin", "mesh": 0, "skin": 0, "translation": [100, 0, 0]}],
  "skins": [{"joints": [0, 1], "inverseBindMatrices": 4}],
  "meshes": [
    {"name": "skin", "primitives": [{"attributes": {"POSITION": 0, "JOINTS_0": 1, "WEIGHTS_0": 2},
     "indices": 3}]},
    {"name": "cap", "primitives": [{"attributes": {"POSITION": 0}, "indices": 3}]}],
  "accessors": [
    {"bufferView": 0, "componentType": 5126, "count": 4, "type": "VEC3", "min": [0, 0, 0],
     "max": [1, 4, 0]},
    {"bufferView": 1, "componentType": 5121, "count": 4, "type": "VEC4"},
    {"bufferView": 2, "componentType": 5126, "count": 4, "type": "VEC4"},
    {"bufferView": 3, "componentType": 5123, "count": 6, "type": "SCALAR"},
    {"bufferView": 4, "componentType": 5126, "count": 2, "type": "MAT4"}],
  "bufferViews": [
    {"buffer": 0, "byteOffset": 0, "byteLength": 48},
    {"buffer": 0, "byteOffset": 48, "byteLength": 16},
    {"buffer": 0, "byteOffset": 64, "byteLength": 64},
    {"buffer": 0, "byteOffset": 128, "byteLength": 12},
    {"buffer": 0, "byteOffset": 140, "byteLength": 128}],
  "buffers": [{"uri": "skin.bin", "byteLength": 268}]})";

template <class T, size_t kCount>
void append(std::string& bytes, const std::array<T, kCount>& values) {
  bytes.append(reinterpret_cast<const char*>(values.data()), sizeof(values));
}

// \param chestBind  height of the chest in the bind pose
std::string gltfBuffer(float chestBind) {
  std::string bytes;
  append(bytes, std::array<float, 12>{0, 0, 0, 1, 0, 0, 1, 4, 0, 0, 4, 0});
  append(bytes, std::array<uint8_t, 16>{0, 1, 0, 0, 0, 1, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0});
  append(bytes, std::array<float, 16>{1, 0, 0, 0, 0.75f, 0.25f, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0});
  append(bytes, std::array<uint16_t, 6>{0, 1, 2, 0, 2, 3});
  // Columns.
  append(bytes, std::array<float, 16>{1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, -1, 0, 1});
  append(bytes, std::array<float, 16>{1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, -chestBind, 0, 1});
  return bytes;
}

TEST_F(MeshImport, ASkinnedGltfIsWhereItsBonesAre) {
  write("skin.bin", gltfBuffer(3));
  auto mesh = required(loadMesh(write("skin.gltf", kGltf)));
  EXPECT_EQ(mesh->indices.size(), 12u);
  EXPECT_EQ(mesh->repairedVertexCount, 0u);
  const size_t hip = vertexAt(*mesh, {0, 0, 0}), both = vertexAt(*mesh, {1, 0, 0});
  const size_t chest = vertexAt(*mesh, {1, 4, 0});
  EXPECT_EQ(boneOf(*mesh, hip), "hip");
  EXPECT_EQ(boneOf(*mesh, chest), "chest");
  EXPECT_EQ(boneOf(*mesh, both, 0), "hip");
  EXPECT_EQ(boneOf(*mesh, both, 1), "chest");
  EXPECT_FLOAT_EQ(mesh->influences[both].weights[0], 0.75f);
  EXPECT_FLOAT_EQ(mesh->influences[both].weights[1], 0.25f);
  for (const BoneInfluences& influences : mesh->influences)
    EXPECT_NEAR(sumOfWeights(influences), 1, 1e-6);
}

TEST_F(MeshImport, ASkinnedGltfInAnotherPoseIsSkinned) {
  write("skin.bin", gltfBuffer(2.5f));  // the chest stands half a unit higher than it was bound
  auto mesh = required(loadMesh(write("skin.gltf", kGltf)));
  vertexAt(*mesh, {0, 0, 0});
  vertexAt(*mesh, {1, 0.125f, 0});
  vertexAt(*mesh, {1, 4.5f, 0});
}

TEST_F(MeshImport, AMeshWithoutSkinHangsOnItsNode) {
  write("skin.bin", gltfBuffer(3));
  auto mesh = required(loadMesh(write("skin.gltf", kGltf)));
  const size_t a = vertexAt(*mesh, {5, 3, 0}), b = vertexAt(*mesh, {3, 3, 0});
  const size_t c = vertexAt(*mesh, {3, 11, 0});
  EXPECT_EQ(boneOf(*mesh, a), "cap");
  // It is mirrored, so the triangle a b c of the file has another order to face the same way.
  bool found = false;
  for (size_t i = 0; i < mesh->indices.size(); i += 3)
    for (size_t k = 0; k < 3; ++k)
      found = found || (mesh->indices[i + k] == c && mesh->indices[i + (k + 1) % 3] == b &&
                        mesh->indices[i + (k + 2) % 3] == a);
  EXPECT_TRUE(found);
}

// A triangle with six bones, for an exporter.
std::unique_ptr<aiScene> manyBones() {
  auto scene = std::make_unique<aiScene>();
  scene->mRootNode = new aiNode("root");
  scene->mNumMaterials = 1;
  scene->mMaterials = new aiMaterial* [1] { new aiMaterial };
  auto* mesh = new aiMesh;
  scene->mNumMeshes = 1;
  scene->mMeshes = new aiMesh* [1] { mesh };
  mesh->mName = "flap";
  mesh->mPrimitiveTypes = aiPrimitiveType_TRIANGLE;
  mesh->mNumVertices = 3;
  mesh->mVertices = new aiVector3D[3]{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
  mesh->mNormals = new aiVector3D[3]{{0, 0, 1}, {0, 0, 1}, {0, 0, 1}};
  mesh->mNumFaces = 1;
  mesh->mFaces = new aiFace[1];
  mesh->mFaces[0].mNumIndices = 3;
  mesh->mFaces[0].mIndices = new unsigned[3]{0, 1, 2};
  constexpr unsigned kBones = 6;
  mesh->mNumBones = kBones;
  mesh->mBones = new aiBone*[kBones];
  auto* flap = new aiNode("flap");
  flap->mNumMeshes = 1;
  flap->mMeshes = new unsigned[1]{0};
  std::vector<aiNode*> nodes = {flap};
  for (unsigned b = 0; b < kBones; ++b) {
    const std::string name = "bone" + std::to_string(b);
    mesh->mBones[b] = new aiBone;
    mesh->mBones[b]->mName = name;
    // Vertex 2 has no weights.
    mesh->mBones[b]->mNumWeights = 2;
    const float weight = 0.1f + 0.05f * static_cast<float>(b * 5 % kBones);
    mesh->mBones[b]->mWeights = new aiVertexWeight[2]{{0, weight}, {1, b == 3 ? 1.0f : 0.0f}};
    nodes.push_back(new aiNode(name));
  }
  scene->mRootNode->addChildren(static_cast<unsigned>(nodes.size()), nodes.data());
  return scene;
}

// manyBones() through a file of this format.
Result<CollisionMesh> loadManyBones(const char* format, const std::filesystem::path& path) {
  Assimp::Exporter exporter;
  EXPECT_EQ(exporter.Export(manyBones().get(), format, path.string()), AI_SUCCESS)
      << exporter.GetErrorString();
  return required(loadMesh(path));
}

TEST_F(MeshImport, KeepsTheFourStrongestBones) {
  auto mesh = loadManyBones("assbin", folder_ / "many.assbin");
  // Weights 0.1 0.35 0.3 0.25 0.2 0.15: bones 1 to 4, together 1.1.
  const size_t v = vertexAt(*mesh, {0, 0, 0});
  for (size_t k = 0; k < 4; ++k) {
    EXPECT_EQ(boneOf(*mesh, v, k), "bone" + std::to_string(k + 1));
    EXPECT_NEAR(mesh->influences[v].weights[k], (0.35 - 0.05 * double(k)) / 1.1, 1e-6);
  }
  const size_t one = vertexAt(*mesh, {1, 0, 0});
  EXPECT_EQ(boneOf(*mesh, one), "bone3");
  EXPECT_EQ(mesh->influences[one].weights[0], 1);
  // In a skinned mesh what has no weights is a repair.
  EXPECT_EQ(boneOf(*mesh, vertexAt(*mesh, {0, 1, 0})), "flap");
  EXPECT_EQ(mesh->repairedVertexCount, 1u);
}

TEST_F(MeshImport, ReadsFbx) {
  auto mesh = loadManyBones("fbxa", folder_ / "many.fbx");
  EXPECT_EQ(mesh->indices.size(), 3u);
  EXPECT_EQ(boneOf(*mesh, vertexAt(*mesh, {1, 0, 0})), "bone3");
}

TEST_F(MeshImport, ErrorsNameTheFileAndWhatIsWrong) {
  expectError(loadMesh(folder_ / "none.obj"), ErrorCode::kFileNotFound, "none.obj");

  expectError(loadMesh(write("notes.txt", "no mesh")), ErrorCode::kInvalidFile,
              "notes.txt: cannot be read: ");

  expectError(loadMesh(write("broken.gltf", kGltf.substr(0, 300))), "broken.gltf");

  std::filesystem::remove(folder_ / "skin.bin");
  EXPECT_FALSE(loadMesh(write("skin.gltf", kGltf)));

  expectError(loadMesh(write("line.obj", "v 0 0 0\nv 1 0 0\nl 1 2\n")),
              {"line.obj", "no triangles"});

  expectError(loadMesh(write("far.obj", "o far\nv 0 0 0\nv 3e6 0 0\nv 0 1 0\nf 1 2 3\n")),
              "far.obj: mesh 'far': vertex 1");
}

}  // namespace
}  // namespace pelage
