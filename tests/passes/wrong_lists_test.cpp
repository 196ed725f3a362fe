// Every runtime refuses a wrong list with the words of checkList(), runs nothing of it, and goes
// on.
#include "support/wrong_lists.h"

#include "support/gpu_fixture.h"

namespace pelage::test {
namespace {

class WrongLists : public GpuTest {
 protected:
  void SetUp() override {
    GpuTest::SetUp();
    if (IsSkipped()) return;
    // A device of its own: it knows one table.
    Result<std::unique_ptr<HeadlessDevice>> made = required(createDevice({.api = GetParam()}));
    device_ = *std::move(made);
    expectOk(device_->update(resources_));
  }

  Result<void> run(const PassList& list, ListPart part) {
    if (part != ListPart::kDraws) return device_->execute(list);
    const Result<RenderedImage> image = device_->render(list, {.width = 4, .height = 4});
    return image ? Result<void>() : image.error();
  }
  std::vector<std::byte> target() {
    Result<std::vector<std::byte>> bytes = device_->read(buffers_.target);
    EXPECT_TRUE(bytes);
    return bytes ? *std::move(bytes) : std::vector<std::byte>();
  }

  std::unique_ptr<HeadlessDevice> device_;
  ResourceTable resources_;
  WrongListBuffers buffers_{resources_};
};
INSTANTIATE_TEST_SUITE_P(All, WrongLists, testing::ValuesIn(kApis), apiTestName);

TEST_P(WrongLists, AreRefusedWithTheWordsOfTheCheck) {
  const std::vector<std::byte> before = target();
  HazardTracker hazards;
  for (const WrongList& wrong : wrongLists(buffers_)) {
    PassList list = rightList(buffers_);
    hazards.resolve(list);
    wrong.spoil(list);
    const Result<void> expected = checkList(list, resources_);
    ASSERT_FALSE(expected) << wrong.what;
    const Result<void> refused = run(list, wrong.part);
    ASSERT_FALSE(refused) << wrong.what;
    EXPECT_EQ(refused.error().code, expected.error().code) << wrong.what;
    EXPECT_EQ(refused.error().message, expected.error().message) << wrong.what;
    if (wrong.part != ListPart::kDraws) {
      EXPECT_EQ(target(), before) << wrong.what;
    }
  }
  PassList list = rightList(buffers_);
  hazards.resolve(list);
  expectOk(run(list, ListPart::kDraws));
  EXPECT_NE(target(), before);
}

}  // namespace
}  // namespace pelage::test
