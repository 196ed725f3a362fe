// A frame that does not run is as if it had never been written, on every runtime: the frames behind
// it have the bits of a run without it.
#include <array>
#include <cstddef>
#include <string>
#include <tuple>
#include <vector>

#include "support/delivery_scene.h"
#include "support/errors.h"
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
  constexpr const char* kNames[] = {"None",         "NotFinished", "NotExecuted",
                                    "UpdatedAlone", "NotUpdated",  "OtherList",
                                    "Refused",      "Twice",       "Abandoned"};
  return kNames[static_cast<size_t>(loss)];
}

class Delivery : public SceneRunTest<std::tuple<Api, Solver>> {
 protected:
  using Results = DeliveryScene::Results;

  /// Makes a frame with the current inputs and loses it. \return false: it ran after all.
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
    run_.execute(list_);
  }
  Results read(const DeliveryScene& scene) {
    return scene.readResults([this](BufferId buffer) { return run_.read<std::byte>(buffer); });
  }
  /// \param foreign  the lost frames have the inputs of another frame
  /// \return what is there after each frame
  std::vector<Results> play(Loss loss, bool foreign, bool engineInputs = false) {
    DeliveryScene scene(run_.scene, std::get<1>(GetParam()), engineInputs);
    std::vector<Results> frames;
    for (int frame = 0; frame < DeliveryScene::kFrames; ++frame) {
      bool ran = false;
      if (loss != Loss::kNone) {
        // Not that of the reset, which waits for the next frame.
        const int other =
            (frame + 4) % DeliveryScene::kFrames == 7 ? 8 : (frame + 4) % DeliveryScene::kFrames;
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

// Bones, distances and forces that an engine has on the GPU: what a lost frame has read is read
// again.
TEST_P(Delivery, InputsOfAnEngineAreReadAgain) {
  const std::vector<Results> undisturbed = play(Loss::kNone, false, true);
  ASSERT_FALSE(HasFailure());
  for (const Loss loss : {Loss::kTwice, Loss::kAbandoned}) {
    for (const bool foreign : {false, true}) {
      SCOPED_TRACE(std::string(lossName(loss)) + (foreign ? ", other inputs" : ""));
      expectSame(undisturbed, play(loss, foreign, true));
      if (HasFailure()) return;
    }
  }
}

// The origin is shifted while it is not known that a frame is lost: what the scene goes back to is
// in the new coordinates.
TEST_P(Delivery, AShiftOfTheOriginBehindALostFrameReachesWhatIsPutBack) {
  const auto play = [&](Loss loss) {
    DeliveryScene scene(run_.scene, std::get<1>(GetParam()));
    std::vector<Results> frames;
    for (int frame = 0; frame < DeliveryScene::kFrames; ++frame) {
      if (loss != Loss::kNone) {
        scene.setInputs(frame);
        EXPECT_TRUE(lose(scene, frame, loss));
      }
      // There and back again, by whole metres; in between one frame is elsewhere in the world.
      if (frame == 3 || frame == 5) expectOk(run_.scene.shiftOrigin({2, -1, 3}));
      if (frame == 4 || frame == 6) expectOk(run_.scene.shiftOrigin({-2, 1, -3}));
      scene.setInputs(frame);
      execute(scene, frame);
      frames.push_back(read(scene));
    }
    scene.remove();
    return frames;
  };
  const std::vector<Results> undisturbed = play(Loss::kNone);
  ASSERT_FALSE(HasFailure());
  for (const Loss loss : {Loss::kNotFinished, Loss::kNotExecuted, Loss::kAbandoned}) {
    SCOPED_TRACE(lossName(loss));
    expectSame(undisturbed, play(loss));
    if (HasFailure()) return;
  }
}

// An engine reports that a frame ran which did not. The exact solver's reset itself keeps a part of
// the history of strands in contact with capsules: there, roots, the other hair and the field.
TEST_P(Delivery, AResetRepairsWhatWasLostInSilence) {
  constexpr int kLost = 2, kReset = 4;
  const auto play = [&](bool lost) {
    DeliveryScene scene(run_.scene, std::get<1>(GetParam()));
    std::vector<Results> frames;
    for (int frame = 0; frame < DeliveryScene::kFrames; ++frame) {
      scene.setInputs(frame);
      if (frame == kReset) {
        scene.hair(0).reset();
        scene.hair(1).reset();
        scene.collider().reset();
      }
      if (lost && frame == kLost) {
        expectOk(scene.simulate(frame, list_));
        run_.scene.finish(list_);
        expectOk(run_.device()->update(run_.scene.resources()));
        setDelivered(list_.run);
      } else {
        execute(scene, frame);
      }
      if (frame < kReset) continue;
      frames.push_back(read(scene));
      if (std::get<1>(GetParam()) == Solver::kClassic) continue;
      frames.back().pop_back();  // the shadows
      const auto own = static_cast<ptrdiff_t>(scene.resultsOf(0).size());
      frames.back().erase(frames.back().begin(), frames.back().begin() + own);
    }
    scene.remove();
    return frames;
  };
  const std::vector<Results> whole = play(false);
  expectSame(whole, play(true));
}

TEST_P(Delivery, ARuntimeHasTheBuffersOfOneScene) {
  DeliveryScene scene(run_.scene, std::get<1>(GetParam()));
  execute(scene, 0);
  Scene other;
  // The same buffers by their numbers and sizes.
  DeliveryScene twin(other, std::get<1>(GetParam()));
  expectOk(twin.simulate(0, other_));
  other.finish(other_);
  expectError(run_.device()->update(other.resources()), "another ResourceTable");
  expectError(run_.device()->execute(other_), "another scene");
  execute(scene, 1);
  scene.remove();
}

INSTANTIATE_TEST_SUITE_P(All, Delivery, testing::ValuesIn(solversOnRuntimes()), solverTestName);

}  // namespace
}  // namespace pelage::test
