// Recording a frame that is like those before it calls operator new in no function of the library.
#include "gl/gl_target.h"
#include "support/gpu_fixture.h"
#include "support/steady_scene.h"

namespace pelage::test {
namespace {

class GlAllocation : public GlContextTest {};
INSTANTIATE_TEST_SUITE_P(All, GlAllocation, testing::Values(Api::kGl, Api::kGles), apiTestName);

TEST_P(GlAllocation, IsNotNeededByFramesThatAreAlike) {
  for (const uint32_t objects : {1u, 30u}) {
    gl::RuntimeDef def;
    def.getProcAddress = eglAddress;
    Result<gl::Runtime> runtime = gl::Runtime::create(std::move(def));
    ASSERT_TRUE(runtime) << runtime.error().message;
    Scene scene;
    scene.setTier(runtime->tier());
    SteadyScene steady(scene, objects);
    const GlTarget target(16, 16);
    constexpr Transparency kMethods[] = {Transparency::kTiles, Transparency::kWindowed};
    const gl::ViewTarget view = {.area = target.area(), .begin = [&](const FrameStep& step) {
                                   target.begin(step.listOfView == 0);
                                 }};
    const std::vector<gl::ViewTarget> targets(std::size(kMethods) + 1, view);
    uint64_t passes = 0;
    const uint64_t taken = allocationsOf([&] {
      steady.setInputs();
      Frame frame = steady.makeFrame(kMethods, 16);
      const Result<void> recorded = runtime->record(frame, targets);
      EXPECT_TRUE(recorded) << recorded.error().message;
      for (const FrameStep& step : frame.steps()) passes += step.list->passes.size();
    });
    EXPECT_GT(passes, 0u);
    EXPECT_EQ(taken, 0u) << objects << " objects";
  }
}

}  // namespace
}  // namespace pelage::test
