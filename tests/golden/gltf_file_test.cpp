// The character as the sample writes it, read back.
#include "gltf_file.h"

#include <assimp/postprocess.h>
#include <assimp/scene.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <assimp/Importer.hpp>
#include <cmath>
#include <filesystem>
#include <map>
#include <memory>
#include <string>
#include <tuple>

#include "demo_assets.h"
#include "pelage/authoring/animation.h"
#include "pelage/mesh_import.h"
#include "support/errors.h"
#include "support/test_folder.h"

namespace {

using pelage::Character;
using pelage::CollisionMesh;
using pelage::test::expectError;
using pelage::test::required;
using pelage::test::TestFolder;

class GltfFile : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    folder_ = std::make_unique<TestFolder>();
    pelage::CharacterDef def;
    def.cellSize = 0.006f;
    def.colliderCellSize = 0.012f;
    def.longHair = {20, 8, 0.3f};
    def.fur = {30, 6, 0.03f};
    def.mohawk = {10, 8, 0.1f};
    auto made = required(pelage::generateCharacter(def));
    character_ = std::move(*made);
    required(sample::writeAssets(character_, folder_->path()));
  }
  static void TearDownTestSuite() { folder_.reset(); }

  static inline std::unique_ptr<TestFolder> folder_;
  static inline Character character_;
};

TEST_F(GltfFile, HasTheVerticesTheTrianglesAndTheBoneWeightsOfTheMesh) {
  const auto read = required(pelage::loadMesh(*folder_ / "character.gltf"));
  const CollisionMesh& mesh = character_.mesh;
  EXPECT_EQ(read->positions.size(), mesh.positions.size());
  EXPECT_EQ(read->indices.size(), mesh.indices.size());
  EXPECT_EQ(read->repairedVertexCount, 0u);
  const auto key = [](const pelage::Float3& p) {
    const auto round = [](float v) { return std::lround(v * 1e5); };
    return std::tuple(round(p.x), round(p.y), round(p.z));
  };
  std::map<std::tuple<long, long, long>, size_t> slots;
  for (size_t v = 0; v < mesh.positions.size(); ++v) slots[key(mesh.positions[v])] = v;
  const auto weightsByName = [](const CollisionMesh& from, size_t vertex) {
    std::map<std::string, float> weights;
    for (int i = 0; i < 4; ++i) {
      const float weight = from.influences[vertex].weights[i];
      if (!(weight > 1e-4f)) continue;
      for (const pelage::BoneName& bone : from.bones)
        if (bone.index == from.influences[vertex].bones[i]) weights[bone.name] += weight;
    }
    return weights;
  };
  uint32_t compared = 0;
  for (size_t v = 0; v < read->positions.size(); ++v) {
    const auto found = slots.find(key(read->positions[v]));
    if (found == slots.end()) continue;  // rounded to the neighbouring key
    ++compared;
    const auto expected = weightsByName(mesh, found->second), actual = weightsByName(*read, v);
    ASSERT_EQ(actual.size(), expected.size()) << "vertex " << v;
    for (const auto& [bone, weight] : expected) {
      ASSERT_TRUE(actual.contains(bone)) << bone;
      ASSERT_NEAR(actual.at(bone), weight, 1e-4f) << bone;
    }
  }
  EXPECT_GT(compared, mesh.positions.size() / 2);
}

