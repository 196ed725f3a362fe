// The picture of contact records: a needle where there is a record, and nothing elsewhere.
#include <gtest/gtest.h>

#include <span>
#include <string>

#include "contact/contact_run.h"
#include "pelage/constants.h"
#include "pelage/gpu_structs.h"
#include "support/not_numbers.h"
#include "support/scene_test.h"

namespace pelage::test {
namespace {

constexpr double kCylinderRadius = 0.05;
constexpr uint32_t kPixels = 256;
constexpr float kEyeDistance = 0.25f;
using contact_records::kContactMore;

/// The camera is on the z axis and sees the plane z = 0.
View viewOfPlane() { return SceneRun::viewFrom({0, 0, kEyeDistance}, kPixels); }

/// Where a point of that plane is in the picture [pixels].
Point pixelOf(const Point& p) {
  const double scale = kPixels / 2.0 / (double{kEyeDistance} * std::tan(double{0.785f} / 2));
  return {kPixels / 2.0 + p.x * scale, kPixels / 2.0 - p.y * scale, 0};
}

struct Needle {
  Point foot, tip;  ///< [pixels]
  double depth = 0;
  bool slides = false;
  size_t vertex = 0;
};

/// As docs/contact.md has it, without the white of vertices that slide.
Float3 colorOf(double depth, double deepest) {
  if (depth < -5e-5) return {0.03f, 0.16f, 0.90f};
  if (depth <= 5e-5) return {0.03f, 0.65f, 0.07f};
  const auto t = static_cast<float>(std::min((depth - 5e-5) / (deepest - 5e-5), 1.0));
  return {0.95f + (0.90f - 0.95f) * t, 0.75f + (0.02f - 0.75f) * t, 0.02f};
}

double distanceToSegment(const Point& p, const Needle& needle) {
  const Point along = {needle.tip.x - needle.foot.x, needle.tip.y - needle.foot.y, 0};
  const Point from = {p.x - needle.foot.x, p.y - needle.foot.y, 0};
  const double squared = along.x * along.x + along.y * along.y;
  const double t = std::clamp((along.x * from.x + along.y * from.y) / squared, 0.0, 1.0);
  return distance(p, {needle.foot.x + along.x * t, needle.foot.y + along.y * t, 0});
}

class ContactDraw : public SceneTest {
 protected:
  /// 0.3 m of hair that falls onto the cylinder along z.
  HairObject& addHair(float friction, int vertices = 32, double root = -0.07) {
    run_.add(strandAsset(straight(vertices, {root, 0.06, 0}, {root + 0.3, 0.06, 0})));
    id_ = run_.lastHair();
    setCollider(hair(), cylinder(static_cast<float>(kCylinderRadius), friction));
    return hair();
  }
  HairObject& hair() { return run_.scene.hair(id_); }

