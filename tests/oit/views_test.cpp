// Several views in one frame: each has the pixels that it has alone, whatever their sizes, methods
// and lights, and a light that all of them see has one shadow map.
#include <gtest/gtest.h>

#include <vector>

#include "oit/shared_tangle.h"
#include "support/errors.h"

namespace pelage::test {
namespace {

// As written for a frame, and run after all views have been written.
struct WrittenView {
  View view;
  std::vector<PassList> lists;
};

class ViewsOfAFrame : public SharedTangleTest<> {
 protected:
  void fill(TangleRun& run) override { run.add({.strands = 300, .opacity = 0.5f}); }
  void SetUp() override {
    SharedTangleTest::SetUp();
    if (!hasDevice()) return;
    scene().trim();
    nextFrame();
  }
  Scene& scene() { return tangleRun().run.scene; }
  // Without moving the hair.
  void nextFrame() { tangleRun().run.step(0); }

  static TransparencySettings settingsOf(Transparency method) {
    return {.method = method, .nodeCount = 1 << 15};
  }
  static View viewOf(uint32_t width, uint32_t height) {
    return cameraView({.eye = {0.02f * static_cast<float>(width % 7), 0.01f, 0.45f},
                       .width = width,
                       .height = height,
                       .nearPlane = 0.1f});
  }
  WrittenView write(const View& view, const TransparencySettings& settings,
                    std::vector<Light> lights = tangleLights()) {
    WrittenView written = {view, std::vector<PassList>(1)};
    expectOk(scene().draw(view, lights, settings, written.lists));
    return written;
  }
  void finish(WrittenView& written) {
    for (PassList& list : written.lists) scene().finish(list);
  }
  RenderedImage run(const WrittenView& written) {
    std::vector<const PassList*> pointers;
    for (const PassList& list : written.lists) pointers.push_back(&list);
    expectOk(tangleRun().run.device()->update(scene().resources()));
    RenderTargetDef target = {.width = written.view.width, .height = written.view.height};
    return valueOf(tangleRun().run.device()->render(pointers, target));
  }
  RenderedImage alone(const View& view, const TransparencySettings& settings) {
    nextFrame();
    WrittenView written = write(view, settings);
    finish(written);
    return run(written);
  }
};

bool isSame(const RenderedImage& a, const RenderedImage& b) {
  return a.pixels == b.pixels && coveredPixels(a) > 50;
}

size_t passesNamed(const std::vector<PassList>& lists, std::string_view name) {
  size_t count = 0;
  for (const PassList& list : lists)
    for (const Pass& pass : list.passes) count += pass.name == name ? 1 : 0;
  return count;
}

TEST_P(ViewsOfAFrame, HaveThePixelsThatEachHasAlone) {
  // The second one is larger than the first, and the third one smaller.
  const View views[] = {viewOf(40, 33), viewOf(75, 64), viewOf(24, 30)};
  for (const Transparency method : kEachTransparency) {
    std::vector<RenderedImage> expected;
    for (const View& view : views) expected.push_back(alone(view, settingsOf(method)));
    scene().trim();
    for (int frame = 0; frame < 2; ++frame) {
      nextFrame();
      std::vector<WrittenView> written;
      for (const View& view : views) written.push_back(write(view, settingsOf(method)));
      for (WrittenView& view : written) finish(view);
      for (size_t i = 0; i < written.size(); ++i) {
        EXPECT_TRUE(isSame(run(written[i]), expected[i]))
            << "method " << static_cast<int>(method) << ", view " << i << ", frame " << frame;
      }
    }
  }
}

TEST_P(ViewsOfAFrame, MayHaveAnotherMethodEach) {
  const View view = viewOf(48, 48);
  std::vector<RenderedImage> expected;
  for (const Transparency method : kEachTransparency)
    expected.push_back(alone(view, settingsOf(method)));
  nextFrame();
  std::vector<WrittenView> written;
  for (const Transparency method : kEachTransparency)
    written.push_back(write(view, settingsOf(method)));
  for (WrittenView& one : written) finish(one);
  for (size_t i = 0; i < written.size(); ++i)
    EXPECT_TRUE(isSame(run(written[i]), expected[i])) << "method " << i;
}

TEST_P(ViewsOfAFrame, TakeTheSameBuffersInTheNextFrame) {
  const auto frame = [&] {
    nextFrame();
    std::vector<WrittenView> written;
    for (const uint32_t size : {30u, 50u, 20u})
      written.push_back(write(viewOf(size, size), settingsOf(Transparency::kWindowed)));
    for (WrittenView& view : written) finish(view);
    for (const WrittenView& view : written) run(view);
  };
  frame();
  const uint64_t version = scene().resources().version();
  for (int i = 0; i < 3; ++i) frame();
  EXPECT_EQ(scene().resources().version(), version) << "a frame made buffers";
  scene().trim();
  for (uint32_t i = 0; i < scene().resources().end(); ++i) {
    const BufferDesc* desc = scene().resources().find(scene().resources().at(i));
    EXPECT_FALSE(desc != nullptr && desc->name.starts_with("transparency/")) << desc->name;
  }
  // Views that run one after the other share them.
  nextFrame();
  const uint32_t before = scene().resources().count();
  uint32_t first = 0;
  for (int i = 0; i < 3; ++i) {
    WrittenView view = write(viewOf(40, 40), settingsOf(Transparency::kWindowed));
    finish(view);
    run(view);
    // On Vulkan a frame that was recorded may still be refused by the queue.
    if (i == 0) first = scene().resources().count();
    EXPECT_EQ(scene().resources().count(), first);
  }
  EXPECT_GT(first, before);
}

TEST_P(ViewsOfAFrame, HaveOneMapForALightThatAllOfThemSee) {
  const TransparencySettings settings = settingsOf(Transparency::kAlphaTest);
  Light sun, lamp;
  sun.direction = {0.5f, 0.7f, 0.5f};
  sun.shadow = HairShadow::kDeep;
  sun.shadowSize = 64;
  lamp = sun;
  lamp.direction = {-1, 0.3f, 0.2f};
  const View view = viewOf(48, 48);
  const auto draw = [&](const std::vector<std::vector<Light>>& all) {
    nextFrame();
    expectOk(scene().shiftOrigin({}));  // as if it had moved: no map is kept
    std::vector<WrittenView> written;
    for (const std::vector<Light>& lights : all) written.push_back(write(view, settings, lights));
    for (WrittenView& one : written) finish(one);
    return written;
  };
  const auto mapsIn = [](const WrittenView& written) {
    return passesNamed(written.lists, "clear_strand_shadow");
  };
  std::vector<RenderedImage> expected;
  const std::vector<std::vector<Light>> lights = {{sun, lamp}, {lamp}, {lamp, sun}, {sun}};
  for (const std::vector<Light>& some : lights) {
    const auto written = draw({some});
    EXPECT_EQ(mapsIn(written[0]), some.size());
    expected.push_back(run(written[0]));
  }
  for (int round = 0; round < 2; ++round) {
    const auto written = draw(lights);
    for (size_t i = 0; i < written.size(); ++i) {
      EXPECT_EQ(mapsIn(written[i]), i == 0 ? 2u : 0u) << i;
      EXPECT_TRUE(isSame(run(written[i]), expected[i])) << i;
    }
  }
  // Lights that come with a later view: the frame after has room for all of them in one buffer.
  scene().trim();
  for (int round = 0; round < 3; ++round) {
    const auto written = draw({{sun}, {lamp, sun}});
    EXPECT_EQ(mapsIn(written[0]) + mapsIn(written[1]), round == 0 ? 3u : 2u) << round;
    EXPECT_TRUE(isSame(run(written[0]), expected[3])) << round;
    EXPECT_TRUE(isSame(run(written[1]), expected[2])) << round;
  }
}

/// Hair of two objects, and what a light with a shadow shows of it.
class KeptShadows : public SceneRunTest<> {
 protected:
  void SetUp() override {
    SceneRunTest::SetUp();
    if (run_.device() == nullptr) return;
    light_ = {.direction = {0.5f, 0.7f, 0.5f}, .shadow = HairShadow::kDeep, .shadowSize = 64};
    addHair({.strands = 200});
    addHair({.strands = 100, .seed = 8});
    run_.step();
  }
  void addHair(const TangleDef& def) {
    HairDef hair = {.material = tangleMaterial(def)};
    const Result<HairId> added = run_.scene.addHair(tangle(def), hair);
    ASSERT_TRUE(added) << added.error().message;
    hairs_.push_back(*added);
  }
  void TearDown() override {
    for (const HairId id : hairs_) static_cast<void>(run_.scene.removeHair(id));
    SceneRunTest::TearDown();
  }
  HairObject& hair(size_t i) { return run_.scene.hair(hairs_[i]); }
  RenderedImage draw(const std::vector<Light>& lights) {
    const View view =
        cameraView({.eye = {0.02f, 0.01f, 0.45f}, .width = 48, .height = 40, .nearPlane = 0.1f});
    std::vector<PassList> lists(1);
    expectOk(run_.scene.draw(view, lights, {.method = Transparency::kAlphaTest}, lists));
    maps_ = passesNamed(lists, "clear_strand_shadow");
    return valueOf(run_.renderLists(lists, {.width = view.width, .height = view.height}));
  }
  /// Draws with a new map, and a frame later with the same one.
  void expectNewMap(const char* event) {
    SCOPED_TRACE(event);
    const RenderedImage seen = draw({light_});
    EXPECT_EQ(maps_, 1u);
    run_.step(0);
    EXPECT_TRUE(isSame(draw({light_}), seen));
    EXPECT_EQ(maps_, 0u);
    run_.scene.trim();
    run_.step(0);
    EXPECT_TRUE(isSame(draw({light_}), seen)) << "the map was old";
    run_.step(0);
  }

