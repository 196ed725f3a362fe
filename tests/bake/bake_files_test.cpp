// Files of bakes: they are there as a whole or not at all, and a process that dies keeps no lock.
#include <gtest/gtest.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <csignal>
#include <limits>
#include <string>
#include <vector>

#include "atomic_file.h"
#include "chunk_writer.h"
#include "error_bound.h"
#include "shot_store.h"
#include "support/errors.h"
#include "support/test_folder.h"

namespace pelage::bake {
namespace {

using test::expectError;
using test::required;
using test::TestFolder;
using test::textOf;

std::span<const std::byte> bytesOf(const std::string& text) {
  return std::as_bytes(std::span(text));
}

size_t fileCount(const TestFolder& folder) {
  size_t count = 0;
  for ([[maybe_unused]] const auto& entry : std::filesystem::directory_iterator(folder.path()))
    ++count;
  return count;
}

TEST(AtomicFile, AppearsWithAllOfItsBytes) {
  const TestFolder folder;
  {
    auto file = required(AtomicFile::create(folder / "a", "1-2"));
    ASSERT_TRUE(file->write(bytesOf("one ")));
    EXPECT_FALSE(std::filesystem::exists(folder / "a"));
    ASSERT_TRUE(file->write(bytesOf("two")));
    ASSERT_TRUE(file->commit());
    EXPECT_EQ(textOf(folder / "a"), "one two");
  }
  EXPECT_EQ(fileCount(folder), 1u);
}

TEST(AtomicFile, LeavesTheOldFileWithoutCommit) {
  const TestFolder folder;
  ASSERT_TRUE(writeAtomic(folder / "a", "1-2", "old"));
  {
    auto file = required(AtomicFile::create(folder / "a", "1-2"));
    ASSERT_TRUE(file->write(bytesOf("new")));
    EXPECT_EQ(fileCount(folder), 2u);
  }
  EXPECT_EQ(textOf(folder / "a"), "old");
  EXPECT_EQ(fileCount(folder), 1u);
}

// As with a full disk: the system writes a part, and refuses the rest.
TEST(AtomicFile, AFullDiskIsAnError) {
  const TestFolder folder;
  const pid_t child = ::fork();
  ASSERT_GE(child, 0);
  if (child == 0) {
    std::signal(SIGXFSZ, SIG_IGN);
    const rlimit limit = {1000, 1000};
    ::setrlimit(RLIMIT_FSIZE, &limit);
    auto file = AtomicFile::create(folder / "a", "1-2");
    const bool refused = file && !file->write(bytesOf(std::string(3000, 'x')));
    ::_exit(refused ? 0 : 1);
  }
  int status = -1;
  ::waitpid(child, &status, 0);
  EXPECT_EQ(status, 0);
  EXPECT_FALSE(std::filesystem::exists(folder / "a"));
}

TEST(AtomicFile, WhatAKilledProcessHasLeftIsRemovedByItsSuccessorAlone) {
  const TestFolder folder;
  const pid_t child = ::fork();
  ASSERT_GE(child, 0);
  if (child == 0) {
    auto file = AtomicFile::create(folder / "a", "1-16");
    if (file) (void)file->write(bytesOf("x"));
    ::kill(::getpid(), SIGKILL);
  }
  int status = 0;
  ::waitpid(child, &status, 0);
  ASSERT_TRUE(WIFSIGNALED(status));
  EXPECT_EQ(fileCount(folder), 1u);
  removeTemporaries(folder.path(), "1-1");
  EXPECT_EQ(fileCount(folder), 1u);
  removeTemporaries(folder.path(), "1-16");
  EXPECT_EQ(fileCount(folder), 0u);
}

TEST(FileLock, IsExclusiveAndGoesWithItsProcess) {
  const TestFolder folder;
  int ready[2];
  ASSERT_EQ(::pipe(ready), 0);
  const pid_t child = ::fork();
  ASSERT_GE(child, 0);
  if (child == 0) {
    const auto lock = FileLock::take(folder / "lock", FileLock::Wait::kYes);
    (void)!::write(ready[1], lock && lock->holds() ? "y" : "n", 1);
    ::pause();
    ::_exit(0);
  }
  char answer = 0;
  ASSERT_EQ(::read(ready[0], &answer, 1), 1);
  EXPECT_EQ(answer, 'y');
  EXPECT_TRUE(FileLock::isHeld(folder / "lock"));
  const auto refused = FileLock::take(folder / "lock", FileLock::Wait::kNo);
  ASSERT_TRUE(refused);
  EXPECT_FALSE(refused->holds());
  ::kill(child, SIGKILL);
  ::waitpid(child, nullptr, 0);
  EXPECT_FALSE(FileLock::isHeld(folder / "lock"));
  const auto taken = FileLock::take(folder / "lock", FileLock::Wait::kYes);
  ASSERT_TRUE(taken);
  EXPECT_TRUE(taken->holds());
}

class Store : public testing::Test {
 protected:
  Store() {
    project_.output = folder_.path();
    shot_.name = "s";
  }
  std::vector<StoredFile> addChunk(const ShotStore& store, uint64_t chunk) {
    const auto path = store.chunkFile("long", chunk);
    EXPECT_TRUE(writeAtomic(path, "t", "bytes of a chunk"));
    const auto file = storedFile(path, path.filename().string());
    EXPECT_TRUE(file);
    EXPECT_TRUE(store.addChunk(chunk, {*file}, "t"));
    return {*file};
  }
  TestFolder folder_;
  Project project_;
  Shot shot_;
};

TEST_F(Store, AChunkIsThereWhileItsBytesAreThoseThatWereWritten) {
  const ShotStore store(project_, shot_);
  ASSERT_TRUE(store.begin(7, "gpu", "t"));
  EXPECT_TRUE(store.chunk(3, true).empty());
  const auto files = addChunk(store, 3);
  EXPECT_EQ(store.chunk(3, true), files);
  ASSERT_TRUE(writeAtomic(store.chunkFile("long", 3), "t", "bytes of A chunk"));
  EXPECT_TRUE(store.chunk(3, true).empty());
  EXPECT_FALSE(store.chunk(3, false).empty());
  ASSERT_TRUE(writeAtomic(store.chunkFile("long", 3), "t", "bytes of"));
  EXPECT_TRUE(store.chunk(3, false).empty());
}

TEST_F(Store, WorkOfOtherInputsOrAnotherDeviceIsRefused) {
  const ShotStore store(project_, shot_);
  ASSERT_TRUE(store.begin(7, "gpu", "t"));
  ASSERT_TRUE(store.begin(7, "gpu", "t"));
  expectError(store.begin(8, "gpu", "t"), "other settings");
  expectError(store.begin(7, "another", "t"), "was begun on 'gpu'");
  ASSERT_TRUE(store.clear());
  EXPECT_TRUE(store.begin(8, "gpu", "t"));
}

TEST_F(Store, DamagedFilesAreErrors) {
  const ShotStore store(project_, shot_);
  ASSERT_TRUE(store.begin(7, "gpu", "t"));
  for (const char* text : {"", "{", "[]", "{\"files\": 1}", "{\"files\": [{\"name\": 1}]}",
                           "{\"files\": [{\"name\": \"a\", \"bytes\": 1, \"xxh3\": \"q\"}]}"}) {
    ASSERT_TRUE(writeAtomic(store.folder() / "done.json", "t", text));
    EXPECT_FALSE(store.done()) << text;
    ASSERT_TRUE(writeAtomic(store.work() / "chunk-000000.json", "t", text));
    EXPECT_TRUE(store.chunk(0, false).empty()) << text;
  }
  ASSERT_TRUE(writeAtomic(store.folder() / "done.json", "t", "{\"files\": []}"));
  EXPECT_TRUE(store.done());
  EXPECT_FALSE(store.fingerprint());
}

TEST_F(Store, EventsAndCheckpointsAreFoundAgain) {
  const ShotStore store(project_, shot_);
  EXPECT_TRUE(store.events().empty());
  ASSERT_TRUE(store.begin(7, "gpu", "t"));
  ASSERT_TRUE(store.log({{"event", "start"}}));
  ASSERT_TRUE(appendLine(store.folder() / "log.jsonl", "{\"half"));
  ASSERT_TRUE(store.log({{"event", "done"}}));
  const auto events = store.events();
  ASSERT_EQ(events.size(), 2u);
  EXPECT_EQ(events[1]["event"], "done");
  for (const uint64_t steps : {64u, 1234567890u, 8u})
    ASSERT_TRUE(writeAtomic(store.checkpointFile(steps), "t", "x"));
  ASSERT_TRUE(writeAtomic(store.work() / "state-x", "t", "x"));
  EXPECT_EQ(store.checkpoints(), (std::vector<uint64_t>{8, 64, 1234567890}));
}

// Two strands of 2 and 3 vertices, in chunks of 4 frames.
class Writer : public Store {
 protected:
  Writer() {
    project_.chunkFrames = 4;
    shot_.frames = {0, 9};
    hairs_ = {{"a", {}, 3, {2, 3}, 5}};
    EXPECT_TRUE(ShotStore(project_, shot_).begin(7, "gpu", "t"));
  }
  std::vector<std::vector<std::byte>> positions(float x) const {
    std::vector<Float4> vertices(6, Float4{x, 0, 0, 0});
    vertices[2].x = std::numeric_limits<float>::quiet_NaN();  // no strand has it
    const auto bytes = std::as_bytes(std::span(vertices));
    return {{bytes.begin(), bytes.end()}};
  }
  std::vector<BakedHair> hairs_;
};

TEST_F(Writer, ChunksAreThereWhenItIsClosedAndAnIncompleteOneLeavesNothing) {
  const ShotStore store(project_, shot_);
  ChunkWriter writer(project_, shot_, hairs_, "t", 2);
  for (int64_t frame = 0; frame < 6; ++frame)
    ASSERT_TRUE(writer.add(static_cast<uint64_t>(frame / 4), frame,
                           positions(0.5f * static_cast<float>(frame))));
  ASSERT_TRUE(writer.close());
  EXPECT_EQ(writer.report().frames, 4u);
  EXPECT_EQ(store.chunk(0, true).size(), 1u);
  EXPECT_TRUE(store.chunk(1, false).empty());
  size_t files = 0;
  for ([[maybe_unused]] const auto& entry : std::filesystem::directory_iterator(store.work()))
    ++files;
  EXPECT_EQ(files, 3u) << "more than key.json, the chunk and its .json";
  auto reader = required(HairCacheReader::open(store.chunkFile("a", 0)));
  std::vector<Float3> out(5);
  ASSERT_TRUE(reader->read(3, out));
  for (const Float3& p : out) EXPECT_NEAR(p.x, 1.5f, 1e-4f);
}

TEST_F(Writer, AnErrorReachesTheNextCallsAndChunksBeforeItStay) {
  const ShotStore store(project_, shot_);
  ChunkWriter writer(project_, shot_, hairs_, "t", 1);
  for (int64_t frame = 0; frame < 4; ++frame) ASSERT_TRUE(writer.add(0, frame, positions(1)));
  ASSERT_TRUE(writer.flush());
  (void)writer.add(1, 4, positions(std::numeric_limits<float>::infinity()));
  expectError(writer.flush(), "shot 's', frame 4");
  EXPECT_FALSE(writer.add(1, 5, positions(1)));
  EXPECT_FALSE(writer.close());
  EXPECT_EQ(store.chunk(0, true).size(), 1u);
}

TEST(SubSteps, TheErrorIsThatOfAShare) {
  std::vector<Float3> a(1000), b(1000);
  for (size_t i = 0; i < b.size(); ++i) b[i] = {0, i < 5 ? 1.0f : 0.001f, 0};
  const auto error = compare(a, b, {1e-2, 0.99});
  ASSERT_TRUE(error);
  EXPECT_FLOAT_EQ(static_cast<float>(error->error), 0.001f);
  EXPECT_FLOAT_EQ(static_cast<float>(error->largest), 1);
  EXPECT_FLOAT_EQ(static_cast<float>(error->mean), (5 * 1 + 995 * 0.001f) / 1000);
  EXPECT_DOUBLE_EQ(error->within, 0.995);
  const auto all = compare(a, b, {1e-4, 1});
  ASSERT_TRUE(all);
  EXPECT_FLOAT_EQ(static_cast<float>(all->error), 1);
  EXPECT_EQ(all->within, 0);
  b[999].z = std::numeric_limits<float>::quiet_NaN();
  EXPECT_FALSE(compare(a, b, {1e-2, 0.99}));
  EXPECT_EQ(sampleSteps(5, 24), (std::vector<std::pair<uint64_t, uint64_t>>{{5, 28}}));
  EXPECT_EQ(sampleSteps(0, 100),
            (std::vector<std::pair<uint64_t, uint64_t>>{{0, 7}, {46, 53}, {92, 99}}));
}

TEST(SubSteps, TheChoiceIsReadBack) {
  const SubStepChoice choice = {
      {1e-3, 0.9},
      {{1, 2e-3, 1e-3, 4e-3, 0.5, 0.1, 0.2}, {2, 5e-4, 2e-4, 1e-3, 0.95, 0.2, 0.4}},
      3e-6};
  const auto read = subStepsOf(toJson(choice), "x");
  ASSERT_TRUE(read);
  ASSERT_EQ(read->tried.size(), 2u);
  EXPECT_EQ(read->tried[1].subSteps, 2u);
  EXPECT_EQ(read->tried[1].error, 5e-4);
  EXPECT_EQ(read->tried[1].within, 0.95);
  EXPECT_EQ(read->bound.share, 0.9);
  EXPECT_EQ(read->sensitivity, 3e-6);
  EXPECT_FALSE(subStepsOf(nlohmann::json::parse("{\"bound\": 1, \"tried\": []}"), "x"));
  EXPECT_FALSE(subStepsOf(nlohmann::json::parse("[1]"), "x"));
}

}  // namespace
}  // namespace pelage::bake