  /// Needles of the records, from what is read back.
  std::vector<Needle> needles() {
    const auto positions = run_.positions(hair());
    const auto records = run_.read<ContactRecord>(hair().buffers().contacts);
    // Behind the totals, the heads, and a list of one strand.
    const auto words = run_.read<uint32_t>(hair().buffers().contactWords);
    const size_t firstMask = contact_records::kContactTotalWords + 1 +
                             size_t{contact_records::kContactHeadWords} * Scene::kMaxSubSteps *
                                 hair().settings.maxSubSteps;
    std::vector<Needle> needles;
    for (size_t v = 0; v < positions.size(); ++v) {
      if (((words[firstMask + v / 32] >> (v % 32)) & 1) == 0) continue;
      const ContactRecord& r = records[2 * v];
      EXPECT_EQ(r.bits & kContactMore, 0u) << "there is one collider";
      const Point p = toPoint(positions[v]);
      // The hair's origin is that of the world, as its root is near it.
      const double depth = -(double{r.plane.w} + double{r.plane.x} * (p.x - double{r.foundX}) +
                             double{r.plane.y} * (p.y - double{r.foundY}) +
                             double{r.plane.z} * (p.z - double{r.foundZ}));
      const double most = double{r.surface.w} * r.force.w;
      const bool slides = most > 0 && std::hypot(r.force.x, r.force.y, r.force.z) > 0.999 * most;
      const double length = double{look_.length} * (slides ? 0.5 : 1.0);
      needles.push_back(
          {pixelOf(p),
           pixelOf({p.x + length * double{r.plane.x}, p.y + length * double{r.plane.y}, 0}), depth,
           slides, v});
    }
    return needles;
  }
  /// A picture of the contacts alone.
  std::vector<Float4> picture(PassList& list) {
    expectOk(run_.scene.drawContacts(id_, viewOfPlane(), look_, list));
    return run_.render(list, kPixels).pixels;
  }
  static size_t covered(const std::vector<Float4>& pixels) {
    return static_cast<size_t>(std::ranges::count_if(
        pixels, [](const Float4& p) { return !(p.w == 0 && p.x == 0 && p.y == 0 && p.z == 0); }));
  }
  void expectColors(const std::vector<Float4>& pixels, const std::vector<Needle>& needles) const {
    for (const Needle& n : needles) {
      // Near its foot, where it is wider than a pixel.
      const double share = 2.5 / distance(n.foot, n.tip);
      const auto x = static_cast<size_t>(n.foot.x + (n.tip.x - n.foot.x) * share);
      const auto y = static_cast<size_t>(n.foot.y + (n.tip.y - n.foot.y) * share);
      const Float4& pixel = pixels[y * kPixels + x];
      Float3 color = colorOf(n.depth, double{look_.deepestDepth});
      if (n.slides) color = {(color.x + 1) / 2, (color.y + 1) / 2, (color.z + 1) / 2};
      EXPECT_NEAR(pixel.x, color.x, 0.02) << x << ", " << y << ", " << n.depth << " m deep";
      EXPECT_NEAR(pixel.y, color.y, 0.02);
      EXPECT_NEAR(pixel.z, color.z, 0.02);
      EXPECT_EQ(pixel.w, 1);
    }
  }

