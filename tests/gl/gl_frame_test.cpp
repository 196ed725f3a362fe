// Frames on the OpenGL runtime of an engine: gl::Runtime::record() of a Frame does what record()
// and recordDraws() of its lists do, and two runtimes on one context do not know of each other.
#include <GL/glcorearb.h>
#include <gtest/gtest.h>

#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "gl/engine_context.h"
#include "pelage/gl.h"
#include "support/delivery_scene.h"
#include "support/gpu_fixture.h"
#include "support/required_devices.h"

namespace pelage::test {
namespace {

// A picture with depth that an engine draws into.
class Target {
 public:
  Target(uint32_t width, uint32_t height) : width_(width), height_(height) {
    const auto w = static_cast<GLsizei>(width), h = static_cast<GLsizei>(height);
    call<PFNGLGENFRAMEBUFFERSPROC>("glGenFramebuffers")(1, &framebuffer_);
    call<PFNGLGENRENDERBUFFERSPROC>("glGenRenderbuffers")(2, buffers_);
    bind();
    const GLenum formats[] = {GL_RGBA16F, GL_DEPTH_COMPONENT32F};
    const GLenum points[] = {GL_COLOR_ATTACHMENT0, GL_DEPTH_ATTACHMENT};
    for (size_t i = 0; i < 2; ++i) {
      call<PFNGLBINDRENDERBUFFERPROC>("glBindRenderbuffer")(GL_RENDERBUFFER, buffers_[i]);
      call<PFNGLRENDERBUFFERSTORAGEPROC>("glRenderbufferStorage")(GL_RENDERBUFFER, formats[i], w,
                                                                  h);
      call<PFNGLFRAMEBUFFERRENDERBUFFERPROC>("glFramebufferRenderbuffer")(
          GL_FRAMEBUFFER, points[i], GL_RENDERBUFFER, buffers_[i]);
    }
    EXPECT_EQ(call<PFNGLCHECKFRAMEBUFFERSTATUSPROC>("glCheckFramebufferStatus")(GL_FRAMEBUFFER),
              GLenum{GL_FRAMEBUFFER_COMPLETE});
  }
  ~Target() {
    call<PFNGLDELETEFRAMEBUFFERSPROC>("glDeleteFramebuffers")(1, &framebuffer_);
    call<PFNGLDELETERENDERBUFFERSPROC>("glDeleteRenderbuffers")(2, buffers_);
  }
  Target(const Target&) = delete;
  Target& operator=(const Target&) = delete;

  void begin(bool first) const {
    bind();
    if (!first) return;
    call<PFNGLCOLORMASKPROC>("glColorMask")(GL_TRUE, GL_TRUE, GL_TRUE, GL_TRUE);
    call<PFNGLDEPTHMASKPROC>("glDepthMask")(GL_TRUE);
    call<PFNGLCLEARCOLORPROC>("glClearColor")(0, 0, 0, 0);
    call<PFNGLCLEARDEPTHFPROC>("glClearDepthf")(1);
    call<PFNGLCLEARPROC>("glClear")(GL_COLOR_BUFFER_BIT | GL_DEPTH_BUFFER_BIT);
  }
  gl::DrawTarget area() const { return {0, 0, width_, height_}; }
  std::vector<float> pixels() const {
    std::vector<float> all(size_t{4} * width_ * height_);
    bind();
    call<PFNGLREADPIXELSPROC>("glReadPixels")(0, 0, static_cast<GLsizei>(width_),
                                              static_cast<GLsizei>(height_), GL_RGBA, GL_FLOAT,
                                              all.data());
    return all;
  }

 private:
  template <class Function>
  static Function call(const char* name) {
    return glFunction<Function>(name);
  }
  void bind() const {
    call<PFNGLBINDFRAMEBUFFERPROC>("glBindFramebuffer")(GL_FRAMEBUFFER, framebuffer_);
  }
  uint32_t width_, height_;
  GLuint framebuffer_ = 0;
  GLuint buffers_[2] = {0, 0};
};

using Results = std::vector<std::vector<std::byte>>;

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

