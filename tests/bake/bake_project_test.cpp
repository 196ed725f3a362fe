// Projects of pelage-bake: what is wrong is named by file and JSON pointer; plans.
#include <gtest/gtest.h>

#include <string>
#include <utility>
#include <vector>

#include "json_members.h"
#include "plan.h"
#include "project.h"
#include "support/errors.h"
#include "support/test_folder.h"

namespace pelage::bake {
namespace {

using test::expectHas;
using test::required;
using test::TestFolder;

constexpr const char* kFine = R"({
  "version": 1, "output": "out", "fps": 30, "chunkFrames": 8, "formats": ["pelagecache"],
  "device": {"api": "gl", "device": "1"},
  "defaults": {"assets": {"generated": {"kind": "head", "guides": 20}},
               "animation": {"motion": "walk"}},
  "shots": [
    {"name": "a", "frames": [1, 20], "errorBound": "0.5mm"},
    {"name": "b", "frames": [-3, 40], "subSteps": 4, "strands": "all", "preRoll": 5,
     "assets": {"hairs": [{"file": "x.tfx", "bones": "x.tfxbone"}], "scale": 0.01,
                "cellSize": "4mm"}}]})";

TEST(Project, IsReadWithItsDefaults) {
  const TestFolder folder;
  const auto project = required(loadProject(folder.write("p.json", kFine)));
  EXPECT_EQ(project->output, folder / "out");
  EXPECT_EQ(project->api, Api::kGl);
  EXPECT_EQ(project->device, "1");
  ASSERT_EQ(project->shots.size(), 2u);
  const Shot& a = project->shots[0];
  ASSERT_TRUE(a.generated);
  EXPECT_EQ(a.generated->guides, 20u);
  EXPECT_EQ(a.motion, CharacterMotion::kWalk);
  ASSERT_TRUE(a.errorBound);
  EXPECT_DOUBLE_EQ(*a.errorBound, 5e-4);
  const Shot& b = project->shots[1];
  EXPECT_FALSE(b.generated);
  ASSERT_EQ(b.files.hairs.size(), 1u);
  EXPECT_EQ(b.files.hairs[0], folder / "x.tfx");
  EXPECT_EQ(b.files.bones[0], folder / "x.tfxbone");
  EXPECT_EQ(b.files.followHairs[0], "-");
  EXPECT_TRUE(b.followHairs);
  EXPECT_EQ(a.cellSize, 0) << "the default";
  EXPECT_DOUBLE_EQ(b.cellSize, 0.004);
  EXPECT_EQ(b.frames, (FrameRange{-3, 40}));
  EXPECT_EQ(project->find("b"), &b);
  EXPECT_EQ(project->find("c"), nullptr);
}

