// Runs of shots: whatever ends them, the next one goes on, and the files are those of an
// undisturbed run.
#include <gtest/gtest.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <csignal>
#include <cstdlib>
#include <map>
#include <optional>
#include <sstream>
#include <string>
#include <thread>
#include <vector>

#include "bake/point_file.h"
#include "checkpoint.h"
#include "pelage/hair_cache.h"
#include "pelage/skeleton.h"
#include "plan.h"
#include "shot_run.h"
#include "shot_store.h"
#include "support/errors.h"
#include "support/extremes.h"
#include "support/plain_asset.h"
#include "support/required_devices.h"
#include "support/test_folder.h"

namespace pelage::bake {
namespace {

using test::expectError;
using test::expectHas;
using test::required;
using test::TestFolder;
using test::textOf;
using test::valueOf;

// A box of 6 cm below the strands, of which one half follows another bone.
CollisionMesh box() {
  CollisionMesh mesh;
  mesh.bones = {{0, "head"}, {1, "neck"}};
  for (int corner = 0; corner < 8; ++corner) {
    mesh.positions.push_back({(corner & 1) != 0 ? 0.10f : 0.04f, (corner & 2) != 0 ? 0.0f : -0.06f,
                              (corner & 4) != 0 ? 0.03f : -0.03f});
    mesh.normals.push_back({0, 1, 0});
    BoneInfluences bone;
    bone.bones[0] = (corner & 1) != 0 ? 1 : 0;
    bone.weights[0] = 1;
    mesh.influences.push_back(bone);
  }
  mesh.indices = {0, 2, 1, 1, 2, 3, 4, 5, 6, 5, 7, 6, 0, 1, 4, 1, 5, 4,
                  2, 6, 3, 3, 6, 7, 0, 4, 2, 2, 4, 6, 1, 3, 5, 3, 7, 5};
  return mesh;
}

class Bake : public testing::Test {
 protected:
  void SetUp() override {
    const auto device = openDevice(Api::kVulkan, "");
    if (!device) PELAGE_SKIP_WITHOUT_DEVICE() << device.error().message;
    uuid_ = (*device)->info().uuid;
    const HairAsset asset = test::makeAsset(12, 8);
    ASSERT_TRUE(saveTfx(asset, folder_ / "hair.tfx"));
    saveBone("head", "hair.tfxbone");
    ASSERT_TRUE(saveTfxMesh(box(), folder_ / "box.tfxmesh"));
    (void)folder_.write("soft.json",
                        R"({"simulation": {"bendLength": 0.05, "wind": {"velocity": [1, 0, 0.5]},
                            "contact": {"stiffness": 0.3}}})");
  }

  // All strands on one bone.
  void saveBone(const char* bone, const char* file) {
    BoneWeights weights;
    weights.bones = {{0, bone}};
    weights.strands.assign(12, {{0, 0, 0, 0}, {1, 0, 0, 0}});
    ASSERT_TRUE(saveTfxBone(weights, folder_ / file));
  }
  Project load(const std::string& output, const std::string& more = "") {
    const auto path = folder_.write(output + ".json", R"({"version": 1, "output": ")" + output +
                                                          R"(", "chunkFrames": 4,
      "checkpointChunks": 1, "shots": [{"name": "s", "frames": [1, 18], "preRoll": 2,
      "assets": {"hairs": [{"file": "hair.tfx", "bones": "hair.tfxbone"}],
                 "colliders": ["box.tfxmesh"]},
      "animation": {"motion": "shake", "start": 0.4}, "settings": "soft.json")" +
                                                          more + "}]}");
    return valueOf(loadProject(path));
  }
  RunReport runAll(const Project& project, const RunOptions& options = {}) {
    return valueOf(runShot(project, project.shots[0], options));
  }
  /// The cache of a run that nothing disturbs.
  const std::string& expected() {
    static std::string bytes;
    if (bytes.empty()) {
      const Project project = load("expected");
      (void)runAll(project);
      bytes = cacheOf(project);
      EXPECT_FALSE(bytes.empty());
    }
    return bytes;
  }
  static std::string cacheOf(const Project& project) {
    return textOf(project.output / "s" / "hair.pelagecache");
  }
  /// Starts the program. \param fileBytes  largest size of a file; 0: any
  static pid_t start(const Project& project, rlim_t fileBytes = 0) {
    const std::string path = project.file.string();
    const pid_t child = ::fork();
    if (child != 0) return child;
    if (fileBytes > 0) {
      const rlimit limit = {fileBytes, fileBytes};
      ::setrlimit(RLIMIT_FSIZE, &limit);
    }
    ::execl(PELAGE_BAKE, PELAGE_BAKE, "run", path.c_str(), "--shot", "s", "--quiet", nullptr);
    ::_exit(127);
  }
  static int wait(pid_t child) {
    int status = -1;
    ::waitpid(child, &status, 0);
    return status;
  }
  uint32_t startsOf(const Project& project) {
    FileHashes hashes;
    const auto status = statusOf(project, project.shots[0], hashes);
    EXPECT_TRUE(status);
    return status ? status->starts : 0;
  }

