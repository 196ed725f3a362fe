// Frames on the OpenGL runtime of an engine: gl::Runtime::record() of a Frame does what record()
// and recordDraws() of its lists do, and two runtimes on one context do not know of each other.
#include <gtest/gtest.h>

#include <optional>
#include <utility>
#include <vector>

#include "gl/gl_target.h"
#include "support/delivery_scene.h"
#include "support/errors.h"
#include "support/gpu_fixture.h"
#include "support/views.h"

namespace pelage::test {
namespace {

/// Sum of the alphas.
float coverageOf(const std::vector<float>& rgba) {
  float sum = 0;
  for (size_t i = 3; i < rgba.size(); i += 4) sum += rgba[i];
  return sum;
}

using Results = DeliveryScene::Results;

// A scene with a runtime of its own on the context of the test.
class Player {
 public:
  explicit Player(Solver solver) : inputs_(scene_, solver) {
    gl::RuntimeDef def;
    def.getProcAddress = eglAddress;
    def.debug = true;
    Result<gl::Runtime> made = gl::Runtime::create(std::move(def));
    EXPECT_TRUE(made) << made.error().message;
    runtime_.emplace(*std::move(made));
  }

  Frame makeFrame(int frame) { return inputs_.makeFrame(frame); }
  void runLists(int frame) {
    inputs_.setInputs(frame);
    expectOk(inputs_.simulate(frame, list_));
    scene_.finish(list_);
    expectOk(runtime_->update(scene_.resources()));
    expectOk(runtime_->record(list_));
  }
  void runFrame(int frame) {
    inputs_.setInputs(frame);
    Frame made = makeFrame(frame);
    expectOk(runtime_->record(made));
  }
  Results read() {
    return inputs_.readResults([this](BufferId buffer) { return valueOf(runtime_->read(buffer)); });
  }
  Scene& scene() { return scene_; }
  DeliveryScene& inputs() { return inputs_; }
  gl::Runtime& runtime() { return *runtime_; }

