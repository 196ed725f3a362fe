// The order in which an executor gets the lists of a frame, and where a run ends.
#include <gtest/gtest.h>

#include <string>
#include <utility>

#include "pelage/frame.h"
#include "pelage/scene.h"
#include "support/errors.h"
#include "support/plain_asset.h"
#include "support/views.h"

namespace pelage::test {
namespace {

class FrameOrder : public testing::Test {
 protected:
  void SetUp() override { ASSERT_TRUE(scene_.addHair(makeAsset(), {})); }
  static View view() {
    return cameraView({.eye = {0, 0.04f, 0.5f}, .target = {0, 0.04f, 0}, .width = 100});
  }
  Frame begin() { return *required(scene_.simulate(1.0f / 60)); }
  // "u": update; of each list the name of its first pass, and "d" and the view for draws.
  FrameExecutor executor(const std::string& failing = "") {
    FrameExecutor executor;
    const auto note = [this, failing](const std::string& call) -> Result<void> {
      calls_ += call + " ";
      if (call == failing) return Error{ErrorCode::kOutOfMemory, "as the test wants it"};
      return {};
    };
    executor.update = [note](const ResourceTable&) { return note("u"); };
    executor.record = [note](const FrameStep& step) -> Result<void> {
      if (Result<void> ready = checkRun(*step.list); !ready) return ready;
      const bool empty = step.list->passes.empty();
      Result<void> done = note(empty ? "-" : step.list->passes[0].name);
      if (done) setDelivered(step.list->run);
      return done;
    };
    executor.draw = [note](const FrameStep& step) {
      return note("d" + std::to_string(step.view) + "." + std::to_string(step.listOfView));
    };
    return executor;
  }

  Scene scene_;
  std::string calls_;
};

TEST_F(FrameOrder, IsThatOfTheCalls) {
  Frame frame = begin();
  const Light light = {.shadow = HairShadow::kDepth, .shadowSize = 16};
  ASSERT_TRUE(frame.castShadows({&light, 1}));
  ASSERT_TRUE(frame.draw(view(), {&light, 1}, {.method = Transparency::kTiles}));
  frame.addList();
  ASSERT_TRUE(frame.draw(view(), {&light, 1}, {.method = Transparency::kShortCut}));
  ASSERT_TRUE(frame.addView({}));
  frame.addListBefore();
  EXPECT_EQ(frame.viewCount(), 3u);
  EXPECT_TRUE(frame.steps().empty());
  expectOk(frame.run(executor()));
  EXPECT_EQ(calls_,
            "u - skin_roots clear_strand_shadow "
            "- d0.0 transform_strands d0.1 - "
            "clear_short_cut d1.0 short_cut_resolve_depth d1.1 short_cut_fill_colors d1.2 "
            "short_cut_resolve_color d1.3 - d2.0 ");
}

TEST_F(FrameOrder, EndsWhereTheExecutorFails) {
  for (const std::string failing : {"u", "skin_roots", "d0.0"}) {
    const double time = scene_.time();
    {
      Frame frame = begin();
      ASSERT_TRUE(frame.draw(view(), {}));
      calls_.clear();
      const Result<void> done = frame.run(executor(failing));
      ASSERT_FALSE(done);
      EXPECT_EQ(done.error().message, "as the test wants it");
      EXPECT_TRUE(calls_.ends_with(failing + " ")) << calls_;
    }
    Frame next = begin();
    calls_.clear();
    EXPECT_TRUE(next.run(executor()));
    EXPECT_GT(calls_.size(), std::string("u ").size()) << calls_;
    // The list of the simulation ran where the draws failed.
    const int frames = failing == "d0.0" ? 2 : 1;
    EXPECT_NEAR(scene_.time() - time, frames / 60.0, 1e-6) << failing;
  }
}

}  // namespace
}  // namespace pelage::test