  TestFolder folder_;
  std::string uuid_;
};

// Contents of every buffer of a scene, by name.
std::map<std::string, std::vector<std::byte>> stateOf(ShotScene& scene, HeadlessDevice& device) {
  std::map<std::string, std::vector<std::byte>> state;
  const ResourceTable& table = scene.scene().resources();
  for (uint32_t slot = 0; slot < table.end(); ++slot) {
    if (table.at(slot) == BufferId::kInvalid) continue;
    auto bytes = device.read(table.at(slot));
    EXPECT_TRUE(bytes) << bytes.error().message;
    const std::string name = std::to_string(slot) + " " + table.find(table.at(slot))->name;
    if (bytes) state[name] = *std::move(bytes);
  }
  return state;
}

TEST_F(Bake, ACheckpointHasAllOfTheState) {
  const Project project = load("state");
  const Shot& shot = project.shots[0];
  const auto inputs = required(loadShot(shot));
  auto device = required(openDevice(Api::kVulkan, ""));
  auto scene = required(ShotScene::create(*inputs, shot, project.framesPerSecond));
  const uint64_t last = scene->stepCount();
  constexpr uint64_t kBetween = 8;
  std::vector<std::map<std::string, std::vector<std::byte>>> expected;
  for (uint64_t step = 0; step < last; ++step) {
    ASSERT_TRUE(scene->run(step, **device));
    expected.push_back(stateOf(*scene, **device));
    if (step % kBetween == 0) {
      const auto path = folder_ / std::to_string(step + 1);
      ASSERT_TRUE(saveCheckpoint(path, "t", {1, step + 1, "gpu"}, *scene, **device));
    }
  }
  for (uint64_t from = 1; from < last; from += kBetween) {
    device = openDevice(Api::kVulkan, "");
    ASSERT_TRUE(device);
    auto again = required(ShotScene::create(*inputs, shot, project.framesPerSecond));
    const auto path = folder_ / std::to_string(from);
    ASSERT_TRUE(loadCheckpoint(path, {1, from, "gpu"}, *again));
    for (uint64_t step = from; step < std::min(from + 3, last); ++step) {
      ASSERT_TRUE(again->run(step, **device));
      const auto state = stateOf(*again, **device);
      ASSERT_EQ(state.size(), expected[step].size());
      for (const auto& [name, bytes] : expected[step]) {
        // Lists that threads fill in any order.
        if (name.ends_with("box/work")) continue;
        EXPECT_TRUE(state.at(name) == bytes)
            << name << " behind step " << step << ", from " << from;
      }
    }
    EXPECT_FALSE(loadCheckpoint(path, {2, from, "gpu"}, *again));
    EXPECT_FALSE(loadCheckpoint(path, {1, from, "another"}, *again));
  }
}