// One change to kFine each, and what the message must have.
TEST(Project, WhatIsWrongIsNamedByItsPointer) {
  struct Case {
    const char *from, *to, *message;
  };
  const TestFolder folder;
  for (const Case& c : std::vector<Case>{
           {"\"version\": 1,", "", "/version: is missing"},
           {"\"version\": 1,", "\"version\": 2,", "/version: must be a whole number from 1 to 1"},
           {"\"fps\": 30", "\"fps\": 2", "/fps: must be a number from 15 to 1000"},
           {"\"fps\": 30", "\"fsp\": 30", "/fsp: there is no such setting"},
           {"\"output\": \"out\"", "\"output\": 5", "/output: must be text"},
           {"\"chunkFrames\": 8", "\"chunkFrames\": 1.5", "/chunkFrames: must be a whole number"},
           {"[\"pelagecache\"]", "[\"abc\"]", "/formats: are"},
           {"[\"pelagecache\"]", "[7]", "/formats/0: must be text"},
           {"\"api\": \"gl\"", "\"api\": \"metal\"", "/device/api: must be one of"},
           {"\"name\": \"b\"", "\"name\": \"a\"", "/shots/1/name: another shot is 'a'"},
           {"\"name\": \"b\"", "\"name\": \"../b\"", "/shots/1/name: must be"},
           {"[1, 20]", "[20, 1]", "/shots/0/frames: must be [first, last], first <= last"},
           {"[1, 20]", "[1, 1e400]", "number overflow"},
           {"[1, 20]", "[1, 2000000]", "/shots/0/frames: are more than"},
           {"\"0.5mm\"", "\"0.5 furlongs\"", "/shots/0/errorBound: must be a length"},
           {"\"0.5mm\"", "\"0.5mm\", \"subSteps\": 3", "/shots/0/errorBound: chooses"},
           {"\"0.5mm\"", "\"0.5mm\", \"errorShare\": 2", "/shots/0/errorShare"},
           {"\"0.5mm\"", "\"0.5mm\", \"solver\": \"classic\"", "/shots/0/errorBound: is for"},
           {"\"subSteps\": 4", "\"subSteps\": 33", "/shots/1/subSteps: must be a whole number"},
           {"\"strands\": \"all\"", "\"strands\": true", "/shots/1/strands: must be one of"},
           {"\"motion\": \"walk\"", "\"motion\": \"fly\"", "/defaults/animation/motion: must be"},
           {"\"motion\": \"walk\"", "\"clip\": \"x\"", "/defaults/animation/file: give"},
           {"\"motion\": \"walk\"", "\"motion\": \"walk\", \"transforms\": \"x\"",
            "/defaults/animation/file: give"},
           {"\"motion\": \"walk\"", "\"points\": \"x.pc2\"", "/defaults/animation/mesh: is the"},
           {"\"motion\": \"walk\"", "\"motion\": \"walk\", \"fps\": 24",
            "/defaults/animation/fps: is that"},
           {"\"kind\": \"head\"", "\"kid\": \"head\"", "/defaults/assets/generated/kid: there is"},
           {"\"defaults\": {", "\"defaults\": {\"x\": 1, ", "/defaults/x: there is no such"},
           {"\"file\": \"x.tfx\"", "\"fill\": \"x.tfx\"",
            "/shots/1/assets/hairs/0/file: is missing"},
           {"\"scale\": 0.01", "\"scale\": 0", "/shots/1/assets/scale: must be a number"},
           {"\"shots\": [", "\"shots\": 5, \"x\": [", "/shots: must be an array"}}) {
    std::string text = kFine;
    const size_t at = text.find(c.from);
    ASSERT_NE(at, std::string::npos) << c.from;
    text.replace(at, std::string(c.from).size(), c.to);
    const auto project = loadProject(folder.write("p.json", text));
    if (project) {
      ADD_FAILURE() << "accepted: " << c.from << " -> " << c.to;
      continue;
    }
    expectHas(project.error().message, c.message);
    expectHas(project.error().message, "p.json");
  }
  EXPECT_FALSE(loadProject(folder / "none.json"));
  for (const char* text : {"", "[]", "null", "{\"shots\": []}", "{\"shots\": [1, [], null]}"})
    EXPECT_FALSE(loadProject(folder.write("p.json", text))) << text;
}

TEST(Project, ChunksBeginAtMultiplesAndCoverTheShot) {
  Project project;
  project.chunkFrames = 8;
  for (const FrameRange frames : {FrameRange{1, 20}, FrameRange{-13, -2}, FrameRange{0, 15},
                                  FrameRange{16, 16}, FrameRange{5, 40}}) {
    Shot shot;
    shot.frames = frames;
    int64_t next = frames.first;
    const uint64_t count = chunkCount(project, shot);
    for (uint64_t i = 0; i < count; ++i) {
      const FrameRange chunk = chunkOf(project, shot, i);
      EXPECT_EQ(chunk.first, next);
      EXPECT_TRUE(i == 0 || chunk.first % 8 == 0) << chunk.first;
      EXPECT_LE(chunk.first, chunk.last);
      next = chunk.last + 1;
    }
    EXPECT_EQ(next, frames.last + 1);
  }
}

Result<uint64_t> keyOf(const Project& project, const Shot& shot) {
  FileHashes hashes;
  return fingerprintOf(project, shot, hashes);
}