  Frame makeFrame(int frame) {
    Result<Frame> made = scene_.simulate(DeliveryScene::seconds(frame));
    EXPECT_TRUE(made) << made.error().message;
    const Light light = {.shadow = HairShadow::kDeep, .shadowSize = 64};
    EXPECT_TRUE(made->castShadows({&light, 1}));
    return *std::move(made);
  }
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
    Results all;
    for (const BufferId buffer : inputs_.results()) {
      Result<std::vector<std::byte>> bytes = runtime_->read(buffer);
      EXPECT_TRUE(bytes) << bytes.error().message;
      all.push_back(bytes ? *std::move(bytes) : std::vector<std::byte>());
    }
    return all;
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

class GlFrame : public testing::TestWithParam<Api> {
 protected:
  void SetUp() override {
    context_ = std::make_unique<EngineContext>(GetParam());
    if (!context_->current()) PELAGE_SKIP_WITHOUT_DEVICE() << "no OpenGL context through EGL";
  }
  void TearDown() override {
    if (context_->current()) {
      EXPECT_EQ(glFunction<PFNGLGETERRORPROC>("glGetError")(), GLenum{GL_NO_ERROR});
    }
  }
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

 private:
  std::unique_ptr<EngineContext> context_;
};
INSTANTIATE_TEST_SUITE_P(, GlFrame, testing::Values(Api::kGl, Api::kGles), apiTestName);

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
    const Result<PassList> list = listToPrepare(DeliveryScene::features(solver));
    ASSERT_TRUE(list) << list.error().message;
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
        const Result<void> refused = player.runtime().record(lost, std::vector<gl::ViewTarget>(3));
        ASSERT_FALSE(refused);
        EXPECT_NE(refused.error().message.find("0 views, but there are 3 targets"),
                  std::string::npos)
            << refused.error().message;
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
  const Target targets[] = {{40, 30}, {64, 64}};
  const Transparency methods[] = {Transparency::kWindowed, Transparency::kTiles};
  const Light light = {.shadow = HairShadow::kDeep, .shadowSize = 64};
  View views[2];
  std::vector<float> expected[2];
  for (size_t i = 0; i < 2; ++i) {
    const gl::DrawTarget area = targets[i].area();
    views[i].eye = {0.2f, 0.04f, 0.6f};
    views[i].worldToClip =
        lookAt(views[i].eye, {0.2f, 0.04f, 0}, {0, 1, 0}, 0.8f,
               static_cast<float>(area.width) / static_cast<float>(area.height), 0.05f, 5);
    views[i].width = area.width;
    views[i].height = area.height;
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
    float covered = 0;
    for (size_t k = 3; k < expected[i].size(); k += 4) covered += expected[i][k];
    ASSERT_GT(covered, 10.0f) << i;
    targets[i].begin(true);
  }

  Result<Frame> frame = scene.simulate(0);
  ASSERT_TRUE(frame) << frame.error().message;
  std::vector<gl::ViewTarget> viewTargets;
  std::vector<FrameStep> begun;
  for (size_t i = 0; i < 2; ++i) {
    const Result<uint32_t> view = frame->draw(views[i], {&light, 1}, {.method = methods[i]});
    ASSERT_TRUE(view) << view.error().message;
    viewTargets.push_back({targets[i].area(), [&begun, &targets, i](const FrameStep& step) {
                             EXPECT_EQ(step.view, i);
                             begun.push_back(step);
                             targets[i].begin(step.listOfView == 0);
                           }});
  }
  const Result<void> few = player.runtime().record(*frame, std::span(viewTargets).first(1));
  ASSERT_FALSE(few);
  EXPECT_NE(few.error().message.find("2 views, but there are 1 targets"), std::string::npos);
  EXPECT_TRUE(begun.empty());
  expectOk(player.runtime().record(*frame, viewTargets));
  // The first list of each view clears its target, once.
  size_t first = 0;
  for (const FrameStep& step : begun) first += step.listOfView == 0;
  EXPECT_EQ(first, 2u);
  for (size_t i = 0; i < 2; ++i) EXPECT_EQ(targets[i].pixels(), expected[i]) << i;
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
  const Result<void> updated = players[0].runtime().update(players[1].scene().resources());
  ASSERT_FALSE(updated);
  EXPECT_NE(updated.error().message.find("another ResourceTable"), std::string::npos);
  Frame frame = players[1].makeFrame(0);
  EXPECT_FALSE(players[0].runtime().record(frame));
}

}  // namespace
}  // namespace pelage::test
