// Files that the viewer opens: companions, units, broken files.
#include "stage/files.h"

#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include "gltf_file.h"
#include "pelage/demo/character.h"
#include "pelage/demo/groom.h"
#include "stage/stage.h"
#include "support/errors.h"
#include "support/test_folder.h"

namespace {

using Path = std::filesystem::path;
using pelage::test::expectError;
using pelage::test::required;
using pelage::test::TestFolder;

class ViewerFiles : public testing::Test {
 protected:
  void SetUp() override {
    pelage::GroomDef def;
    def.strandCount = 40;
    def.verticesPerStrand = 8;
    auto groom = required(pelage::generateGroom(def));
    groom_ = *std::move(groom);
    required(pelage::writeGroom(groom_, folder_.path(), "hair"));
  }

  Path file(const std::string& name) const { return folder_ / name; }
  const TestFolder folder_;
  pelage::Groom groom_;
};

TEST_F(ViewerFiles, BonesBesideTheHairAreFound) {
  const auto loaded = required(viewer::loadFiles(std::vector<Path>{file("hair.tfx")}, 0));
  ASSERT_EQ(loaded->assets.hairs.size(), 1u);
  EXPECT_TRUE(loaded->assets.hairs[0].bones.has_value());
  EXPECT_EQ(loaded->scale, 1);
  EXPECT_TRUE(loaded->guesses.empty());
  EXPECT_TRUE(loaded->meanLength > 0.05 && loaded->meanLength < 0.5) << loaded->meanLength;
}

TEST_F(ViewerFiles, HairInCentimetersIsScaledUnlessTheScaleIsGiven) {
  pelage::HairAsset hair = groom_.hair;
  ASSERT_TRUE(pelage::scaleHair(hair, 100));
  ASSERT_TRUE(pelage::saveTfx(hair, file("big.tfx")));
  const std::vector<Path> files = {file("big.tfx")};
  const auto found = required(viewer::loadFiles(files, 0));
  ASSERT_FALSE(found->guesses.empty());
  EXPECT_NEAR(found->scale, 0.01f, 1e-6f);
  EXPECT_TRUE(found->meanLength > 0.05 && found->meanLength < 0.5) << found->meanLength;
  EXPECT_FALSE(found->remarks.empty());
  const auto given = required(viewer::loadFiles(files, 1));
  EXPECT_EQ(given->scale, 1);
  EXPECT_EQ(given->guesses.size(), found->guesses.size());
}

TEST_F(ViewerFiles, WhatIsNoHairIsRefusedByName) {
  std::ofstream(file("broken.tfx")) << "no hair at all";
  std::ofstream(file("words.txt")) << "words";
  for (const char* name : {"broken.tfx", "words.txt", "missing.tfx"}) {
    expectError(viewer::loadFiles(std::vector<Path>{file(name)}, 0), {name});
  }
  expectError(viewer::loadFiles(std::vector<Path>{file("hair.tfxmesh")}, 0), "no hair");
}

TEST_F(ViewerFiles, AListWithoutFilesSaysWhy) {
  const auto list = required(viewer::listFolder(folder_.path()));
  EXPECT_EQ(list->fileCount, 3u);  // .tfx, .tfxbone, .tfxmesh
  EXPECT_EQ(list->otherCount, 0u);
  const Path other = folder_ / "other";
  std::filesystem::create_directories(other / "folder");
  const auto empty = required(viewer::listFolder(other));
  EXPECT_EQ(empty->fileCount, 0u);
  EXPECT_EQ(empty->entries, (std::vector<viewer::FolderEntry>{{"folder", true}}));
  EXPECT_EQ(viewer::reasonForNoFiles(*empty).find("No files are here. It opens .tfx, "), 0u);
  for (const char* name : {"a.txt", "b.png"}) std::ofstream(other / name) << "no hair";
  EXPECT_EQ(viewer::reasonForNoFiles(*required(viewer::listFolder(other)))
                .find("None of the 2 files here is one that the viewer opens."),
            0u);
}

#ifdef PELAGE_TEST_AUTHORING
TEST_F(ViewerFiles, CurvesKeepTheirColorAndThickness) {
  (void)folder_.write("look.hairtxt",
                      "hairtxt 1 x y z radius r g b\n"
                      "0 0 0 12e-5 0.5 0.25 1\n0 0.3 0 12e-5 0.5 0.25 1\n");
  const auto loaded = required(viewer::loadFiles(std::vector<Path>{file("look.hairtxt")}, 1));
  ASSERT_EQ(loaded->assets.hairs.size(), 1u);
  const pelage::HairAsset& hair = loaded->assets.hairs[0].asset;
  ASSERT_EQ(hair.strandThickness.size(), 1u);
  EXPECT_NEAR(hair.strandThickness[0], 3, 1e-5f);  // of 40 um
  ASSERT_FALSE(hair.vertexColor.empty());
  EXPECT_EQ(hair.vertexColor[0].y, 0.25f);
}

// Hair collides with a character and follows it; its clip moves in the file's unit.
TEST_F(ViewerFiles, ACharacterMovesHairThatHasNoBones) {
  const auto character = required(pelage::generateCharacter());
  ASSERT_TRUE(sample::writeGltf(*character, file("character.gltf")));
  ASSERT_TRUE(pelage::saveTfx(character->grooms[2].hair, file("mohawk.tfx")));
  const std::vector<Path> files = {file("character.gltf"), file("mohawk.tfx")};
  const auto loaded = required(viewer::loadFiles(files, 1, "jump"));
  ASSERT_EQ(loaded->assets.hairs.size(), 1u);
  ASSERT_TRUE(loaded->assets.hairs[0].bones.has_value());
  EXPECT_FALSE(loaded->assets.meshes.empty());
  ASSERT_TRUE(loaded->motion.has_value());
  EXPECT_GT(loaded->motion->seconds, 0.5);

  expectError(viewer::loadFiles(files, 1, "swim"), "jump");

  const auto half = required(viewer::loadFiles(files, 0.5f, "jump"));
  const double time = loaded->motion->seconds / 2;
  const auto bones = loaded->motion->pose(time), halfBones = half->motion->pose(time);
  ASSERT_EQ(bones.size(), halfBones.size());
  double moved = 0;
  for (size_t i = 0; i < bones.size(); ++i) {
    EXPECT_NEAR(halfBones[i].rows[1].w, bones[i].rows[1].w / 2, 1e-6f);
    moved += std::abs(static_cast<double>(bones[i].rows[1].w));
  }
  EXPECT_GT(moved, 0.01);
  viewer::Stage stage;
  ASSERT_TRUE(stage.show({.kind = viewer::StageKind::kFiles, .files = files, .clip = "walk"}));
  EXPECT_FALSE(stage.colliders().empty());
}
#endif

// A new source frees the buffers of the last one; a broken file leaves the buffers as they are.
TEST_F(ViewerFiles, TheStageStaysWhenFilesAreBroken) {
  viewer::Stage stage;
  viewer::StageSource source;
  source.kind = viewer::StageKind::kFiles;
  source.files = {file("hair.tfx"), file("hair.tfxmesh")};
  ASSERT_TRUE(stage.show(source));
  const uint64_t bytes = stage.scene().resources().totalBytes();
  const pelage::HairId hair = stage.hairs()[0];
  std::ofstream(file("broken.tfx")) << "no hair at all";
  viewer::StageSource broken = source;
  broken.files = {file("broken.tfx")};
  EXPECT_FALSE(stage.show(broken));
  ASSERT_EQ(stage.hairs().size(), 1u);
  EXPECT_EQ(stage.hairs()[0], hair);
  EXPECT_EQ(stage.source().files, source.files);
  EXPECT_EQ(stage.scene().resources().totalBytes(), bytes);
  ASSERT_TRUE(stage.show(source));
  EXPECT_EQ(stage.scene().resources().totalBytes(), bytes);
  EXPECT_EQ(stage.scene().hairCount(), 1u);
}

}  // namespace