  std::vector<HairId> hairs_;
  Light light_;
  size_t maps_ = 0;  ///< that the last picture filled
};

TEST_P(KeptShadows, AreThoseOfTheHairAndTheLightAsTheyAre) {
  expectNewMap("the first one");
  run_.step();
  expectNewMap("hair has moved");
  light_.direction = {-0.6f, 0.3f, 0.4f};
  expectNewMap("the light has moved");
  light_.shadowBias = 2;
  expectNewMap("another bias");
  light_.shadowSize = 48;
  expectNewMap("another size");
  hair(0).material.opacity = 0.9f;
  expectNewMap("another opacity");
  hair(0).material.fiberRadius *= 2;
  expectNewMap("another radius");
  hair(1).drawnStrands = 40;
  expectNewMap("fewer strands");
  hair(1).visible = false;
  expectNewMap("an object is hidden");
  hair(1).visible = true;
  expectNewMap("an object is visible");
  AffineTransform motion = {};
  motion.rows[0].w = 0.02f;
  expectOk(run_.scene.teleport(hairs_[0], motion));
  run_.step(0);
  expectNewMap("a teleport");
  expectOk(run_.scene.shiftOrigin({0.01f, 0, 0.02f}));
  run_.step(0);
  expectNewMap("the world has shifted");
  hair(0).reset();
  run_.step();
  expectNewMap("a reset");
  expectOk(run_.scene.removeHair(hairs_.back()));
  hairs_.pop_back();
  run_.step(0);
  expectNewMap("an object is removed");
  addHair({.strands = 80, .seed = 9});
  run_.step();
  expectNewMap("an object is new");
  {
    PassList lost;
    expectOk(run_.scene.simulate(1.0f / 60, lost));
  }
  run_.step(0);
  expectNewMap("a frame did not run");
}

// A light that moves in front of hair that does not, beside one that stays.
TEST_P(KeptShadows, TakeNoMoreMemoryFromFrameToFrame) {
  Light lamp = light_;
  uint64_t bytes = 0;
  size_t maps = 0;
  for (int i = 0; i < 40; ++i) {
    run_.step(0);
    lamp.direction.x = 0.05f * static_cast<float>(i);
    draw({light_, lamp});
    if (i == 8) bytes = run_.scene.drawBytes().shadows;
    if (i <= 8) continue;
    EXPECT_EQ(run_.scene.drawBytes().shadows, bytes) << i;
    maps += maps_;
  }
  EXPECT_LT(maps, 2 * 31u) << "the map of the light that stays is never used again";
}

TEST_P(ViewsOfAFrame, AreRefusedWhereAnotherDrawHasTheirBuffers) {
  const TransparencySettings settings = settingsOf(Transparency::kWindowed);
  WrittenView old = write(viewOf(40, 40), settings);
  nextFrame();
  WrittenView next = write(viewOf(64, 64), settings);
  finish(next);
  finish(old);
  expectError(checkRun(old.lists[0]), "remade by a later draw()");
  // Nor does it take the next one along.
  const RenderedImage image = run(next);
  EXPECT_TRUE(isSame(image, alone(viewOf(64, 64), settings)));

  nextFrame();
  WrittenView trimmed = write(viewOf(40, 40), settings);
  finish(trimmed);
  scene().trim();
  expectError(checkRun(trimmed.lists[0]), "Scene::trim()");
}

TEST_P(ViewsOfAFrame, WithoutShadowsNeedNoListThatMadeMaps) {
  const TransparencySettings settings = settingsOf(Transparency::kAlphaTest);
  const Light plain;
  for (const bool finished : {false, true}) {
    for (const bool sameFrame : {false, true}) {
      nextFrame();
      WrittenView lost = write(viewOf(40, 40), settings);
      if (finished) {
        finish(lost);
        for (PassList& list : lost.lists) abandon(list.run);
      }
      if (!sameFrame) nextFrame();
      WrittenView written = write(viewOf(40, 40), settings, {plain});
      finish(written);
      expectOk(checkRun(written.lists[0]));
    }
  }
}

TEST_P(ViewsOfAFrame, AreRefusedWhereTheListWithTheirMapsDoesNotRun) {
  const TransparencySettings settings = settingsOf(Transparency::kAlphaTest);
  nextFrame();
  WrittenView second;
  {
    const WrittenView first = write(viewOf(40, 40), settings);
    second = write(viewOf(40, 40), settings);
  }
  EXPECT_EQ(passesNamed(second.lists, "clear_strand_shadow"), 0u);
  finish(second);
  expectError(checkRun(second.lists[0]), "needs does not run");
  // The next one makes them again.
  EXPECT_TRUE(isSame(alone(viewOf(40, 40), settings), alone(viewOf(40, 40), settings)));

  nextFrame();
  expectOk(scene().shiftOrigin({}));
  WrittenView first = write(viewOf(40, 40), settings);
  second = write(viewOf(40, 40), settings);
  finish(second);
  expectError(checkRun(second.lists[0]), "order");
}

INSTANTIATE_TEST_SUITE_P(All, KeptShadows, testing::ValuesIn(kRuntimeApis), apiTestName);
INSTANTIATE_TEST_SUITE_P(All, ViewsOfAFrame, testing::ValuesIn(kRuntimeApis), apiTestName);

}  // namespace
}  // namespace pelage::test