// A checkpoint has all of the state: skin, SDF, contacts, hair against hair, wind.
TEST_F(Bake, GoesOnBehindAnInterruptionAtAnyFrame) {
  const Project whole = load("whole");
  const RunReport undisturbed = runAll(whole);
  EXPECT_EQ(undisturbed.outcome, RunOutcome::kComplete);
  EXPECT_EQ(undisturbed.stepsRun, 20u);
  EXPECT_EQ(undisturbed.framesWritten, 18u);
  EXPECT_TRUE(cacheOf(whole) == expected()) << "another run has other bits";
  EXPECT_FALSE(std::filesystem::exists(whole.output / "s" / "work"));
  const auto reader = required(HairCacheReader::open(whole.output / "s" / "hair.pelagecache"));
  EXPECT_EQ(reader->frameCount(), 18u);
  EXPECT_EQ(reader->def().firstFrame, 1);

  const Project project = load("parts");
  uint64_t steps = 0;
  RunReport report;
  int runs = 0;
  do {
    ASSERT_LT(++runs, 20);
    uint64_t left = 6;
    RunOptions options;
    options.interrupted = [&] { return left == 0; };
    options.progress = [&](uint64_t, uint64_t) { --left; };
    report = runAll(project, options);
    steps += report.stepsRun;
    EXPECT_TRUE(runs == 1 || report.resumedSteps > 0);
  } while (report.outcome == RunOutcome::kInterrupted);
  EXPECT_GE(runs, 4);
  EXPECT_LT(steps, 20u + 4u * static_cast<uint64_t>(runs));
  EXPECT_TRUE(cacheOf(project) == expected());
  EXPECT_EQ(textOf(project.output / "s" / "done.json"), textOf(whole.output / "s" / "done.json"));

  // With time to go on to the end of a chunk, no frame is simulated twice: interrupted in the
  // pre-roll, and in the second chunk.
  const Project graced = load("graced");
  steps = 0;
  for (const uint64_t frames : {1u, 6u, 100u}) {
    uint64_t left = frames;
    RunOptions options;
    options.graceSeconds = 600;
    options.interrupted = [&] { return left == 0; };
    options.progress = [&](uint64_t, uint64_t) { left -= left > 0 ? 1 : 0; };
    report = runAll(graced, options);
    EXPECT_EQ(report.resumedSteps, steps);
    steps += report.stepsRun;
    EXPECT_EQ(steps, frames == 1 ? 1u : frames == 6 ? 9u : 20u);
  }
  EXPECT_EQ(report.outcome, RunOutcome::kComplete);
  EXPECT_TRUE(cacheOf(graced) == expected());

  // A complete shot is left alone; a change of its inputs is noticed.
  report = runAll(project);
  EXPECT_TRUE(report.wasComplete);
  EXPECT_EQ(report.stepsRun, 0u);
  const auto check = required(verifyShot(project, project.shots[0], true));
  EXPECT_TRUE(check->complete);
  EXPECT_EQ(check->fault, "");
  const auto stateNow = [&](bool hashed) {
    FileHashes hashes;
    const auto status = required(statusOf(project, project.shots[0], hashes, hashed));
    EXPECT_EQ(status->state == ShotState::kDamaged,
              status->fault.find("--restart") != std::string::npos);
    return status->state;
  };
  EXPECT_EQ(stateNow(true), ShotState::kComplete);

  // A byte that has changed, and a file that has become shorter.
  const auto path = project.output / "s" / "hair.pelagecache";
  const std::string good = cacheOf(project);
  std::string bad = good;
  bad[bad.size() / 2] ^= 1;
  (void)folder_.write(path.string(), bad);
  EXPECT_EQ(stateNow(true), ShotState::kDamaged);
  expectError(runShot(project, project.shots[0], {}), {"hair.pelagecache", "--restart"});
  expectHas(required(verifyShot(project, project.shots[0], false))->fault,
            project.file.string() + " --shot s --restart");
  (void)folder_.write(path.string(), good.substr(1));
  EXPECT_EQ(stateNow(false), ShotState::kDamaged);
  (void)folder_.write(path.string(), good);
  const auto donePath = project.output / "s" / "done.json";
  const std::string done = textOf(donePath);
  (void)folder_.write(donePath.string(), done.substr(1));
  EXPECT_EQ(stateNow(false), ShotState::kDamaged);
  expectError(runShot(project, project.shots[0], {}), {"done.json", "--restart"});
  (void)folder_.write(donePath.string(), done);
  EXPECT_EQ(stateNow(true), ShotState::kComplete);

  const Project changed = load("parts", ", \"subSteps\": 2");
  expectError(runShot(changed, changed.shots[0], {}), "--restart");
  FileHashes hashes;
  EXPECT_EQ(statusOf(changed, changed.shots[0], hashes)->state, ShotState::kStale);
}

// In any order, also where frames before are not there; a damaged checkpoint is not gone on from.
TEST_F(Bake, RangesGiveTheFilesOfTheWhole) {
  const Project project = load("ranges");
  RunOptions options;
  options.device = uuid_;
  options.range = FrameRange{4, 11};
  EXPECT_EQ(runAll(project, options).outcome, RunOutcome::kRangeDone);
  const ShotStore store(project, project.shots[0]);
  ASSERT_EQ(store.checkpoints().size(), 1u);
  std::filesystem::resize_file(store.checkpointFile(store.checkpoints()[0]), 2000);
  options.range = FrameRange{12, 18};
  std::string warning;
  options.warn = [&](const std::string& text) { warning = text; };
  const RunReport late = runAll(project, options);
  EXPECT_EQ(late.resumedSteps, 0u);
  expectHas(warning, "ends too early");
  options.range = FrameRange{1, 3};
  EXPECT_EQ(runAll(project, options).outcome, RunOutcome::kComplete);
  EXPECT_TRUE(cacheOf(project) == expected());
  options.range = FrameRange{5, 11};
  expectError(runShot(project, project.shots[0], options), "whole chunks");
}