 private:
  Scene scene_;
  DeliveryScene inputs_;
  std::optional<gl::Runtime> runtime_;
  PassList list_;
};

View viewOf(uint32_t width, uint32_t height) {
  return cameraView({.eye = {0.2f, 0.04f, 0.6f},
                     .target = {0.2f, 0.04f, 0},
                     .fov = 0.8f,
                     .width = width,
                     .height = height});
}

class GlFrame : public GlContextTest {
 protected:
  static std::vector<Results> playLists(Solver solver) {
    Player player(solver);
    std::vector<Results> frames;
    for (int frame = 0; frame < DeliveryScene::kFrames; ++frame) {
      player.runLists(frame);
      frames.push_back(player.read());
    }
    EXPECT_NE(frames[2][0], frames[9][0]) << "it moved at all";
    return frames;
  }
};
INSTANTIATE_TEST_SUITE_P(All, GlFrame, testing::Values(Api::kGl, Api::kGles), apiTestName);

TEST_P(GlFrame, MovesHairAsItsListsDo) {
  const std::vector<Results> lists = playLists(Solver::kExact);
  Player player(Solver::kExact);
  for (int frame = 0; frame < DeliveryScene::kFrames; ++frame) {
    player.runFrame(frame);
    ASSERT_EQ(player.read(), lists[static_cast<size_t>(frame)]) << frame;
  }
}

TEST_P(GlFrame, MakesNoProgramThatWasNotPrepared) {
  for (const Solver solver : {Solver::kExact, Solver::kClassic}) {
    Player player(solver);
    const Result<PassList> list = required(listToPrepare(DeliveryScene::features(solver)));
    expectOk(player.runtime().prepare(*list));
    const size_t prepared = player.runtime().pipelineTimes().size();
    EXPECT_EQ(prepared, list->passes.size());
    for (int frame = 0; frame < DeliveryScene::kFrames; ++frame) {
      player.runFrame(frame);
      const std::vector<PipelineTime> times = player.runtime().pipelineTimes();
      ASSERT_EQ(times.size(), prepared) << frame << ": " << times.back().name;
    }
  }
}

TEST_P(GlFrame, ThatIsDroppedOrRefusedIsAsIfItHadNeverBeen) {
  const std::vector<Results> lists = playLists(Solver::kClassic);
  Player player(Solver::kClassic);
  for (int frame = 0; frame < DeliveryScene::kFrames; ++frame) {
    player.inputs().setInputs(frame);
    {
      Frame lost = player.makeFrame(frame);
      if (frame % 2 == 0) {
        expectError(player.runtime().record(lost, std::vector<gl::ViewTarget>(3)),
                    "0 views, but there are 3 targets");
      }
    }
    player.runFrame(frame);
    ASSERT_EQ(player.read(), lists[static_cast<size_t>(frame)]) << frame;
  }
}

TEST_P(GlFrame, DrawsEachViewIntoItsTargetAsItsListsDo) {
  Player player(Solver::kExact);
  Scene& scene = player.scene();
  player.inputs().hair(0).material.fiberRadius = 0.001f;
  player.runFrame(0);
  const GlTarget targets[] = {{40, 30}, {64, 64}};
  const Transparency methods[] = {Transparency::kWindowed, Transparency::kTiles};
  const Light light = {.shadow = HairShadow::kDeep, .shadowSize = 64};
  View views[2];
  std::vector<float> expected[2];
  for (size_t i = 0; i < 2; ++i) {
    const gl::DrawTarget area = targets[i].area();
    views[i] = viewOf(area.width, area.height);
    std::vector<PassList> lists;
    expectOk(scene.draw(views[i], {&light, 1}, {.method = methods[i]}, lists));
    for (PassList& list : lists) scene.finish(list);
    expectOk(player.runtime().update(scene.resources()));
    for (size_t k = 0; k < lists.size(); ++k) {
      expectOk(player.runtime().record(lists[k]));
      targets[i].begin(k == 0);
      expectOk(player.runtime().recordDraws(lists[k], area));
    }
    expected[i] = targets[i].pixels();
    ASSERT_GT(coverageOf(expected[i]), 10.0f) << i;
    targets[i].begin(true);
  }

  Result<Frame> frame = required(scene.simulate(0));
  std::vector<gl::ViewTarget> viewTargets;
  std::vector<FrameStep> begun;
  for (size_t i = 0; i < 2; ++i) {
    const Result<uint32_t> view =
        required(frame->draw(views[i], {&light, 1}, {.method = methods[i]}));
    viewTargets.push_back({targets[i].area(), [&begun, &targets, i](const FrameStep& step) {
                             EXPECT_EQ(step.view, i);
                             begun.push_back(step);
                             targets[i].begin(step.listOfView == 0);
                           }});
  }
  expectError(player.runtime().record(*frame, std::span(viewTargets).first(1)),
              "2 views, but there are 1 targets");
  EXPECT_TRUE(begun.empty());
  expectOk(player.runtime().record(*frame, viewTargets));
  // The first list of each view clears its target, once.
  size_t first = 0;
  for (const FrameStep& step : begun) first += step.listOfView == 0;
  EXPECT_EQ(first, 2u);
  for (size_t i = 0; i < 2; ++i) EXPECT_EQ(targets[i].pixels(), expected[i]) << i;
}

// A stencil that an engine tests, and attachments for its normals and ids.
TEST_P(GlFrame, WritesTheFirstColorAndTheDepthOfAFramebufferAlone) {
  Player player(Solver::kClassic);
  player.inputs().hair(0).material.fiberRadius = 0.001f;
  player.runFrame(0);
  constexpr uint32_t kSize = 48;
  const View view = viewOf(kSize, kSize);
  const Light light;
  for (const Transparency method :
       {Transparency::kStochastic, Transparency::kWindowed, Transparency::kShortCut}) {
    std::vector<float> pictures[2];
    for (const bool rich : {false, true}) {
      const GlTarget target(kSize, kSize, rich);
      Result<Frame> frame = required(player.scene().simulate(0));
      ASSERT_TRUE(frame->draw(view, {&light, 1}, {.method = method}));
      gl::ViewTarget to = {target.area(), [&](const FrameStep& step) {
                             target.begin(step.listOfView == 0);
                             if (rich) GlTarget::rejectByStencil();
                           }};
      // An area of another size is refused before anything is drawn.
      gl::ViewTarget wrong = {{0, 0, kSize, kSize - 1},
                              [](const FrameStep&) { ADD_FAILURE() << "drawing has begun"; }};
      expectError(player.runtime().record(*frame, {&wrong, 1}), "48 x 47");
      {
        const gl::StateGuard guard(player.runtime());
        expectOk(player.runtime().record(*frame, {&to, 1}));
      }
      pictures[rich ? 1 : 0] = target.pixels();
      if (rich) target.expectOthersUntouched(GetParam() == Api::kGles);
    }
    EXPECT_GT(coverageOf(pictures[0]), 10.0f);
    EXPECT_EQ(pictures[0], pictures[1]) << static_cast<int>(method);
  }
}

// Two scenes on one device: a runtime each, frame by frame in turn.
TEST_P(GlFrame, OfTwoScenesOnOneContextHasTheBitsOfEachAlone) {
  const std::vector<Results> alone[] = {playLists(Solver::kExact), playLists(Solver::kClassic)};
  Player players[] = {Player(Solver::kExact), Player(Solver::kClassic)};
  for (int frame = 0; frame < DeliveryScene::kFrames; ++frame) {
    for (Player& player : players) player.runFrame(frame);
    for (size_t i = 0; i < 2; ++i)
      ASSERT_EQ(players[i].read(), alone[i][static_cast<size_t>(frame)]) << i << ", " << frame;
  }
  // The runtime of one refuses the other's buffers and frames.
  expectError(players[0].runtime().update(players[1].scene().resources()), "another ResourceTable");
  Frame frame = players[1].makeFrame(0);
  EXPECT_FALSE(players[0].runtime().record(frame));
}

}  // namespace
}  // namespace pelage::test
