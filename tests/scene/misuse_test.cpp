// Misuse of a scene and its frames is an error or an assertion: nothing throws, and nothing
// crashes.
#include <gtest/gtest.h>

#include <string>
#include <utility>

#include "scene/scene_lists.h"
#include "support/views.h"

namespace pelage::test {
namespace {

class Misuse : public SceneListTest {
 protected:
  Misuse() : hair_(scene_.hair(addHair())) {}
  static View view() { return cameraView({.eye = {0, 0, 1}, .fov = 0.8f, .width = 8}); }

  Scene other_;
  HairObject& hair_;
};

TEST_F(Misuse, BuffersOfAnotherSceneAreRefused) {
  const BufferDesc desc = {.name = "large", .size = 1 << 16, .stride = 16};
  const BufferId own = scene_.resources().add(desc);
  BufferId foreign = BufferId::kInvalid;
  while (ResourceTable::indexOf(foreign) != ResourceTable::indexOf(own))
    foreign = other_.resources().add(desc);
  EXPECT_EQ(scene_.resources().find(foreign), nullptr);
  hair_.setForceField({.values = foreign, .cellSize = 0.1f, .nodes = {2, 2, 2}});
  expectError(scene_.simulate(kFrameSeconds, list_), "does not exist");
  hair_.setForceField({.values = own, .cellSize = 0.1f, .nodes = {2, 2, 2}});
  simulate();
  hair_.setForces(foreign);
  expectError(scene_.simulate(kFrameSeconds, list_), "does not exist");
  hair_.setForces(BufferId::kInvalid);
  TransparencySettings settings = {.method = Transparency::kTiles, .opaqueDepth = foreign};
  std::vector<PassList> lists;
  expectError(scene_.draw(view(), {}, settings, lists), "opaqueDepth");
  settings.opaqueDepth = own;
  expectOk(scene_.draw(view(), {}, settings, lists));
}

TEST_F(Misuse, ATableThatIsCopiedHasTheSameBuffers) {
  const ResourceTable copy = scene_.resources();
  const BufferId positions = hair_.buffers().positions;
  ASSERT_NE(copy.find(positions), nullptr);
  EXPECT_EQ(copy.find(positions)->name, scene_.resources().find(positions)->name);
}

TEST_F(Misuse, FunctionsThatAreEmptyAreRefusedByName) {
  simulate();
  expectError(scene_.takeSnapshot({}), {"takeSnapshot()", "reader"});
  Result<Frame> frame = required(scene_.simulate(kFrameSeconds));
  ASSERT_TRUE(frame->draw(view(), {}));
  FrameExecutor executor = executorOf([](const PassList&) {});
  for (const char* name : {"update", "record", "draw"}) {
    FrameExecutor part = executor;
    if (name == std::string("update")) part.update = nullptr;
    if (name == std::string("record")) part.record = nullptr;
    if (name == std::string("draw")) part.draw = nullptr;
    expectError(frame->run(part), {"FrameExecutor::", name});
  }
  expectOk(frame->run(executor));
}

std::string g_misuse;

TEST_F(Misuse, AFrameThatWasMovedAwayTakesListsAndForgetsThem) {
  setAssertHandler([](const char*, const char* message, const char*, int) { g_misuse = message; });
  Result<Frame> frame = required(scene_.simulate(kFrameSeconds));
  const Frame moved = *std::move(frame);
  for (PassList* (*add)(Frame&) :
       {+[](Frame& f) { return &f.addList(); }, +[](Frame& f) { return &f.addListBefore(); }}) {
    g_misuse.clear();
    PassList* list = add(frame.value());
    ASSERT_NE(list, nullptr);
    EXPECT_TRUE(list->passes.empty());
    EXPECT_NE(g_misuse.find("moved away"), std::string::npos) << g_misuse;
  }
  setAssertHandler(nullptr);
}

}  // namespace
}  // namespace pelage::test
