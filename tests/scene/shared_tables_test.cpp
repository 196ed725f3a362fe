// Objects with the same tables have one buffer for them, as long as one of them or a frame that may
// turn out not to run wants it.
#include <memory>

#include "scene/scene_lists.h"

namespace pelage::test {
namespace {

class SharedTablesTest : public SceneListTest {
 protected:
  HairId add(const char* name, const HairDef& from = {}) {
    HairDef def = from;
    def.name = name;
    return valueOf(scene_.addHair(asset_, def));
  }
  const HairBuffers& buffers(HairId id) const { return scene_.hair(id).buffers(); }
  std::shared_ptr<const HairAsset> asset_ = std::make_shared<const HairAsset>(makeAsset(64));
};

TEST_F(SharedTablesTest, AreOneForObjectsOfOneAsset) {
  const HairBuffers one = buffers(add("one"));
  const HairBuffers other = buffers(add("other"));
  EXPECT_NE(one.rest, BufferId::kInvalid);
  EXPECT_EQ(one.rest, other.rest);
  EXPECT_EQ(one.bindRoots, other.bindRoots);
  EXPECT_EQ(one.rootBindings, other.rootBindings);
  EXPECT_EQ(one.indices, other.indices);
  // Each object has its own state.
  EXPECT_NE(one.positions, other.positions);
  EXPECT_NE(one.state, other.state);
  EXPECT_NE(one.boneTransforms, other.boneTransforms);
}

TEST_F(SharedTablesTest, DifferWhereTheirContentsDo) {
  const HairBuffers one = buffers(add("one"));
  const std::vector<StrandFactors> factors(64, {.stiffness = 2});
  const HairBuffers stiff = buffers(add("stiff", {.strandFactors = factors}));
  EXPECT_NE(one.rest, stiff.rest);
  EXPECT_EQ(one.bindRoots, stiff.bindRoots);
  const HairBuffers posed = buffers(add("posed", {.settings = {.globalStiffness = 0.5f}}));
  EXPECT_NE(one.rest, posed.rest) << "it has the bind positions, too";
}

TEST_F(SharedTablesTest, StayUntilTheLastObjectGoes) {
  const HairId one = add("one"), other = add("other");
  const BufferId rest = buffers(one).rest;
  run();
  run();
  ASSERT_TRUE(scene_.removeHair(one));
  EXPECT_NE(scene_.resources().find(rest), nullptr);
  EXPECT_EQ(buffers(other).rest, rest);
  run();
  ASSERT_TRUE(scene_.removeHair(other));
  EXPECT_EQ(scene_.resources().find(rest), nullptr);
  EXPECT_EQ(scene_.resources().count(), 0u);
}

TEST_F(SharedTablesTest, StayForFramesThatMayNotRun) {
  const HairId one = add("one");
  run();
  const BufferId before = buffers(one).rest;
  scene_.hair(one).settings.globalStiffness = 0.5f;
  write(list_);
  const BufferId after = buffers(one).rest;
  ASSERT_NE(after, before);
  EXPECT_NE(scene_.resources().find(before), nullptr) << "the frame may be taken back";
  // Made within the frame; what comes after it shares it.
  const HairId other = add("other", {.settings = {.globalStiffness = 0.5f}});
  EXPECT_EQ(buffers(other).rest, after);
  scene_.abandon(list_);
  EXPECT_EQ(buffers(one).rest, before);
  EXPECT_NE(scene_.resources().find(after), nullptr) << "the other object has it";
  run();
  EXPECT_EQ(buffers(one).rest, after);
  run();
  EXPECT_EQ(scene_.resources().find(before), nullptr) << "nothing has it any more";
}

TEST_F(SharedTablesTest, TakeNoMoreMemoryForFurtherObjects) {
  add("one");
  const uint64_t first = scene_.resources().totalBytes();
  add("two");
  const uint64_t second = scene_.resources().totalBytes() - first;
  add("three");
  EXPECT_EQ(scene_.resources().totalBytes(), first + 2 * second);
  EXPECT_LT(second, first);
}

TEST_F(SharedTablesTest, RefusesANullAsset) {
  const Result<HairId> added = scene_.addHair(std::shared_ptr<const HairAsset>(), {.name = "bald"});
  ASSERT_FALSE(added);
  EXPECT_EQ(added.error().message, "hair 'bald': the asset is null");
}

}  // namespace
}  // namespace pelage::test
