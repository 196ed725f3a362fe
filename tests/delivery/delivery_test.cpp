// A frame that does not run is as if it had never been written, on every runtime: the frames behind
// it have the bits of a run without it.
#include <array>
#include <cstddef>
#include <string>
#include <tuple>
#include <vector>

#include "support/delivery_scene.h"
#include "support/scene_run.h"

namespace pelage::test {
namespace {

/// How a frame gets lost.
enum class Loss {
  kNone,
  kNotFinished,   ///< simulate() alone
  kNotExecuted,   ///< simulate() and finish()
  kUpdatedAlone,  ///< its buffers are made, too
  kNotUpdated,    ///< executed without update(): refused where it has new buffers, else it runs
  kOtherList,     ///< another list, which lives on
  kRefused,       ///< the runtime refuses the list
  kTwice,         ///< two frames one after the other
  kAbandoned,     ///< and the scene is told
};

constexpr std::array kLosses = {Loss::kNotFinished, Loss::kNotExecuted, Loss::kUpdatedAlone,
                                Loss::kNotUpdated,  Loss::kOtherList,   Loss::kRefused,
                                Loss::kTwice,       Loss::kAbandoned};

const char* lossName(Loss loss) {
  switch (loss) {
    case Loss::kNone:
      return "None";
    case Loss::kNotFinished:
      return "NotFinished";
    case Loss::kNotExecuted:
      return "NotExecuted";
    case Loss::kUpdatedAlone:
      return "UpdatedAlone";
    case Loss::kNotUpdated:
      return "NotUpdated";
    case Loss::kOtherList:
      return "OtherList";
    case Loss::kRefused:
      return "Refused";
    case Loss::kTwice:
      return "Twice";
    case Loss::kAbandoned:
      return "Abandoned";
  }
  return "";
}

class Delivery : public testing::TestWithParam<std::tuple<Api, Solver>> {
 protected:
  using Results = std::vector<std::vector<std::byte>>;
  Delivery() : run_(sharedSceneRun(std::get<0>(GetParam()))) {}
  void SetUp() override {
    if (run_.device() == nullptr) GTEST_SKIP() << "no device";
  }

  /// Loses a frame with what has been set. \return false: it ran after all.
  bool lose(DeliveryScene& scene, int frame, Loss loss) {
    if (loss == Loss::kOtherList) {
      expectOk(scene.simulate(frame, other_));
      run_.scene.finish(other_);
      return true;
    }
    expectOk(scene.simulate(frame, list_));
    if (loss == Loss::kNotFinished) return true;
    run_.scene.finish(list_);
    if (loss == Loss::kUpdatedAlone || loss == Loss::kRefused)
      expectOk(run_.device()->update(run_.scene.resources()));
    if (loss == Loss::kNotUpdated) return !run_.device()->execute(list_);
    if (loss == Loss::kRefused) {
      for (Pass& pass : list_.passes) pass.groups[0] = 0xffffffffu;
      EXPECT_FALSE(run_.device()->execute(list_));
    }
    if (loss == Loss::kTwice) expectOk(scene.simulate(frame, list_));
    if (loss == Loss::kAbandoned) run_.scene.abandon(list_);
    return true;
  }
  void execute(DeliveryScene& scene, int frame) {
    expectOk(scene.simulate(frame, list_));
    run_.scene.finish(list_);
    expectOk(run_.device()->update(run_.scene.resources()));
    expectOk(run_.device()->execute(list_));
  }
  Results read(const DeliveryScene& scene) {
    Results all;
    for (const BufferId buffer : scene.results()) all.push_back(run_.read<std::byte>(buffer));
    return all;
  }
  /// \param foreign  the lost frames have the inputs of another frame
  /// \return what is there after each frame
  std::vector<Results> play(Loss loss, bool foreign) {
    DeliveryScene scene(run_.scene, std::get<1>(GetParam()));
    std::vector<Results> frames;
    for (int frame = 0; frame < DeliveryScene::kFrames; ++frame) {
      bool ran = false;
      if (loss != Loss::kNone) {
        // Not that of the reset, which waits for the next frame.
        const int other = (frame + 4) % DeliveryScene::kFrames == 7
                              ? 8
                              : (frame + 4) % DeliveryScene::kFrames;
        scene.setInputs(foreign ? other : frame);
        ran = !lose(scene, frame, loss);
        EXPECT_FALSE(ran && foreign);
      }
      // As an application that has set everything for the frame that was lost.
      if (loss == Loss::kNone || foreign) scene.setInputs(frame);
      if (!ran) execute(scene, frame);
      frames.push_back(read(scene));
    }
    times_.push_back(scene.time());
    scene.remove();
    return frames;
  }
  static void expectSame(const std::vector<Results>& a, const std::vector<Results>& b) {
    ASSERT_EQ(a.size(), b.size());
    for (size_t frame = 0; frame < a.size(); ++frame) {
      ASSERT_EQ(a[frame].size(), b[frame].size());
      for (size_t i = 0; i < a[frame].size(); ++i) {
        // Keys beyond a field's own may be those of an earlier layout.
        ASSERT_EQ(a[frame][i].size(), b[frame][i].size()) << "frame " << frame << ", buffer " << i;
        ASSERT_TRUE(a[frame][i] == b[frame][i]) << "frame " << frame << ", buffer " << i;
      }
    }
  }

  SceneRun& run_;
  PassList list_, other_;
  std::vector<double> times_;
};

TEST_P(Delivery, AFrameThatIsLostIsAsIfItHadNeverBeenWritten) {
  const std::vector<Results> undisturbed = play(Loss::kNone, false);
  ASSERT_FALSE(HasFailure());
  ASSERT_NE(undisturbed[2][0], undisturbed[9][0]) << "it moved at all";
  expectSame(undisturbed, play(Loss::kNone, false));
  ASSERT_FALSE(HasFailure()) << "the order of runs has an effect";
  for (const Loss loss : kLosses) {
    for (const bool foreign : {false, true}) {
      if (foreign && loss == Loss::kNotUpdated) continue;
      SCOPED_TRACE(std::string(lossName(loss)) + (foreign ? ", other inputs" : ""));
      expectSame(undisturbed, play(loss, foreign));
      EXPECT_EQ(times_.back(), times_.front());
      if (HasFailure()) return;
    }
  }
}

INSTANTIATE_TEST_SUITE_P(All, Delivery, testing::ValuesIn(solversOnApis()), [](const auto& tested) {
  return std::string(apiName(std::get<0>(tested.param))) +
         (std::get<1>(tested.param) == Solver::kExact ? "Exact" : "Classic");
});

}  // namespace
}  // namespace pelage::test