TEST_F(Bake, KilledAnywhereAndWithAFullDiskItGivesTheSameBytes) {
  const Project whole = load("whole");
  const auto begin = std::chrono::steady_clock::now();
  ASSERT_EQ(wait(start(whole)), 0);
  const auto time = std::chrono::steady_clock::now() - begin;
  const Project project = load("killed");
  // The disk is full in a chunk, then behind chunks in a checkpoint.
  EXPECT_NE(wait(start(project, 300)), 0);
  EXPECT_NE(wait(start(project, 4000)), 0);
  for (int i = 1; i <= 5; ++i) {
    const pid_t child = start(project);
    std::this_thread::sleep_for(time * (3 + i) / 10);
    ::kill(child, SIGKILL);
    (void)wait(child);
  }
  // Two at once: one waits for the other.
  const pid_t first = start(project), second = start(project);
  EXPECT_EQ(wait(first), 0);
  EXPECT_EQ(wait(second), 0);
  const uint32_t starts = startsOf(project);
  EXPECT_TRUE(cacheOf(project) == cacheOf(whole));
  // As if it had been killed between done.json and the removal of its work.
  std::filesystem::create_directory(project.output / "s" / "work");
  EXPECT_EQ(wait(start(project)), 0);
  EXPECT_EQ(startsOf(project), starts);
  size_t files = 0;
  for (const auto& entry : std::filesystem::directory_iterator(project.output / "s"))
    files += entry.path().filename().string().rfind("lock", 0) == 0 ? 0 : 1;
  EXPECT_EQ(files, 3u) << "more than cache, done.json and log.jsonl";
}

// The motion of a frame: a rotation about z and a displacement, both growing.
AffineTransform motionAt(int frame) {
  const float angle = 0.06f * static_cast<float>(frame);
  return rigidTransform({0, 0, std::sin(angle / 2), std::cos(angle / 2)},
                        {0.01f * static_cast<float>(frame), 0, 0});
}