TEST(Project, TheFingerprintFollowsTheFilesAndTheSettings) {
  const TestFolder folder;
  (void)folder.write("x.tfx", "a");
  (void)folder.write("x.tfxbone", "b");
  const auto project = required(loadProject(folder.write("p.json", kFine)));
  Shot shot = project->shots[1];
  const auto first = required(keyOf(*project, shot));
  EXPECT_EQ(*keyOf(*project, shot), *first);
  shot.subSteps = 5;
  EXPECT_NE(*keyOf(*project, shot), *first);
  shot.subSteps = 4;
  (void)folder.write("x.tfx", "c");
  EXPECT_NE(*keyOf(*project, shot), *first);
  // A buffer beside an animation counts, too.
  (void)folder.write("x.tfx", "a");
  shot.motion.reset();
  shot.animation = folder.write("w.gltf", R"({"buffers": [{"uri": "w.bin"}]})");
  EXPECT_FALSE(keyOf(*project, shot));
  (void)folder.write("w.bin", "1");
  const auto animated = required(keyOf(*project, shot));
  (void)folder.write("w.bin", "2");
  EXPECT_NE(*keyOf(*project, shot), *animated);
  // So do the floats of a bone stream, and a point cache with its mesh.
  shot.animation.clear();
  shot.transforms =
      folder.write("b.json", R"({"version": 1, "fps": 24, "bones": ["a"], "data": "b.bin"})");
  EXPECT_FALSE(keyOf(*project, shot));
  (void)folder.write("b.bin", "1");
  const auto streamed = required(keyOf(*project, shot));
  shot.points = folder.write("c.pc2", "1");
  shot.pointMesh = folder.write("c.obj", "1");
  const auto moved = required(keyOf(*project, shot));
  EXPECT_NE(*moved, *streamed);
  (void)folder.write("b.bin", "2");
  const auto changed = keyOf(*project, shot);
  EXPECT_NE(*changed, *moved);
  (void)folder.write("c.pc2", "2");
  EXPECT_NE(*keyOf(*project, shot), *changed);
}

TEST(Project, AFileOfManyShotsIsHashedOnceUntilItChanges) {
  const TestFolder folder;
  const auto file = folder.write("x", "one");
  FileHashes hashes;
  const auto first = required(hashes.of(file));
  EXPECT_EQ(hashes.of(file)->hash, first->hash);
  EXPECT_EQ(hashes.filesRead(), 1u);
  (void)folder.write("x", "other");
  EXPECT_NE(hashes.of(file)->hash, first->hash);
  EXPECT_EQ(hashes.filesRead(), 2u);
  EXPECT_FALSE(hashes.of(folder / "none"));
}

TEST(Plan, RangesAreWholeChunksAndCoverTheShots) {
  const TestFolder folder;
  const auto project = required(loadProject(folder.write("p q.json", kFine)));
  const std::string path = (folder / "p q.json").string();
  EXPECT_EQ(planCommands(*project, "/bin/pelage-bake", 0),
            (std::vector<std::string>{"/bin/pelage-bake run '" + path + "' --shot a",
                                      "/bin/pelage-bake run '" + path + "' --shot b"}));
  EXPECT_EQ(planCommands(*project, "bake", 0, 8),
            (std::vector<std::string>{"bake run '" + path + "' --shot a,b"}));
  const auto commands = planCommands(*project, "bake", 16);
  ASSERT_EQ(commands.size(), 6u);
  expectHas(commands[0], "--shot a --frames=1-15");
  expectHas(commands[1], "--shot a --frames=16-20");
  expectHas(commands[2], "--shot b --frames=-3-7");
  expectHas(commands[3], "--shot b --frames=8-23");
  expectHas(commands[5], "--shot b --frames=40-40");
  EXPECT_EQ(parseFrames("-3-15"), (FrameRange{-3, 15}));
  EXPECT_EQ(parseFrames("-9--3"), (FrameRange{-9, -3}));
  for (const char* text : {"", "5", "5-", "-5", "5-3", "1-2x", "a-b"})
    EXPECT_FALSE(parseFrames(text)) << text;
  EXPECT_EQ(shellWord("it's"), "'it'\\''s'");
  EXPECT_EQ(shellWord(""), "''");
}

TEST(Plan, AShotWithoutAFolderIsMissing) {
  const TestFolder folder;
  const auto project = required(loadProject(folder.write("p.json", kFine)));
  FileHashes hashes;
  const auto status = required(statusOf(*project, project->shots[0], hashes));
  EXPECT_EQ(status->state, ShotState::kMissing);
  EXPECT_EQ(status->chunks, 3u);
  const auto check = required(verifyShot(*project, project->shots[0], false));
  EXPECT_FALSE(check->complete);
  EXPECT_EQ(check->fault, "chunk 0 is missing or damaged; run the shot again");
}

TEST(Json, LengthsHaveUnits) {
  EXPECT_DOUBLE_EQ(*parseMeters("0.5mm"), 5e-4);
  EXPECT_DOUBLE_EQ(*parseMeters("20 um"), 2e-5);
  EXPECT_DOUBLE_EQ(*parseMeters("1.5"), 1.5);
  for (const char* text : {"", "mm", "1 ft", "nan", "inf", "1mm2"})
    EXPECT_FALSE(parseMeters(text)) << text;
}

}  // namespace
}  // namespace pelage::bake