  HairId id_ = HairId::kInvalid;
  ContactLook look_ = {.length = 0.02f};
};

TEST_P(ContactDraw, PixelsAreWhereContactsAreAndNowhereElse) {
  size_t sliding = 0, others = 0;
  for (const bool isLong : {false, true}) {
    // The long one touches with vertices of its mask's second word.
    if (isLong)
      addHair(0.2f, 70, -0.2);
    else
      addHair(0);
    for (int frame = 0; frame < 20; ++frame) run_.step();
    const std::vector<Needle> expected = needles();
    ASSERT_GT(expected.size(), 3u);
    EXPECT_EQ(expected.back().vertex >= 32, isLong);
    PassList list;
    const std::vector<Float4> pixels = picture(list);
    ASSERT_EQ(pixels.size(), size_t{kPixels} * kPixels);
    expectColors(pixels, expected);
    for (size_t i = 0; i < pixels.size(); ++i) {
      if (pixels[i].w == 0) continue;
      const Point p = {static_cast<double>(i % kPixels) + 0.5,
                       static_cast<double>(i / kPixels) + 0.5, 0};
      double nearest = HUGE_VAL;
      for (const Needle& n : expected) keepSmallest(nearest, distanceToSegment(p, n));
      ASSERT_LT(nearest, 3) << p.x << ", " << p.y;
    }
    for (const Needle& n : expected) ++(n.slides ? sliding : others);
    run_.remove(id_);
  }
  EXPECT_GT(sliding, 0u);
  EXPECT_GT(others, 0u);
}

TEST_P(ContactDraw, NothingIsDrawnWhereNothingTouches) {
  addHair(0.3f);
  {
    PassList list;
    EXPECT_EQ(covered(picture(list)), 0u) << "before the first simulation";
  }
  for (int frame = 0; frame < 20; ++frame) run_.step();
  {
    PassList list;
    EXPECT_GT(covered(picture(list)), 0u);
    EXPECT_EQ(list.passes.size(), 1u);
  }
  // Within the ball around all strands, but near none of them.
  setCollider(hair(), {.head = {-0.07f, 0.25f, 0},
                       .headRadius = 0.02f,
                       .tail = {-0.07f, 0.25f, 0},
                       .tailRadius = 0.02f});
  for (int frame = 0; frame < 5; ++frame) run_.step();
  {
    PassList list;
    EXPECT_EQ(covered(picture(list)), 0u);
    EXPECT_EQ(list.passes.size(), 1u) << "contacts were looked for";
  }
  // No collider at all: what was found last time is over.
  setCollider(hair(), cylinder(static_cast<float>(kCylinderRadius), 0.3f));
  run_.step();  // in which the collider moves as far as that
  hair().reset();
  for (int frame = 0; frame < 20; ++frame) run_.step();
  const auto counters = [&] {
    const auto words = run_.read<uint32_t>(hair().buffers().contactWords);
    return readContactCounters(std::as_bytes(std::span(words)));
  };
  EXPECT_GT(counters().records, 0u);
  hair().setColliders({});
  run_.step();
  PassList list;
  EXPECT_EQ(covered(picture(list)), 0u);
  EXPECT_TRUE(list.passes.empty());
  EXPECT_EQ(counters().records, 0u);
  EXPECT_EQ(counters().strandsSolvedAgain, 0u);
}

TEST_P(ContactDraw, TheDeepestVertexIsThatOfThePositions) {
  addHair(0.3f);
  for (int frame = 0; frame < 20; ++frame) run_.step();
  const auto records = run_.device()->read(hair().buffers().contacts);
  const auto words = run_.device()->read(hair().buffers().contactWords);
  ASSERT_TRUE(records && words);
  std::vector<Float4> positions = run_.positions(hair());
  const auto deepest = [&] {
    const Result<float> found =
        run_.scene.deepestContact(id_, *records, *words, std::as_bytes(std::span(positions)));
    EXPECT_TRUE(found) << found.error().message;
    return double{*found};
  };
  EXPECT_NEAR(deepest(), std::max(depthInCylinder(positions, 32, kCylinderRadius), 0.0), 2e-5);
  for (Float4& p : positions) p.y -= 0.002f;
  // Planes are not the cylinder, from which they curve away.
  EXPECT_NEAR(deepest(), depthInCylinder(positions, 32, kCylinderRadius), 1e-4);
  for (Float4& p : positions) p.y = kNan;
  EXPECT_TRUE(std::isinf(deepest()));
  expectError(run_.scene.deepestContact(id_, *records, std::span(*words).first(16), {}), "16");
}

INSTANTIATE_TEST_SUITE_P(All, ContactDraw, testing::ValuesIn(kApis), apiTestName);

TEST(ContactDrawErrors, NameTheMemberThatIsOutOfRange) {
  Scene scene;
  const Result<HairId> id =
      required(scene.addHair(strandAsset(straight(8, {0, 0, 0}, {0, -0.1, 0})), {}));
  PassList list;
  const auto message = [&](const View& view, const ContactLook& look) {
    const Result<void> drawn = scene.drawContacts(*id, view, look, list);
    EXPECT_TRUE(list.passes.empty());
    return drawn ? std::string() : drawn.error().message;
  };
  EXPECT_EQ(message(viewOfPlane(), {}), "");
  for (const float bad : {0.0f, -1.0f, kInf, kNan}) {
    expectHas(message(viewOfPlane(), {.length = bad}), "length");
    expectHas(message(viewOfPlane(), {.width = bad}), "width");
    expectHas(message(viewOfPlane(), {.deepestDepth = bad}), "deepestDepth");
  }
  View empty = viewOfPlane();
  empty.width = 0;
  expectHas(message(empty, {}), "pixels");
  View broken = viewOfPlane();
  broken.worldToClip.rows[0].x = kNan;
  expectHas(message(broken, {}), "worldToClip");
}

}  // namespace
}  // namespace pelage::test
