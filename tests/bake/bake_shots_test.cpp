// Several shots in one process: the files are those of a process each, and what happens to one shot
// is of no effect on the others.
#include <gtest/gtest.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <atomic>
#include <chrono>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "atomic_file.h"
#include "pelage/hair_asset.h"
#include "shot_run.h"
#include "shot_store.h"
#include "support/errors.h"
#include "support/plain_asset.h"
#include "support/required_devices.h"
#include "support/test_folder.h"

namespace pelage::bake {
namespace {

using nlohmann::json;
using test::expectHas;
using test::required;
using test::runIn;
using test::TestFolder;
using test::textOf;
using test::valueOf;

// A shot of a generated head without a collider.
std::string shotText(const std::string& name, int seed, int lastFrame = 12) {
  return R"({"name": ")" + name + R"(", "frames": [1, )" + std::to_string(lastFrame) +
         R"(], "collides": false, "animation": {"motion": "shake"}, "assets":
         {"generated": {"kind": "head", "guides": 6, "seed": )" +
         std::to_string(seed) + "}}}";
}

class Shots : public testing::Test {
 protected:
  void SetUp() override {
    const auto device = openDevice(Api::kVulkan, "");
    if (!device) PELAGE_SKIP_WITHOUT_DEVICE() << device.error().message;
  }
  /// Writes OUTPUT.json.
  Project load(const std::string& output, const std::vector<std::string>& shots) {
    std::string text;
    for (const std::string& shot : shots) text += (text.empty() ? "" : ", ") + shot;
    return valueOf(loadProject(folder_.write(
        output + ".json", R"({"version": 1, "chunkFrames": 4, "checkpointChunks": 1, "output": ")" +
                              output + R"(", "shots": [)" + text + "]}")));
  }
  test::ProgramOutput bake(const std::string& arguments) {
    return runIn(folder_.path(), std::string("'") + PELAGE_BAKE + "' " + arguments);
  }
  /// Fails unless a shot has the same files in both projects.
  static void expectSame(const Project& one, const Project& other, const std::string& shot) {
    for (const char* name : {"head.pelagecache", "done.json"}) {
      const std::string bytes = textOf(one.output / shot / name);
      EXPECT_FALSE(bytes.empty()) << shot << "/" << name;
      EXPECT_TRUE(bytes == textOf(other.output / shot / name)) << shot << "/" << name;
    }
  }
  TestFolder folder_;
};

TEST_F(Shots, OfOneProcessHaveTheBytesOfAProcessEach) {
  std::vector<std::string> texts;
  for (int i = 0; i < 6; ++i) texts.push_back(shotText("s" + std::to_string(i), 1 + i / 3, 9 + i));
  const Project together = load("together", texts), apart = load("apart", texts);
  for (const Shot& shot : apart.shots)
    EXPECT_EQ(bake("run apart.json --quiet --shot " + shot.name).code, 0);
  // Two of the six, then all.
  const auto two = bake("run --shot s4 --shot s1 together.json --json");
  EXPECT_EQ(two.code, 0) << two.errors;
  const json first = json::parse(two.out);
  ASSERT_EQ(first["shots"].size(), 2u);
  EXPECT_EQ(first["shots"][0]["shot"], "s4");
  EXPECT_EQ(first["shots"][1]["frames_written"], 10);
  const auto all = bake("run together.json --jobs 3 --threads 2 --json");
  EXPECT_EQ(all.code, 0) << all.errors;
  const json report = json::parse(all.out);
  ASSERT_EQ(report["shots"].size(), 6u);
  EXPECT_EQ(report["frames_simulated"], 9 + 11 + 12 + 14);
  EXPECT_EQ(report["failed"], json::array());
  EXPECT_GT(report["busy_seconds"].get<double>(), 0);
  EXPECT_LT(report["busy_seconds"].get<double>(), report["wall_seconds"].get<double>());
  for (size_t i = 0; i < together.shots.size(); ++i) {
    EXPECT_EQ(report["shots"][i]["shot"], together.shots[i].name);
    EXPECT_EQ(report["shots"][i]["was_complete"], i == 1 || i == 4);
    expectSame(apart, together, together.shots[i].name);
  }
}

// A shot fails as it begins, one as it loads, and another process has a third.
TEST_F(Shots, GoOnWhenOthersFailOrAreBusy) {
  (void)folder_.write("bad.tfx", "no hair");
  const auto file = [](const char* name, const char* hair) {
    return std::string(R"({"name": ")") + name + R"(", "frames": [1, 4],
      "assets": {"hairs": [{"file": ")" +
           hair + R"("}]}})";
  };
  const Project project = load("some", {file("missing", "none.tfx"), shotText("busy", 1),
                                        file("bad", "bad.tfx"), shotText("fine", 1)});
  const ShotStore store(project, *project.find("busy"));
  ASSERT_TRUE(makeFolder(store.folder()));
  std::optional<FileLock> lock =
      *required(FileLock::take(store.lockPath(FrameRange{1, 12}), FileLock::Wait::kNo));
  const auto some = bake("run some.json --jobs 2 --no-wait --json");
  EXPECT_EQ(some.code, 1);
  expectHas(some.errors, "missing: ");
  expectHas(some.errors, "none.tfx");
  expectHas(some.errors, "bad: ");
  const json report = json::parse(some.out);
  EXPECT_EQ(report["failed"], json::array({"missing", "bad"}));
  EXPECT_EQ(report["shots"][1]["outcome"], "busy");
  EXPECT_EQ(report["shots"][3]["outcome"], "complete");
  expectHas(report["shots"][2]["error"].get<std::string>(), "bad.tfx");
  EXPECT_EQ(ShotStore(project, *project.find("bad")).events().at(0)["event"], "error");
  EXPECT_EQ(bake("run some.json --no-wait --shot busy,fine").code, 75);
  lock.reset();
  EXPECT_EQ(bake("run some.json --no-wait --shot busy,fine").code, 0);
  // A range is of whole chunks in one of two.
  const Project ranges = load("ranges", {shotText("long", 1, 12), shotText("short", 1, 6)});
  const auto range = bake("run ranges.json --frames 1-7");
  EXPECT_EQ(range.code, 1);
  expectHas(range.errors, "short: frames 1-7 are not whole chunks");
  expectHas(range.out, "range done");
}

TEST_F(Shots, AreNamedOnce) {
  (void)load("names", {shotText("a", 1), shotText("b", 1)});
  for (const auto& [shots, word] :
       {std::pair("a,c", "has no shot 'c'"), std::pair("a --shot a", "'a' is given twice")}) {
    const auto run = bake(std::string("run names.json --shot ") + shots);
    EXPECT_EQ(run.code, 1);
    expectHas(run.errors, word);
  }
  EXPECT_EQ(bake("run names.json --jobs 0").code, 2);
  EXPECT_FALSE(std::filesystem::exists(folder_ / "names")) << "nothing has run";
}

// Whatever each of them is doing, a signal ends all with a checkpoint, and they go on from it.
TEST_F(Shots, EndWithACheckpointEachWhenTheProcessIsInterrupted) {
  std::vector<std::string> texts;
  for (int i = 0; i < 4; ++i) texts.push_back(shotText("s" + std::to_string(i), 1, 4000));
  const Project project = load("stopped", texts);
  const std::string path = project.file.string();
  const pid_t child = ::fork();
  if (child == 0) {
    ::execl(PELAGE_BAKE, PELAGE_BAKE, "run", path.c_str(), "--quiet", "--jobs=3", nullptr);
    ::_exit(127);
  }
  // Each of the first three has written a chunk.
  for (int i = 0; i < 3; ++i) {
    const ShotStore store(project, project.shots[static_cast<size_t>(i)]);
    for (int wait = 0; wait < 6000 && store.chunk(0, false).empty(); ++wait)
      std::this_thread::sleep_for(std::chrono::milliseconds(10));
  }
  ::kill(child, SIGTERM);
  int status = -1;
  ::waitpid(child, &status, 0);
  EXPECT_TRUE(WIFEXITED(status));
  EXPECT_EQ(WEXITSTATUS(status), 75);
  for (const Shot& shot : project.shots) {
    const ShotStore store(project, shot);
    const bool ran = shot.name != "s3";
    EXPECT_EQ(std::filesystem::exists(store.folder()), ran);
    if (!ran) continue;
    EXPECT_EQ(store.events().back()["event"], "interrupted");
    // No frame runs again: the chunks are complete up to the checkpoint.
    const auto checkpoints = store.checkpoints();
    ASSERT_FALSE(checkpoints.empty()) << shot.name;
    EXPECT_EQ(checkpoints.back() % 4, 3u);
    EXPECT_FALSE(store.chunk(checkpoints.back() / 4, false).empty());
    EXPECT_TRUE(store.chunk(checkpoints.back() / 4 + 1, false).empty());
  }
}

TEST_F(Shots, InterruptedTogetherGiveTheSameBytes) {
  const std::vector<std::string> texts = {shotText("a", 1, 20), shotText("b", 1, 20),
                                          shotText("c", 2, 20)};
  const Project whole = load("whole", texts), parts = load("parts", texts);
  for (const auto& run : runShots(whole, whole.shots, {}, 3).shots) (void)required(run);
  std::atomic<bool> stop = false;
  RunOptions options;
  options.graceSeconds = 600;
  options.interrupted = [&] { return stop.load(); };
  options.progress = [&](uint64_t done, uint64_t total) {
    EXPECT_LE(done, total);
    EXPECT_EQ(total, 60u);
    if (done > 25) stop = true;
  };
  const auto stopped = runShots(parts, parts.shots, options, 2);
  uint64_t steps = 0;
  for (const auto& run : stopped.shots) {
    const auto report = required(run);
    steps += report->stepsRun;
    EXPECT_EQ(report->stepsRun % 4, report->stepsRun == 0 || report->stepsRun == 20 ? 0u : 3u);
  }
  EXPECT_GT(steps, 25u);
  EXPECT_LT(steps, 40u);
  stop = false;
  options.progress = {};
  for (const auto& run : runShots(parts, parts.shots, options, 2).shots)
    steps += required(run)->stepsRun;
  EXPECT_EQ(steps, 60u) << "a frame ran twice";
  for (const Shot& shot : parts.shots) expectSame(whole, parts, shot.name);
}

// Runs share a groom while its files stay; one that has changed is loaded anew.
TEST(SharedAssets, AreLoadedOnceUntilAFileChanges) {
  const TestFolder folder;
  ASSERT_TRUE(saveTfx(test::makeAsset(12, 8), folder / "hair.tfx"));
  const auto project =
      required(loadProject(folder.write("p.json", R"({"version": 1, "output": "o", "shots": [
      {"name": "a", "frames": [1, 4], "assets": {"hairs": [{"file": "hair.tfx"}]}},
      {"name": "b", "frames": [1, 9], "assets": {"hairs": [{"file": "hair.tfx"}]}},
      {"name": "c", "frames": [1, 9], "assets": {"hairs": [{"file": "hair.tfx"}], "scale": 2}}]})")));
  RunResources resources(2);
  const auto hairOf = [&](size_t shot) {
    return required(resources.inputs(project->shots[shot]))->hairs.at(0).hair;
  };
  const auto first = hairOf(0);
  EXPECT_EQ(hairOf(1), first);
  const auto scaled = hairOf(2);
  EXPECT_EQ(scaled->asset.positions.at(1).x, 2 * first->asset.positions.at(1).x);
  ASSERT_TRUE(saveTfx(test::makeAsset(13, 8), folder / "hair.tfx"));
  EXPECT_EQ(hairOf(1)->asset.strandCount, 13u);
  EXPECT_EQ(first->asset.strandCount, 12u);
}

}  // namespace
}  // namespace pelage::bake
