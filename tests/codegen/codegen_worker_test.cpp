// Child processes that take one job after the other: whom they blame when they die.
#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include "codegen/process.h"
#include "support/errors.h"
#include "support/test_folder.h"

namespace pelage::codegen {
namespace {

namespace fs = std::filesystem;
using End = ProcessResult::End;
using pelage::test::expectHas;
using pelage::test::TestFolder;

// Speaks the protocol of serveJobs(). What it does depends on the job's name and on how many jobs
// this child has had.
constexpr const char* kChild = R"(#!/bin/bash
count=0
while IFS= read -r -d '' stem; do
  count=$((count + 1))
  echo "$(basename "$stem") $count" >> "$(dirname "$stem")/trace"
  case "$stem" in
    */crash) kill -SEGV $$ ;;
    */late) [ $count -gt 1 ] && kill -SEGV $$ ;;
    */fail) exit 3 ;;
    */leave) exit 0 ;;
    */slow) exec sleep 1000 ;;
  esac
  printf . >&0
done
[ -e "$(dirname "$0")/bad_end" ] && exit 5
exit 0
)";

class CodegenWorker : public testing::Test {
 protected:
  CodegenWorker() { fs::permissions(folder_.write("child", kChild), fs::perms::owner_all); }

  fs::path program() const { return folder_ / "child"; }
  ProcessResult run(const std::string& job, std::chrono::seconds timeout = kLong) {
    return worker_.run(folder_ / job, timeout);
  }
  // "job number" for each job that a child began; the number counts the jobs of that child.
  std::vector<std::string> trace() const {
    std::vector<std::string> lines;
    std::ifstream stream(folder_ / "trace");
    for (std::string line; std::getline(stream, line);) lines.push_back(line);
    return lines;
  }

  static constexpr std::chrono::seconds kLong{300};
  const TestFolder folder_;
  Worker worker_{program()};
};

using Lines = std::vector<std::string>;

TEST_F(CodegenWorker, KeepsOneChildForAllJobs) {
  EXPECT_EQ(run("a").end, End::kDone);
  EXPECT_EQ(run("b").end, End::kDone);
  EXPECT_EQ(run("c").end, End::kDone);
  EXPECT_EQ(worker_.finish().end, End::kDone);
  EXPECT_EQ(trace(), (Lines{"a 1", "b 2", "c 3"}));
}

TEST_F(CodegenWorker, BlamesACrashOnTheJobThatCrashesAlone) {
  EXPECT_EQ(run("a").end, End::kDone);
  const ProcessResult crash = run("crash");
  EXPECT_EQ(crash.end, End::kCrashed);
  expectHas(crash.reason, "signal 11");
  EXPECT_EQ(run("b").end, End::kDone);
  EXPECT_EQ(trace(), (Lines{"a 1", "crash 2", "crash 1", "b 1"}));
}

TEST_F(CodegenWorker, DoesNotBlameAJobForWhatEarlierJobsLeftBehind) {
  EXPECT_EQ(run("a").end, End::kDone);
  EXPECT_EQ(run("late").end, End::kDone);
  EXPECT_EQ(run("b").end, End::kDone);
  EXPECT_EQ(trace(), (Lines{"a 1", "late 2", "late 1", "b 2"}));
}

TEST_F(CodegenWorker, RunsACrashOfAFreshChildOnce) {
  EXPECT_EQ(run("crash").end, End::kCrashed);
  EXPECT_EQ(trace(), (Lines{"crash 1"}));
}

TEST_F(CodegenWorker, TellsFailuresFromCrashes) {
  const ProcessResult failed = run("fail");
  EXPECT_EQ(failed.end, End::kFailed);
  EXPECT_EQ(failed.reason, "exit status 3");
  const ProcessResult left = run("leave");
  EXPECT_EQ(left.end, End::kFailed);
  EXPECT_FALSE(left.reason.empty());
  EXPECT_EQ(run("a").end, End::kDone);
}

TEST_F(CodegenWorker, EndsAChildThatTakesTooLongAndGoesOn) {
  EXPECT_EQ(run("a").end, End::kDone);
  const ProcessResult slow = run("slow", std::chrono::seconds(1));
  EXPECT_EQ(slow.end, End::kTimedOut);
  EXPECT_EQ(slow.reason, "no result after 1 s");
  EXPECT_EQ(run("b").end, End::kDone);
  EXPECT_EQ(std::ranges::count(trace(), "b 1"), 1) << "in a new child";
}

TEST_F(CodegenWorker, SaysThatAChildEndedBadly) {
  std::ofstream(folder_ / "bad_end") << "";
  EXPECT_EQ(run("a").end, End::kDone);
  const ProcessResult end = worker_.finish();
  EXPECT_EQ(end.end, End::kFailed);
  EXPECT_EQ(end.reason, "exit status 5");
  EXPECT_EQ(worker_.finish().end, End::kDone) << "there is no child any more";
}

TEST_F(CodegenWorker, SaysThatAProgramDoesNotStart) {
  Worker missing(folder_ / "missing");
  const ProcessResult result = missing.run(folder_ / "a", kLong);
  EXPECT_EQ(result.end, End::kNotStarted);
  expectHas(result.reason, "missing");
}

}  // namespace
}  // namespace pelage::codegen
