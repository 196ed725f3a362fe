// Frames as objects: the calls in the right order give what the lists give, other orders are
// refused and say the right one, and a frame that is dropped is as if it had never been.
#include <gtest/gtest.h>

#include <cmath>
#include <optional>
#include <tuple>
#include <utility>
#include <vector>

#include "pelage/frame.h"
#include "pelage/gpu_structs.h"
#include "pelage/kernels.h"
#include "pelage/skeleton.h"
#include "support/delivery_scene.h"
#include "support/errors.h"
#include "support/pictures.h"
#include "support/plain_asset.h"
#include "support/scene_run.h"
#include "support/views.h"

namespace pelage::test {
namespace {

using Bytes = DeliveryScene::Results;

View viewOf(uint32_t width, uint32_t height) {
  return cameraView(
      {.eye = {0.1f, 0.04f, 0.6f}, .target = {0.1f, 0.04f, 0}, .width = width, .height = height});
}

RenderTargetDef targetOf(const View& view) {
  RenderTargetDef target = {.width = view.width, .height = view.height};
  return target;
}

class FrameTest : public SceneRunTest<std::tuple<Api, Solver>> {
 protected:
  Scene& scene() { return run_.scene; }
  HeadlessDevice& device() { return *run_.device(); }
  HairDef definition() const {
    HairDef def;
    def.settings.solver = std::get<1>(GetParam());
    def.material.fiberRadius = 0.001f;
    return def;
  }
  Bytes read(const DeliveryScene& scene) {
    return scene.readResults([this](BufferId buffer) { return run_.read<std::byte>(buffer); });
  }
};

TEST_P(FrameTest, HasThePicturesOfItsLists) {
  run_.add(makeAsset(20), definition());
  const View views[] = {viewOf(40, 30), viewOf(64, 64)};
  const Transparency methods[] = {Transparency::kWindowed, Transparency::kTiles};
  Light light = {.shadow = HairShadow::kDeep, .shadowSize = 64};
  run_.step();
  std::vector<RenderedImage> expected;
  for (size_t i = 0; i < 2; ++i) {
    std::vector<PassList> lists;
    expectOk(scene().draw(views[i], {&light, 1}, {.method = methods[i]}, lists));
    expected.push_back(imageOf(run_.renderLists(lists, targetOf(views[i])), targetOf(views[i])));
  }
  Result<Frame> frame = required(scene().simulate(0));
  std::vector<RenderTargetDef> targets;
  for (uint32_t i = 0; i < 2; ++i) {
    const Result<uint32_t> view =
        required(frame->draw(views[i], {&light, 1}, {.method = methods[i]}));
    EXPECT_EQ(*view, i);
    targets.push_back(targetOf(views[i]));
  }
  const Result<std::vector<RenderedImage>> images = required(device().render(*frame, targets));
  ASSERT_EQ(images->size(), 2u);
  for (size_t i = 0; i < 2; ++i) {
    EXPECT_EQ((*images)[i].pixels, expected[i].pixels) << i;
    EXPECT_GT(coverage(expected[i]), 10) << i;
  }
}

TEST_P(FrameTest, RunsListsOfAnEngineWhereTheyWereAdded) {
  HairObject& hair = run_.add(makeAsset(20), definition());
  run_.step();
  const BufferId copy = scene().resources().add(
      {.name = "copy",
       .size = 20 * 8 * sizeof(Float4),
       .stride = sizeof(Float4),
       .usage = BufferUsage::kStorage | BufferUsage::kUpload | BufferUsage::kReadback});
  // shift_positions is the simplest kernel there is: it adds to what is in a buffer.
  const auto addShift = [&](PassList& list, BufferId buffer, float by) {
    ShiftPositionsConstants constants = {};
    constants.shift = {by, 0, 0, 0};
    constants.shiftedCount = 20 * 8;
    PassBuilder builder(list);
    builder.dispatch(shiftPositionsVariant({}), constants.shiftedCount)
        .bind("g_shiftedPositions", buffer, constants.shiftedCount * sizeof(Float4))
        .constants("ShiftPositionsConstants", constants);
    expectOk(builder.finish());
  };
  const std::vector<Float4> start = run_.positions(hair);
  Result<Frame> frame = required(scene().simulate(0));
  addShift(frame->addListBefore(), copy, 1);
  addShift(frame->addList(), copy, 2);
  addShift(frame->addList(), hair.buffers().positions, 4);
  expectOk(device().run(*frame));
  const std::vector<Float4> end = run_.positions(hair), copied = run_.read<Float4>(copy);
  for (size_t i = 0; i < start.size(); ++i) {
    EXPECT_EQ(end[i].x, start[i].x + 4) << i;
    EXPECT_EQ(copied[i].x, 3.0f) << i;
  }
  scene().resources().remove(copy);
}

TEST_P(FrameTest, RefusesOtherOrdersAndSaysTheRightOne) {
  run_.add(makeAsset(5), definition());
  const View view = viewOf(32, 32);
  const Light light;
  Result<Frame> first = required(scene().simulate(1.0f / 60));
  Result<Frame> second = required(scene().simulate(1.0f / 60));

  // Views of two frames.
  expectError(first->draw(view, {&light, 1}), "before the next simulate()");
  expectError(device().run(*first), "before the next simulate()");

  ASSERT_TRUE(second->castShadows({&light, 1}));
  ASSERT_TRUE(second->draw(view, {&light, 1}));
  expectError(device().run(*second), "render() it, with a target for each");
  const RenderTargetDef targets[] = {targetOf(view), targetOf(view)};
  expectError(device().render(*second, targets), "1 views, but there are 2 targets");
  ASSERT_TRUE(device().render(*second, {targets, 1}));
  // It has run.
  expectError(second->draw(view, {&light, 1}), "draw all views before finish()");
  expectError(device().render(*second, {targets, 1}), "has run before");

  // A draw in a list that belongs to no view.
  Result<Frame> third = required(scene().simulate(0));
  expectOk(scene().draw(view, light, third->addList()));
  expectError(device().run(*third), "draws belong to a view");

  // A scene that is gone, and one that the device does not know.
  auto other = std::make_unique<Scene>();
  ASSERT_TRUE(other->addHair(makeAsset(5), definition()));
  Result<Frame> foreign = required(other->simulate(1.0f / 60));
  EXPECT_FALSE(device().run(*foreign));
  other.reset();
  expectError(foreign->finish(), "the scene of the frame is gone");

  // A frame that was refused has not begun, and the scene goes on.
  EXPECT_FALSE(scene().simulate(-1));
  Result<Frame> last = required(scene().simulate(1.0f / 60));
  expectOk(device().run(*last));
}

TEST_P(FrameTest, RefusesATargetOfAnotherAreaBeforeAnythingRuns) {
  HairObject& hair = run_.add(makeAsset(5), definition());
  run_.step();
  const std::vector<Float4> before = run_.positions(hair);
  View view = viewOf(32, 24);
  view.x = 4;
  RenderTargetDef target = targetOf(view);
  target.width = 40;
  target.area = {4, 0, 32, 24};
  const Light light;
  Result<Frame> frame = required(scene().simulate(1.0f / 60));
  ASSERT_TRUE(frame->draw(view, {&light, 1}));
  for (const PixelArea& wrong :
       {PixelArea{}, PixelArea{0, 0, 32, 24}, PixelArea{4, 0, 33, 24}, PixelArea{4, 0, 32, 12}}) {
    RenderTargetDef other = target;
    other.area = wrong;
    expectError(device().render(*frame, {&other, 1}), {"view 0: ", "32 x 24 at (4, 0)"});
    EXPECT_EQ(run_.positions(hair), before);
  }
  // It has not run, and still can.
  ASSERT_TRUE(device().render(*frame, {&target, 1}));
  EXPECT_NE(run_.positions(hair), before);
  // The same of lists.
  std::vector<PassList> lists;
  expectOk(scene().draw(view, {&light, 1}, {}, lists));
  RenderTargetDef all = target;
  all.area = {};
  expectError(run_.renderLists(lists, all), "32 x 24 at (4, 0)");
  lists.clear();
  expectOk(scene().draw(view, {&light, 1}, {}, lists));
  EXPECT_TRUE(run_.renderLists(lists, target));
}

/// How a frame gets lost.
enum class Drop { kNone, kAtOnce, kWithAView, kFinished, kReplaced };

TEST_P(FrameTest, ThatIsDroppedIsAsIfItHadNeverBeen) {
  const Light light = {.shadow = HairShadow::kDeep, .shadowSize = 64};
  const auto play = [&](Drop drop) {
    DeliveryScene world(scene(), std::get<1>(GetParam()));
    std::vector<Bytes> frames;
    std::optional<Frame> kept;
    for (int i = 0; i < DeliveryScene::kFrames; ++i) {
      world.setInputs(i);
      if (drop != Drop::kNone) {
        Result<Frame> lost = scene().simulate(DeliveryScene::seconds(i));
        EXPECT_TRUE(lost);
        if (drop == Drop::kWithAView) {
          EXPECT_TRUE(lost->draw(viewOf(32, 32), {&light, 1}));
        }
        if (drop == Drop::kFinished) expectOk(lost->finish());
        if (drop == Drop::kReplaced) kept = std::move(*lost);
      }
      Result<Frame> frame = scene().simulate(DeliveryScene::seconds(i));
      EXPECT_TRUE(frame);
      EXPECT_TRUE(frame->castShadows({&light, 1}));
      expectOk(device().run(*frame));
      frames.push_back(read(world));
    }
    world.remove();
    return frames;
  };
  const std::vector<Bytes> expected = play(Drop::kNone);
  for (const Drop drop : {Drop::kAtOnce, Drop::kWithAView, Drop::kFinished, Drop::kReplaced}) {
    const std::vector<Bytes> played = play(drop);
    for (size_t i = 0; i < expected.size(); ++i)
      EXPECT_EQ(played[i], expected[i]) << "frame " << i << ", loss " << static_cast<int>(drop);
  }
}

TEST_P(FrameTest, OfZeroSecondsShowsNewHairInItsBindPose) {
  const HairAsset asset = makeAsset(9);
  HairDef def = definition();
  std::vector<FollowHair> follows(2);
  follows[0].guide = 3;
  follows[0].offset = {0.002f, 0, 0.001f, 1};
  follows[1].guide = 5;
  def.followHairs = follows;
  def.storeFollowHairs = true;
  const auto pose = [](float angle) {
    return rigidTransform({0, 0, std::sin(angle), std::cos(angle)}, {3.2f, -0.5f, 1});
  };
  const auto run = [&](float seconds) {
    Result<Frame> frame = required(scene().simulate(seconds));
    expectOk(device().run(*frame));
  };
  const auto expectPosed = [&](const HairObject& hair, const AffineTransform& bone) {
    const std::vector<Float4> positions = run_.positions(hair);
    const std::vector<Float4> tangents = run_.read<Float4>(hair.buffers().tangents);
    ASSERT_EQ(positions.size(), (9 + 2) * 8u);
    for (size_t i = 0; i < 9 * 8; ++i) {
      const Float4& bind = asset.positions[i];
      const Float3 expected = transformPoint(bone, {bind.x, bind.y, bind.z});
      EXPECT_NEAR(positions[i].x, expected.x, 2e-6f) << i;
      EXPECT_NEAR(positions[i].y, expected.y, 2e-6f) << i;
      EXPECT_NEAR(positions[i].z, expected.z, 2e-6f) << i;
      const Float4& t = tangents[i];
      EXPECT_NEAR(t.x * t.x + t.y * t.y + t.z * t.z, 1, 1e-5f) << i;
    }
    // The follow hair without an offset is its guide.
    for (size_t v = 0; v < 8; ++v)
      EXPECT_NEAR(positions[10 * 8 + v].y, positions[5 * 8 + v].y, 1e-6f) << v;
  };

  HairObject& first = run_.add(asset, def);
  const AffineTransform bone = pose(0.3f), turned = pose(0.7f);
  first.setBones({&bone, 1});
  run(0);
  expectPosed(first, bone);
  // It follows its bones as long as it waits.
  first.setBones({&turned, 1});
  run(0);
  expectPosed(first, turned);
  // The frames behind have the bits of hair that has not waited.
  for (int i = 0; i < 3; ++i) run(1.0f / 60);
  const std::vector<Float4> waited = run_.positions(first);
  HairObject& other = run_.add(asset, def);
  other.setBones({&turned, 1});
  // Added in a pause: the other one stays where it is.
  run(0);
  expectPosed(other, turned);
  EXPECT_EQ(run_.positions(first), waited);
  EXPECT_NE(waited, run_.positions(other)) << "gravity has moved it";
  first.reset();
  run(0);
  expectPosed(first, turned);
  for (int i = 0; i < 3; ++i) run(1.0f / 60);
  EXPECT_EQ(run_.positions(other), run_.positions(first));
  EXPECT_EQ(run_.positions(other), waited);
}

INSTANTIATE_TEST_SUITE_P(All, FrameTest, testing::ValuesIn(solversOnApis()), solverTestName);

}  // namespace
}  // namespace pelage::test