TEST_F(GltfFile, HasTheBonesTheMaterialsAndTheAnimations) {
  Assimp::Importer importer;
  const aiScene* scene = importer.ReadFile((*folder_ / "character.gltf").string(), 0);
  ASSERT_NE(scene, nullptr) << importer.GetErrorString();
  for (const pelage::Bone& bone : character_.skeleton.bones)
    EXPECT_NE(scene->mRootNode->FindNode(bone.name.c_str()), nullptr) << bone.name;
  ASSERT_GE(scene->mNumMaterials, character_.parts.size());
  EXPECT_EQ(scene->mNumMeshes, character_.parts.size());

  const std::pair<const char*, pelage::CharacterMotion> animations[] = {
      {"walk", pelage::CharacterMotion::kWalk},
      {"headShake", pelage::CharacterMotion::kHeadShake},
      {"jump", pelage::CharacterMotion::kJump}};
  ASSERT_EQ(scene->mNumAnimations, std::size(animations));
  for (size_t i = 0; i < std::size(animations); ++i) {
    const aiAnimation& animation = *scene->mAnimations[i];
    const auto& [name, motion] = animations[i];
    EXPECT_STREQ(animation.mName.C_Str(), name);
    EXPECT_EQ(animation.mNumChannels, character_.skeleton.bones.size());
    const pelage::CharacterCycle cycle = pelage::characterCycle(motion);
    const auto keys = static_cast<uint32_t>(std::lround((cycle.end - cycle.start) * 30)) + 1;
    for (uint32_t c = 0; c < animation.mNumChannels; ++c) {
      const aiNodeAnim& channel = *animation.mChannels[c];
      EXPECT_EQ(channel.mNumRotationKeys, keys);
      if (channel.mNodeName != aiString("hips")) continue;
      EXPECT_EQ(channel.mNumPositionKeys, keys);
      for (uint32_t k = 0; k < channel.mNumPositionKeys; ++k) {
        const auto world = pelage::poseCharacter(motion, cycle.start + k / 30.0);
        ASSERT_NEAR(channel.mPositionKeys[k].mValue.y, world[0].rows[1].w, 1e-6);
      }
    }
  }
}

TEST_F(GltfFile, MovesTheBonesAsTheCharacterDoes) {
  const std::pair<const char*, pelage::CharacterMotion> clips[] = {
      {"walk", pelage::CharacterMotion::kWalk}, {"jump", pelage::CharacterMotion::kJump}};
  for (const auto& [clip, motion] : clips) {
    const auto animation = required(pelage::loadAnimation(*folder_ / "character.gltf", clip));
    const pelage::CharacterCycle cycle = pelage::characterCycle(motion);
    EXPECT_NEAR(animation->seconds, cycle.end - cycle.start, 1.0 / 30);
    const pelage::Skeleton skeleton = pelage::skeletonOf(*animation);
    for (const int key : {0, 7, 20}) {
      const auto expected = pelage::skinningTransforms(
          character_.skeleton, pelage::poseCharacter(motion, cycle.start + key / 30.0));
      const auto actual =
          pelage::skinningTransforms(skeleton, pelage::poseAt(*animation, key / 30.0));
      for (size_t bone = 0; bone < expected.size(); ++bone) {
        const auto slot = skeleton.find(character_.skeleton.bones[bone].name);
        ASSERT_TRUE(slot) << character_.skeleton.bones[bone].name;
        const pelage::Float3 point = {0.1f, 0.3f, -0.05f};
        const pelage::Float3 a = pelage::transformPoint(actual[*slot], point);
        const pelage::Float3 b = pelage::transformPoint(expected[bone], point);
        EXPECT_NEAR(a.x, b.x, 2e-5f) << clip << " " << bone << " " << key;
        EXPECT_NEAR(a.y, b.y, 2e-5f) << clip << " " << bone << " " << key;
        EXPECT_NEAR(a.z, b.z, 2e-5f) << clip << " " << bone << " " << key;
      }
    }
  }
}

TEST_F(GltfFile, StandsBesideTheFilesOfTheGroomsAndColliders) {
  for (const pelage::CharacterGroom& groom : character_.grooms) {
    const auto hair = required(pelage::loadTfx(*folder_ / (groom.name + ".tfx")));
    EXPECT_EQ(hair->positions, groom.hair.positions);
    const auto bones =
        required(pelage::loadTfxBone(*folder_ / (groom.name + ".tfxbone"), hair->strandCount));
    EXPECT_EQ(bones->strands, groom.bones.strands);
  }
  for (const pelage::CharacterCollider& collider : character_.colliders) {
    const auto mesh = required(pelage::loadTfxMesh(*folder_ / (collider.name + ".tfxmesh")));
    EXPECT_EQ(mesh->positions, collider.mesh.positions);
    EXPECT_EQ(mesh->influences, collider.mesh.influences);
  }
}

TEST_F(GltfFile, SaysWhichFileCannotBeWritten) {
  expectError(sample::writeGltf(character_, *folder_ / "missing" / "character.gltf"),
              "character.gltf");
}

}  // namespace