// The same motion by bones, and by the vertices of a mesh with the roots on it: the same hair but
// for rounding. Both collide with that mesh. An interrupted run has the same bits.
TEST_F(Bake, HairFollowsAPointCacheAsItFollowsBones) {
  constexpr int kFrames = 10;
  std::vector<float> transforms;
  std::vector<std::vector<Float3>> samples;
  CollisionMesh mesh = box();  // beside the strands, which lean on it
  for (Float3& p : mesh.positions) p = {p.x > 0.05f ? 0.2f : 0.115f, p.y + 0.06f, 2 * p.z};
  std::ostringstream obj;
  for (const Float3& p : mesh.positions) obj << "v " << p.x << " " << p.y << " " << p.z << "\n";
  for (size_t i = 0; i < mesh.indices.size(); ++i)
    obj << (i % 3 == 0 ? "\nf " : " ") << mesh.indices[i] + 1;
  for (int frame = 0; frame < kFrames; ++frame) {
    const AffineTransform motion = motionAt(frame);
    for (const Float4& row : motion.rows)
      transforms.insert(transforms.end(), {row.x, row.y, row.z, row.w});
    samples.emplace_back();
    for (const Float3& p : mesh.positions) samples.back().push_back(transformPoint(motion, p));
  }
  (void)folder_.write("skin.obj", obj.str());
  (void)folder_.write("skin.pc2", test::pointFile(8, 1, samples));
  (void)folder_.write("bones.bin", test::bytesOfFloats(transforms));
  (void)folder_.write("bones.json",
                      R"({"version": 1, "fps": 24, "bones": ["all"], "data": "bones.bin"})");
  saveBone("all", "all.tfxbone");
  CollisionMesh moved = mesh;
  moved.bones = {{0, "all"}};
  moved.influences.assign(8, {{0, 0, 0, 0}, {1, 0, 0, 0}});
  ASSERT_TRUE(saveTfxMesh(moved, folder_ / "skin.tfxmesh"));
  const auto load = [&](const std::string& name, const char* hair, const char* animation) {
    return valueOf(loadProject(folder_.write(
        name + ".json", R"({"version": 1, "chunkFrames": 4, "checkpointChunks": 1, "output": ")" +
                            name + R"(", "shots": [{"name": "s", "frames": [1, 10], "settings":
                            "soft.json", "assets": {"hairs": [{"file": "hair.tfx")" +
                            hair + R"(, "animation": {)" + animation + "}}]}")));
  };
  const Project bones =
      load("bones_", R"(, "bones": "all.tfxbone"}], "colliders": ["skin.tfxmesh"]})",
           R"("transforms": "bones.json")");
  const char* const kPoints = R"("points": "skin.pc2", "mesh": "skin.obj")";
  const Project points = load("points", "}]}", kPoints);
  (void)runAll(bones);
  (void)runAll(points);
  auto byBones = HairCacheReader::open(bones.output / "s" / "hair.pelagecache");
  auto byPoints = HairCacheReader::open(points.output / "s" / "hair.pelagecache");
  ASSERT_TRUE(byBones && byPoints);
  std::vector<Float3> expected(12 * 8), found(12 * 8);
  double difference = 0;
  for (int frame = 0; frame < kFrames; ++frame) {
    ASSERT_TRUE(byBones->read(static_cast<uint64_t>(frame), expected));
    ASSERT_TRUE(byPoints->read(static_cast<uint64_t>(frame), found));
    const Float3 root = transformPoint(motionAt(frame), {0.03f, 0, 0});
    EXPECT_NEAR(found[size_t{3} * 8].x, root.x, 2e-4f) << frame;
    EXPECT_NEAR(found[size_t{3} * 8].y, root.y, 2e-4f) << frame;
    for (size_t i = 0; i < found.size(); ++i)
      test::keepLargest(difference,
                        std::hypot(found[i].x - expected[i].x, found[i].y - expected[i].y,
                                   found[i].z - expected[i].z));
  }
  EXPECT_LT(difference, 0.01) << "contact amplifies rounding; without it they are 39 mm apart";

  const Project parts = load("points_parts", "}]}", kPoints);
  int left = 6;
  RunOptions options;
  options.interrupted = [&] { return left == 0; };
  options.progress = [&](uint64_t, uint64_t) { --left; };
  EXPECT_EQ(runAll(parts, options).outcome, RunOutcome::kInterrupted);
  EXPECT_GT(runAll(parts).resumedSteps, 0u);
  EXPECT_TRUE(cacheOf(parts) == cacheOf(points));

  // A cache of another mesh, and hair that nothing moves.
  samples.assign(2, std::vector<Float3>(7));
  (void)folder_.write("skin.pc2", test::pointFile(7, 1, samples));
  expectError(loadShot(points.shots[0]), "byte 16: has 7 points");
  EXPECT_FALSE(loadShot(load("none", "}]}", R"("transforms": "bones.json")").shots[0]));
}

TEST_F(Bake, AnErrorBoundChoosesTheSubSteps) {
  const auto errorWith = [&](const char* bound) {
    Project project =
        load(std::string("bound") + bound, std::string(", \"errorBound\": \"") + bound + "\"");
    project.shots[0].frames.last = 8;
    RunOptions options;
    options.interrupted = [] { return true; };
    return runShot(project, project.shots[0], options);
  };
  const auto loose = required(errorWith("20mm"));
  ASSERT_TRUE(loose->choice);
  EXPECT_EQ(loose->subSteps, 1u);
  const SubStepError& one = loose->choice->tried.back();
  EXPECT_GT(one.error, 0);
  EXPECT_LE(one.error, one.largest);
  const std::string tighter = std::to_string(one.error * 0.6e6) + "um";
  const auto tight = required(errorWith(tighter.c_str()));
  EXPECT_GT(tight->subSteps, 1u);
  EXPECT_LE(tight->choice->tried.back().error, one.error * 0.6);
  EXPECT_EQ(tight->choice->tried.back().subSteps, tight->subSteps);
  EXPECT_EQ(tight->choice->tried.front().error, one.error) << "the same samples";
}

// Strands that lie on a head that shakes: a difference of a millionth of gravity becomes one of
// millimeters, which no number of sub-steps can be told from.
TEST_F(Bake, ContactsThatMultiplyDifferencesAreNamed) {
  const auto project = required(loadProject(folder_.write(
      "sensitive.json",
      R"({"version": 1, "output": "sensitive", "shots": [{"name": "s", "frames": [1, 6],
      "assets": {"generated": {"kind": "head", "guides": 40}}, "animation": {"motion": "shake"},
      "errorBound": "1um", "errorShare": 0.95}]})")));
  Shot finer = project->shots[0];
  finer.cellSize = 0.004;
  const auto inputs = required(loadShot(finer));
  EXPECT_EQ(inputs->cellSizes, std::vector<float>{0.004f});
  const auto done = runShot(*project, project->shots[0], {});
  ASSERT_FALSE(done);
  const std::string& message = done.error().message;
  expectHas(message, "95 % of the vertices are not kept within 0.001 mm");
  expectHas(message, "mm with 2 sub-steps. More were not tried: 1e-5 m/s2 more of gravity");
}

}  // namespace
}  // namespace pelage::bake
