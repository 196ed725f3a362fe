// Depth and motion of hair, beside what draws it: where strands are, how far they moved on the
// screen, and that it costs nothing where nobody asks for it.
#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <cmath>
#include <numbers>
#include <vector>

#include "pelage/hair_depth.h"
#include "pelage/list_check.h"
#include "pelage/skeleton.h"
#include "support/delivery_scene.h"
#include "support/errors.h"
#include "support/extremes.h"
#include "support/lists.h"
#include "support/matrices.h"
#include "support/not_numbers.h"
#include "support/pictures.h"
#include "support/scene_run.h"
#include "support/views.h"

namespace pelage::test {
namespace {

using Eigen::Matrix4d;
using Eigen::Vector2d;
using Eigen::Vector3d;
using Eigen::Vector4d;

constexpr uint32_t kDepthPixels = 160;
constexpr float kDepthFov = 0.785f;

AffineTransform turned(double degrees, Float3 axis, Float3 move) {
  const double half = degrees * std::numbers::pi / 360;
  const auto s = static_cast<float>(std::sin(half));
  return rigidTransform({axis.x * s, axis.y * s, axis.z * s, static_cast<float>(std::cos(half))},
                        move);
}

View depthView(Float3 eye, Float3 target, bool reversed = false) {
  return cameraView({.eye = eye,
                     .target = target,
                     .fov = kDepthFov,
                     .width = kDepthPixels,
                     .nearPlane = 0.1f,
                     .farPlane = 10,
                     .reversedDepth = reversed});
}

/// Moves the picture by so many pixels, y down.
void addJitter(View& view, Float2 pixels) {
  Matrix4& m = view.worldToClip;
  const float x = 2 * pixels.x / kDepthPixels, y = -2 * pixels.y / kDepthPixels;
  const Float4 w = m.rows[3];
  m.rows[0] = {m.rows[0].x + x * w.x, m.rows[0].y + x * w.y, m.rows[0].z + x * w.z,
               m.rows[0].w + x * w.w};
  m.rows[1] = {m.rows[1].x + y * w.x, m.rows[1].y + y * w.y, m.rows[1].z + y * w.z,
               m.rows[1].w + y * w.w};
}

HairDepthSettings motionFrom(const View& last) {
  return {.color = HairDepthColor::kMotion, .previousWorldToClip = last.worldToClip};
}

struct Ends {
  Vector3d root, tip;
};

/// Straight strands. The root holds both vertices of one with two, so that they move as its bone.
HairAsset straightStrands(const std::vector<Ends>& ends, uint32_t vertices = 2) {
  HairAsset asset;
  asset.strandCount = static_cast<uint32_t>(ends.size());
  asset.verticesPerStrand = vertices;
  for (const auto& [root, tip] : ends) {
    for (uint32_t v = 0; v < vertices; ++v) {
      const Vector3d p = root + (tip - root) * (double{1} * v / (vertices - 1));
      asset.positions.push_back(
          {static_cast<float>(p.x()), static_cast<float>(p.y()), static_cast<float>(p.z()), 0});
    }
  }
  expectOk(asset.process());
  return asset;
}

/// A draw's results, [y][x].
struct Picture {
  std::vector<Float4> color;
  std::vector<float> depth;  ///< empty with several samples

  const Float4& at(uint32_t x, uint32_t y) const { return color[y * kDepthPixels + x]; }
  size_t covered() const { return coveredPixels(color); }
};

class StrandDepth : public SceneRunTest<> {
 protected:
  void SetUp() override {
    SceneRunTest::SetUp();
    if (run_.device() == nullptr) return;
    copy_ = run_.scene.resources().add({.name = "depth copy",
                                        .size = kDepthPixels * kDepthPixels * sizeof(float),
                                        .stride = sizeof(float),
                                        .usage = BufferUsage::kStorage | BufferUsage::kReadback});
  }
  void TearDown() override {
    SceneRunTest::TearDown();
    if (run_.device() != nullptr) run_.scene.resources().remove(copy_);
  }

  HairObject& add(const HairAsset& asset, HairDef def = {}) {
    def.settings.gravity = {};
    HairObject& hair = run_.add(asset, def);
    hair.tracksMotion = true;
    return hair;
  }
  /// One strand across the picture, from near to far: `pixels` wide in the middle.
  HairObject& addStrand(double pixels, uint32_t vertices = 2) {
    root_ = Vector3d(-0.25, -0.22, 0.1);
    tip_ = Vector3d(0.24, 0.3, -0.3);
    HairObject& hair = add(straightStrands({Ends{root_, tip_}}, vertices));
    hair.material.fiberRadius =
        static_cast<float>(pixels * std::tan(double{kDepthFov} / 2) / kDepthPixels);
    hair.material.tipRadiusRatio = 1;
    return hair;
  }
  void pose(const AffineTransform& bone) { hair().setBones({&bone, 1}); }
  HairObject& hair() { return run_.scene.hair(run_.lastHair()); }

  Picture draw(const View& view, const HairDepthSettings& settings, uint32_t samples = 1) {
    PassList list;
    return draw(view, settings, list, samples);
  }
  Picture draw(const View& view, const HairDepthSettings& settings, PassList& list,
               uint32_t samples = 1) {
    expectOk(run_.scene.drawDepth(view, settings, list));
    RenderTargetDef target;
    target.width = target.height = kDepthPixels;
    target.samples = samples;
    target.clearDepth = view.reversedDepth ? 0 : 1;
    target.float32Color = true;
    if (samples == 1) target.depthCopy = copy_;
    Result<RenderedImage> image = run_.renderLists({&list, 1}, target);
    // Not every device has several samples of 32 bits.
    target.float32Color = samples == 1;
    if (!image && samples > 1) image = run_.device()->render(list, target);
    EXPECT_TRUE(image) << image.error().message;
    Picture picture;
    picture.color =
        image ? image->pixels : std::vector<Float4>(size_t{kDepthPixels} * kDepthPixels);
    if (samples == 1) picture.depth = run_.read<float>(copy_);
    return picture;
  }

  BufferId copy_ = BufferId::kInvalid;
  Vector3d root_, tip_;  ///< of addStrand()
};

Vector2d pixelOf(const Matrix4d& clip, const Vector3d& p) {
  const Vector4d c = clip * p.homogeneous();
  return {(c.x() / c.w() * 0.5 + 0.5) * kDepthPixels, (0.5 - c.y() / c.w() * 0.5) * kDepthPixels};
}

double depthOf(const Matrix4d& clip, const Vector3d& p) {
  const Vector4d c = clip * p.homogeneous();
  return c.z() / c.w();
}

/// Where a pixel is beside a strand from root to tip.
struct Beside {
  double share = 0;     ///< along its image, 0..1
  double distance = 0;  ///< from its center line [pixels]
  Vector3d point;       ///< of the center line
};

Beside besideStrand(const Matrix4d& clip, const Vector3d& root, const Vector3d& tip,
                    const Vector2d& pixel) {
  const Vector2d a = pixelOf(clip, root), b = pixelOf(clip, tip);
  const Vector2d along = b - a;
  Beside beside;
  beside.share = (pixel - a).dot(along) / along.squaredNorm();
  beside.distance =
      std::abs(along.x() * (pixel - a).y() - along.y() * (pixel - a).x()) / along.norm();
  // 1 / w is linear on the screen.
  const double wa = (clip * root.homogeneous()).w(), wb = (clip * tip.homogeneous()).w();
  const double t = beside.share / wb / ((1 - beside.share) / wa + beside.share / wb);
  beside.point = root + (tip - root) * t;
  return beside;
}

TEST_P(StrandDepth, IsThatOfTheFiber) {
  addStrand(7);
  run_.step();
  for (const bool reversed : {false, true}) {
    const View view = depthView({0.1f, 0, 1}, {0, 0, 0}, reversed);
    const Matrix4d clip = toMatrix(view.worldToClip);
    for (const uint32_t samples : {1u, 4u}) {
      if ((run_.device()->info().sampleCounts & samples) == 0) continue;
      const Picture picture = draw(view, {.color = HairDepthColor::kDepth}, samples);
      size_t inside = 0;
      for (uint32_t y = 0; y < kDepthPixels; ++y) {
        for (uint32_t x = 0; x < kDepthPixels; ++x) {
          const Beside beside = besideStrand(clip, root_, tip_, Vector2d(x + 0.5, y + 0.5));
          const bool clear = beside.share < -0.03 || beside.share > 1.03 || beside.distance > 7;
          const bool full = beside.share > 0.03 && beside.share < 0.97 && beside.distance < 1.5;
          const Float4& pixel = picture.at(x, y);
          if (clear) {
            ASSERT_EQ(pixel.w, 0) << x << ", " << y;
            if (samples == 1) {
              ASSERT_EQ(picture.depth[y * kDepthPixels + x], reversed ? 0 : 1);
            }
          }
          if (!full) continue;
          ++inside;
          const double expected = depthOf(clip, beside.point);
          ASSERT_EQ(pixel.w, 1) << x << ", " << y;
          ASSERT_NEAR(double{pixel.x}, expected, 1e-5) << x << ", " << y;
          if (samples == 1) {
            ASSERT_NEAR(double{picture.depth[y * kDepthPixels + x]}, expected, 1e-5);
          }
        }
      }
      EXPECT_GT(inside, 200u);
    }
  }
}

TEST_P(StrandDepth, LeavesOutWhatIsTooThinOrTooClear) {
  const View view = depthView({0, 0, 1}, {0, 0, 0});
  HairObject& strand = addStrand(5, 24);
  run_.step();
  const auto covered = [&](float opacity) { return draw(view, {.opacity = opacity}).depth; };
  const auto count = [](const std::vector<float>& depth) {
    return std::count_if(depth.begin(), depth.end(), [](float d) { return d < 1; });
  };
  const auto all = count(covered(0));
  EXPECT_GT(all, 500);
  EXPECT_EQ(count(covered(1)), all);
  strand.material.opacity = 0.6f;
  EXPECT_EQ(count(covered(0.59f)), all);
  EXPECT_EQ(count(covered(0.61f)), 0);
  strand.material.opacity = 1;
  // Ribbons are at least a pixel wide; the strand is 0.4 pixels wide in the middle, and up to an
  // eighth more or a third less at its ends.
  strand.material.fiberRadius *= 0.08f;
  EXPECT_GT(count(covered(0)), 80);
  EXPECT_EQ(count(covered(0.1f)), count(covered(0)));
  EXPECT_EQ(count(covered(0.5f)), 0);
  // To a point: what is left of it ends where it is half a pixel wide.
  strand.material.fiberRadius *= 5;
  strand.material.tipRadiusRatio = 0;
  const Matrix4d clip = toMatrix(view.worldToClip);
  const Picture tapered = draw(view, {.opacity = 0.5f, .color = HairDepthColor::kDepth});
  double farthest = 0;
  for (uint32_t y = 0; y < kDepthPixels; ++y)
    for (uint32_t x = 0; x < kDepthPixels; ++x)
      if (!(tapered.at(x, y).w == 0))
        keepLargest(
            farthest,
            (besideStrand(clip, root_, tip_, Vector2d(x + 0.5, y + 0.5)).point - root_).norm());
  double expected = 0;
  for (int i = 0; i <= 1000; ++i) {
    const double t = i / 1000.0;
    const Vector3d p = root_ + (tip_ - root_) * t;
    const double w = (clip * p.homogeneous()).w();
    if (2 * (1 - t) / w >= 0.5) expected = t * (tip_ - root_).norm();
  }
  EXPECT_NEAR(farthest, expected, 0.03);
  EXPECT_LT(farthest, 0.9 * (tip_ - root_).norm());
}

TEST_P(StrandDepth, NearestFragmentWins) {
  const View view = depthView({0, 0, 1}, {0, 0, 0});
  // Objects in either order.
  for (const double first : {0.2, -0.2}) {
    for (const double z : {first, -first}) {
      HairObject& hair = add(straightStrands({Ends{Vector3d(-0.2, 0, z), Vector3d(0.2, 0, z)}}));
      hair.material.fiberRadius = 0.02f;
    }
    // The one that was added last moves alone.
    run_.step();
    pose(turned(0, {0, 0, 1}, {0, 0.01f, 0}));
    run_.step();
    const Picture picture = draw(view, motionFrom(view));
    const Float4& pixel = picture.at(kDepthPixels / 2, kDepthPixels / 2);
    const Vector3d near(0, 0, 0.2);
    EXPECT_NEAR(double{pixel.z}, depthOf(toMatrix(view.worldToClip), near), 1e-5);
    if (first > 0) {
      EXPECT_EQ(pixel.y, 0);
    } else {
      EXPECT_LT(pixel.y, -1);
    }
    run_.clear();
  }
}

// Geometry that hides hair hides its depth: the target already has the nearer depth.
TEST_P(StrandDepth, IsHiddenByWhatIsInFrontOfIt) {
  const View view = depthView({0, 0, 1}, {0, 0, 0});
  addStrand(5);
  run_.step();
  PassList list;
  expectOk(run_.scene.drawDepth(view, {.color = HairDepthColor::kDepth}, list));
  const Result<RenderedImage> image = required(run_.renderLists(
      {&list, 1}, {.width = kDepthPixels, .height = kDepthPixels, .clearDepth = 0.5f}));
  EXPECT_TRUE(std::ranges::all_of(image->pixels, [](const Float4& p) { return p.w == 0; }));
}

/// How the points of a strand moved that its bone moves from `before` to `now`.
struct RigidMotion {
  Matrix4d clip, clipBefore;
  Matrix4d toBefore;  ///< world now to world before
  Vector2d jitter = Vector2d::Zero();
};

Vector2d motionOf(const RigidMotion& m, const Vector3d& point, const Vector2d& pixel) {
  const Vector3d before = (m.toBefore * point.homogeneous()).head<3>();
  const double w = (m.clip * point.homogeneous()).w();
  const double wBefore = (m.clipBefore * before.homogeneous()).w();
  const Vector2d beside = pixel - pixelOf(m.clip, point);
  // The ribbon is as wide as the distance makes it.
  return pixel - (pixelOf(m.clipBefore, before) + beside * (w / wBefore)) - m.jitter;
}

/// Inside of the strand from root to tip. \return the largest motion [pixels]
double expectMotionOf(const Picture& picture, const RigidMotion& motion, const Vector3d& root,
                      const Vector3d& tip) {
  size_t inside = 0;
  double largest = 0;
  for (uint32_t y = 0; y < kDepthPixels; ++y) {
    for (uint32_t x = 0; x < kDepthPixels; ++x) {
      const Vector2d pixel(x + 0.5, y + 0.5);
      const Beside beside = besideStrand(motion.clip, root, tip, pixel);
      if (!(beside.share > 0.03 && beside.share < 0.97 && beside.distance < 1.5)) continue;
      ++inside;
      const Vector2d expected = motionOf(motion, beside.point, pixel);
      keepLargest(largest, expected.norm());
      const Float4& found = picture.at(x, y);
      EXPECT_NEAR(double{found.x}, expected.x(), 1e-3) << x << ", " << y;
      EXPECT_NEAR(double{found.y}, expected.y(), 1e-3) << x << ", " << y;
      EXPECT_NEAR(double{found.z}, depthOf(motion.clip, beside.point), 1e-5);
      EXPECT_EQ(found.w, 1);
    }
  }
  EXPECT_GT(inside, 200u);
  return largest;
}

/// Largest error of the motion over all pixels of hair, whose points are found by their depths.
double motionError(const Picture& picture, const RigidMotion& motion) {
  const Matrix4d inverse = motion.clip.inverse();
  double worst = 0;
  for (uint32_t y = 0; y < kDepthPixels; ++y) {
    for (uint32_t x = 0; x < kDepthPixels; ++x) {
      const Float4& pixel = picture.at(x, y);
      if (pixel.w == 0) continue;
      const Vector2d at(x + 0.5, y + 0.5);
      const Vector4d world = inverse * Vector4d(at.x() / kDepthPixels * 2 - 1,
                                                1 - at.y() / kDepthPixels * 2, double{pixel.z}, 1);
      const Vector2d expected = motionOf(motion, world.head<3>() / world.w(), at);
      keepLargest(worst, (Vector2d(double{pixel.x}, double{pixel.y}) - expected).norm());
    }
  }
  return worst;
}

TEST_P(StrandDepth, MotionOfARigidStrandIsTheAnalyticOne) {
  addStrand(6);
  const AffineTransform before = turned(10, {0, 0.6f, 0.8f}, {0.01f, -0.02f, 0.03f});
  const AffineTransform now = turned(14, {0, 0.6f, 0.8f}, {0.03f, -0.01f, 0.06f});
  pose(before);
  run_.step();
  run_.step();
  pose(now);
  run_.step();
  const View last = depthView({0.1f, 0, 1}, {0, 0, 0}),
             view = depthView({0.13f, 0.03f, 0.97f}, {0.02f, 0, 0});
  for (const bool cameraMoves : {false, true}) {
    for (const bool jitters : {false, true}) {
      View from = cameraMoves ? last : view, to = view;
      HairDepthSettings settings = {.color = HairDepthColor::kMotion};
      RigidMotion motion;
      motion.toBefore = toMatrix(before) * toMatrix(now).inverse();
      if (jitters) {
        settings.jitter = {0.4f, -0.3f};
        settings.previousJitter = {-0.25f, 0.125f};
        addJitter(to, settings.jitter);
        addJitter(from, settings.previousJitter);
        motion.jitter = Vector2d(0.65, -0.425);
      }
      settings.previousWorldToClip = from.worldToClip;
      motion.clip = toMatrix(to.worldToClip);
      motion.clipBefore = toMatrix(from.worldToClip);
      const Vector3d root = (toMatrix(now) * root_.homogeneous()).head<3>();
      const Vector3d tip = (toMatrix(now) * tip_.homogeneous()).head<3>();
      EXPECT_GT(expectMotionOf(draw(to, settings), motion, root, tip), 3) << "pixels";
    }
  }
}

TEST_P(StrandDepth, StillHairUnderAMovingCameraMovesAsThePicture) {
  addStrand(6);
  run_.step();
  run_.step();
  const View from = depthView({0.1f, 0, 1}, {0, 0, 0}),
             to = depthView({0.2f, 0.1f, 0.8f}, {0, 0.02f, 0});
  const RigidMotion motion = {toMatrix(to.worldToClip), toMatrix(from.worldToClip),
                              Matrix4d::Identity()};
  // With and without positions of before.
  for (const bool tracks : {true, false}) {
    hair().tracksMotion = tracks;
    run_.step();
    expectMotionOf(draw(to, motionFrom(from)), motion, root_, tip_);
  }
}

/// Guides in all directions from a ball of 10 cm, with follow hairs between them.
struct Fur {
  HairAsset asset;
  std::vector<FollowHair> follows;
};

Fur makeFur() {
  std::vector<Ends> ends;
  for (int i = 0; i < 40; ++i) {
    const double z = 1 - (i + 0.5) / 20, angle = 2.4 * i;
    const Vector3d out(std::sqrt(1 - z * z) * std::cos(angle),
                       std::sqrt(1 - z * z) * std::sin(angle), z);
    ends.push_back({0.1 * out, 0.3 * out + Vector3d(0.02, 0, 0)});
  }
  Fur fur = {straightStrands(ends), {}};
  for (uint32_t i = 0; i < 80; ++i) {
    FollowHair follow = {.guide = i % 40, .offset = {0.01f, 0.005f, -0.01f, 1.6f}};
    if (i >= 40) {
      follow.otherGuides[0] = (i + 1) % 40;
      follow.otherGuides[1] = (i + 3) % 40;
      follow.otherWeights[0] = 0.3f;
      follow.otherWeights[1] = 0.2f;
    }
    fur.follows.push_back(follow);
  }
  return fur;
}

// Every pixel of hair that is rigid, found by its depth: follow hairs, computed and stored, level
// of detail, attributes, and hair that is not simulated.
TEST_P(StrandDepth, MotionOfAllKindsOfStrandsFollowsTheRoots) {
  const Fur fur = makeFur();
  const AffineTransform before = turned(10, {0, 0.6f, 0.8f}, {0.01f, -0.02f, 0.03f});
  const AffineTransform now = turned(13, {0, 0.6f, 0.8f}, {0.02f, -0.01f, 0.05f});
  const View from = depthView({0.02f, 0, 1}, {0, 0, 0}),
             view = depthView({0, 0.01f, 1.02f}, {0, 0, 0});
  for (const int kind : {0, 1, 2, 3, 4, 5}) {
    SCOPED_TRACE(kind);
    HairDef def = {.levelOfDetail = kind == 3, .storeFollowHairs = kind == 2};
    HairAsset asset = fur.asset;
    if (kind > 0) def.followHairs = fur.follows;
    if (kind == 4) asset.strandThickness.assign(asset.strandCount, 1.5f);
    if (kind == 4) def.skinning = SkinningMethod::kDualQuaternions;
    HairObject& object = add(asset, def);
    object.material.fiberRadius = 0.002f;
    object.material.tipRadiusRatio = 1;
    if (kind == 3) object.simulatedShare = 0.5f;
    object.simulated = kind != 5;
    pose(before);
    // The level of detail changes over a quarter of a second.
    for (int i = 0; i < 18; ++i) run_.step();
    pose(now);
    run_.step();
    const Picture picture = draw(view, motionFrom(from));
    const RigidMotion motion = {toMatrix(view.worldToClip), toMatrix(from.worldToClip),
                                toMatrix(before) * toMatrix(now).inverse()};
    EXPECT_GT(picture.covered(), kind == 0 ? 600u : 1500u);
    // A ribbon does not turn about its center line; it is a few pixels wide.
    EXPECT_LT(motionError(picture, motion), 0.15) << "pixels";
    run_.clear();
  }
}

TEST_P(StrandDepth, MotionIsZeroWhereNothingMoves) {
  const Fur fur = makeFur();
  const View view = depthView({0.1f, 0, 1}, {0, 0, 0});
  const HairDepthSettings settings = motionFrom(view);
  const auto expectStill = [&](const char* when) {
    const Picture picture = draw(view, settings);
    EXPECT_GT(picture.covered(), 1000u) << when;
    for (const Float4& pixel : picture.color)
      ASSERT_TRUE(pixel.x == 0 && pixel.y == 0) << when << ": " << pixel.x << ", " << pixel.y;
  };
  const auto expectMoving = [&](const char* when) {
    const Picture picture = draw(view, settings);
    const auto moving = std::ranges::count_if(
        picture.color, [](const Float4& p) { return p.w > 0 && std::hypot(p.x, p.y) > 0.3f; });
    EXPECT_GT(moving, 500) << when;
  };
  for (const bool stored : {false, true}) {
    HairObject& object = add(fur.asset, {.followHairs = fur.follows, .storeFollowHairs = stored});
    object.material.fiberRadius = 0.002f;
    pose(turned(10, {0, 1, 0}, {0.01f, 0, 0}));
    run_.step();
    expectStill("the first frame is a reset");
    pose(turned(12, {0, 1, 0}, {0.02f, 0, 0}));
    run_.step();
    expectMoving("moved");
    run_.step(0);
    expectStill("paused");
    run_.step();
    run_.step();
    expectStill("at rest");
    pose(turned(40, {0, 1, 0}, {0.1f, 0, 0}));
    object.reset();
    run_.step();
    expectStill("teleported");
    pose(turned(42, {0, 1, 0}, {0.1f, 0, 0}));
    run_.step();
    expectMoving("moved again");
    // A change of the spread moves follow hairs, once.
    run_.step();
    object.settings.tipSeparation = 3;
    run_.step();
    expectMoving("spread");
    run_.step();
    expectStill("after the spread");
    object.tracksMotion = false;
    pose(turned(45, {0, 1, 0}, {0.1f, 0, 0}));
    run_.step();
    expectStill("untracked");
    object.tracksMotion = true;
    pose(turned(47, {0, 1, 0}, {0.1f, 0, 0}));
    run_.step();
    expectMoving("tracked from this frame on");
    run_.clear();
  }
}

// Between fixed steps, motion is that from one drawn frame to the next one.
TEST_P(StrandDepth, MotionIsThatBetweenTheFramesThatAreDrawn) {
  const Fur fur = makeFur();
  const View view = depthView({0.1f, 0, 1}, {0, 0, 0});
  const auto place = [&](float share, float dt = 0) {
    PassList list;
    expectOk(run_.scene.simulate(dt, list));
    expectOk(run_.scene.interpolate(share, list));
    run_.execute(list);
  };
  // Hair that goes along x by so many metres between the frames that are drawn.
  const auto expectMotion = [&](double along, const char* when) {
    const Picture picture = draw(view, motionFrom(view));
    EXPECT_GT(picture.covered(), 1000u) << when;
    RigidMotion motion = {toMatrix(view.worldToClip), toMatrix(view.worldToClip),
                          Matrix4d::Identity()};
    motion.toBefore(0, 3) = -along;
    EXPECT_LT(motionError(picture, motion), 0.15) << when << " [pixels]";
  };
  const auto poseAt = [&](float x) { pose(turned(0, {0, 1, 0}, {x, 0, 0})); };
  for (const bool stored : {false, true}) {
    HairObject& object = add(fur.asset, {.followHairs = fur.follows, .storeFollowHairs = stored});
    object.material.fiberRadius = 0.002f;
    object.interpolates = true;
    poseAt(0);
    run_.step();
    poseAt(0.02f);
    run_.step();
    place(0.25f);
    expectMotion(0, "nothing was drawn before");
    place(0.75f);
    expectMotion(0.01, "half of a step");
    place(0.75f);
    expectMotion(0, "at rest");
    // Two steps between two frames, from 0.015 to 0.04 + 0.005.
    poseAt(0.04f);
    run_.step();
    poseAt(0.06f);
    place(0.25f, 1.0f / 60);
    expectMotion(0.03, "two steps");
    object.reset();
    poseAt(-0.05f);
    run_.step();
    place(0.5f);
    expectMotion(0, "reset");
    expectOk(run_.scene.teleport(run_.lastHair(), turned(0, {0, 1, 0}, {0.08f, 0, 0})));
    place(0.5f, 1.0f / 60);
    expectMotion(0, "teleported");
    poseAt(0.05f);
    run_.step();
    place(0.5f);
    expectMotion(0.01, "moved again");
    expectOk(run_.scene.shiftOrigin({1, 0, 0}));
    expectOk(run_.scene.shiftOrigin({-1, 0, 0}));
    place(1);
    expectMotion(0.01, "shifted");
    run_.step(0);
    expectMotion(0, "not interpolated");
    run_.clear();
  }
}

// A frame that does not run moves nothing.
TEST_P(StrandDepth, LostFramesMoveNothing) {
  const Fur fur = makeFur();
  const View view = depthView({0.1f, 0, 1}, {0, 0, 0});
  const HairDepthSettings settings = motionFrom(view);
  std::vector<Picture> pictures;
  for (const int lost : {0, 1, 2}) {
    HairObject& object = add(fur.asset, {.followHairs = fur.follows});
    object.material.fiberRadius = 0.002f;
    for (int i = 0; i < 3; ++i) run_.step();
    PassList list;
    for (int i = 0; i < lost; ++i) {
      pose(turned(20 + 5 * i, {0, 1, 0}, {0.05f, 0, 0}));
      object.tracksMotion = i == 1;
      expectOk(run_.scene.simulate(1.0f / 60, list));
      run_.scene.finish(list);
      if (i == 0) continue;
      expectOk(run_.device()->update(run_.scene.resources()));
      run_.scene.abandon(list);
      // Until the next simulation, hair is where it was.
      object.tracksMotion = true;
      const Picture still = draw(view, settings);
      EXPECT_GT(still.covered(), 1000u);
      for (const Float4& pixel : still.color) ASSERT_TRUE(pixel.x == 0 && pixel.y == 0);
    }
    object.tracksMotion = true;
    pose(turned(3, {0, 1, 0}, {0.02f, 0, 0}));
    run_.step();
    pictures.push_back(draw(view, settings));
    run_.clear();
  }
  EXPECT_GT(std::ranges::count_if(pictures[0].color,
                                  [](const Float4& p) { return std::hypot(p.x, p.y) > 1; }),
            1000);
  EXPECT_TRUE(pictures[0].color == pictures[1].color);
  EXPECT_TRUE(pictures[0].color == pictures[2].color);
}

TEST_P(StrandDepth, ShiftsOfTheOriginAreNoMotion) {
  const Fur fur = makeFur();
  View view = depthView({0.1f, 0, 1}, {0, 0, 0});
  for (const bool stored : {false, true}) {
    for (const bool simulates : {true, false}) {
      HairObject& object = add(fur.asset, {.followHairs = fur.follows, .storeFollowHairs = stored});
      object.material.fiberRadius = 0.002f;
      AffineTransform now = turned(10, {0, 1, 0}, {0.01f, 0, 0});
      pose(now);
      run_.step();
      if (!simulates) {
        now = turned(12, {0, 1, 0}, {0.02f, 0, 0});
        pose(now);
        run_.step();
      }
      const Float3 shift = {-3, 2, 5};
      expectOk(run_.scene.shiftOrigin(shift));
      const View moved = depthView({view.eye.x + 3, view.eye.y - 2, view.eye.z - 5}, {3, -2, -5});
      const HairDepthSettings settings = motionFrom(moved);
      if (simulates) {
        now = turned(12, {0, 1, 0}, {3.02f, -2, -5});
        pose(now);
        run_.step();
      }
      const Picture picture = draw(moved, settings);
      expectOk(run_.scene.shiftOrigin({3, -2, -5}));
      Picture expected;
      {
        object.reset();
        pose(turned(10, {0, 1, 0}, {0.01f, 0, 0}));
        run_.step();
        pose(turned(12, {0, 1, 0}, {0.02f, 0, 0}));
        run_.step();
        expected = draw(view, motionFrom(view));
      }
      size_t same = 0;
      for (size_t i = 0; i < picture.color.size(); ++i) {
        const Float4 &a = picture.color[i], &b = expected.color[i];
        // Strands in front of others may change with the rounding.
        if (a.w == 0 || b.w == 0 || !(std::abs(a.z - b.z) < 1e-5f)) continue;
        ++same;
        ASSERT_NEAR(a.x, b.x, 0.01) << i;
        ASSERT_NEAR(a.y, b.y, 0.01) << i;
      }
      EXPECT_GT(same, 1000u);
      EXPECT_GT(same, picture.covered() * 9 / 10);
      run_.clear();
    }
  }
}

TEST_P(StrandDepth, MotionFromBehindTheEyeLeavesThePicture) {
  addStrand(6);
  run_.step();
  run_.step();
  const View view = depthView({0, 0, 1}, {0, 0, 0});
  const View last = depthView({0, 0, -1}, {0, 0, -2});
  const Picture picture = draw(view, motionFrom(last));
  EXPECT_GT(picture.covered(), 200u);
  for (uint32_t y = 0; y < kDepthPixels; ++y) {
    for (uint32_t x = 0; x < kDepthPixels; ++x) {
      const Float4& pixel = picture.at(x, y);
      if (pixel.w == 0) continue;
      const float at = static_cast<float>(x) - pixel.x;
      ASSERT_TRUE(at < 0 || at > kDepthPixels) << pixel.x;
      ASSERT_LT(std::abs(pixel.x), 65504);
    }
  }
}

TEST_P(StrandDepth, SurvivesVerticesThatAreNotFinite) {
  HairObject& object = add(makeFur().asset);
  object.material.fiberRadius = 0.002f;
  run_.step();
  AffineTransform broken;
  broken.rows[0].x = kNan;
  pose(broken);
  run_.step();
  const View view = depthView({0, 0, 1}, {0, 0, 0});
  const Picture picture = draw(view, motionFrom(view));
  for (const Float4& pixel : picture.color)
    ASSERT_TRUE(std::isfinite(pixel.x) && std::isfinite(pixel.y) && std::isfinite(pixel.z));
}

// As an engine does it: a view of hair, and one of its depth and motion.
TEST_P(StrandDepth, IsAViewOfItsOwnInAFrame) {
  addStrand(6);
  run_.step();
  pose(turned(0, {0, 1, 0}, {0.02f, 0, 0}));
  auto frame = required(run_.scene.simulate(1.0f / 60));
  View view = depthView({0, 0, 1}, {0, 0, 0});
  const Light light;
  const auto hairs = frame->draw(view, {&light, 1});
  // A corner of a larger target.
  view.x = 32;
  view.y = 16;
  const auto depth = frame->drawDepth(view, motionFrom(view));
  ASSERT_TRUE(hairs && depth);
  EXPECT_EQ(*depth, 1u);
  EXPECT_EQ(frame->viewCount(), 2u);
  const RenderTargetDef targets[] = {{.width = kDepthPixels, .height = kDepthPixels},
                                     {.width = 2 * kDepthPixels,
                                      .height = 2 * kDepthPixels,
                                      .area = {32, 16, kDepthPixels, kDepthPixels},
                                      .float32Color = true}};
  const auto images = required(run_.device()->render(*frame, targets));
  const double scale = kDepthPixels / 2.0 / std::tan(double{kDepthFov} / 2);
  size_t covered = 0;
  for (uint32_t y = 0; y < 2 * kDepthPixels; ++y) {
    for (uint32_t x = 0; x < 2 * kDepthPixels; ++x) {
      const Float4& pixel = (*images)[1].pixels[y * 2 * kDepthPixels + x];
      if (pixel.w == 0) continue;
      ++covered;
      ASSERT_TRUE(x >= 32 && y >= 16 && x < 32 + kDepthPixels && y < 16 + kDepthPixels);
      // 0.02 m across the sight.
      const Matrix4d clip = toMatrix(view.worldToClip);
      const Vector4d world = clip.inverse() * Vector4d(0, 0, double{pixel.z}, 1);
      ASSERT_NEAR(double{pixel.x}, 0.02 * scale / (1 - world.z() / world.w()), 1e-3);
      ASSERT_NEAR(pixel.y, 0, 1e-3);
    }
  }
  EXPECT_GT(covered, 300u);
}

INSTANTIATE_TEST_SUITE_P(All, StrandDepth, testing::ValuesIn(kApis), apiTestName);

TEST(StrandDepthOff, CostsNoPassAndNoBuffer) {
  Scene scene;
  const auto hair = required(scene.addHair(makeAsset(), {}));
  PassList list;
  const auto step = [&] {
    EXPECT_TRUE(scene.simulate(1.0f / 60, list));
    scene.finish(list);
    setDelivered(list.run);
  };
  for (int i = 0; i < 3; ++i) step();
  EXPECT_EQ(countPasses(list, "keep_positions"), 0u);
  const size_t passes = list.passes.size();
  const uint32_t buffers = scene.resources().count();
  EXPECT_EQ(scene.hair(*hair).buffers().previousPositions, BufferId::kInvalid);
  // Draws of depth make nothing, and motion takes the camera's where nothing is tracked.
  const View view = depthView({0, 0, 1}, {0, 0, 0});
  for (const HairDepthColor color :
       {HairDepthColor::kNone, HairDepthColor::kDepth, HairDepthColor::kMotion}) {
    PassList drawn;
    ASSERT_TRUE(scene.drawDepth(view, {.color = color}, drawn));
    EXPECT_EQ(drawn.passes.size(), 1u);
    const bool motion = color == HairDepthColor::kMotion;
    EXPECT_STREQ(drawn.passes[0].kernel->kernel->name,
                 motion ? "strand_motion_vertex" : "strand_vertex");
    EXPECT_EQ(drawn.passes[0].state.colorWrite, color != HairDepthColor::kNone);
  }
  EXPECT_EQ(scene.resources().count(), buffers);

  scene.hair(*hair).tracksMotion = true;
  step();
  EXPECT_EQ(countPasses(list, "keep_positions"), 1u);
  EXPECT_EQ(list.passes.size(), passes + 1);
  EXPECT_EQ(scene.resources().count(), buffers + 1);
  EXPECT_NE(scene.hair(*hair).buffers().previousPositions, BufferId::kInvalid);
  scene.hair(*hair).tracksMotion = false;
  step();
  step();
  EXPECT_EQ(list.passes.size(), passes);
  EXPECT_EQ(scene.resources().count(), buffers);
  EXPECT_EQ(scene.hair(*hair).buffers().previousPositions, BufferId::kInvalid);

  scene.hair(*hair).tracksMotion = true;
  step();
  EXPECT_TRUE(scene.removeHair(*hair));
  EXPECT_EQ(scene.resources().count(), 0u);
}

TEST(StrandDepthTiers, HaveBuffersForStrandsOnTheScreenAndGiveThemBack) {
  for (const Tier tier : {Tier::kEs, Tier::kBase}) {
    Scene scene;
    scene.setTier(tier);
    ASSERT_TRUE(scene.addHair(makeAsset(), {}));
    PassList list;
    ASSERT_TRUE(scene.simulate(1.0f / 60, list));
    scene.finish(list);
    setDelivered(list.run);
    const uint32_t buffers = scene.resources().count();
    const View view = depthView({0, 0, 1}, {0, 0, 0});
    // Two views of a frame have one each, and the next frame has them again.
    for (int frame = 0; frame < 3; ++frame) {
      ASSERT_TRUE(scene.simulate(1.0f / 60, list));
      scene.finish(list);
      setDelivered(list.run);
      PassList depth, motion;
      ASSERT_TRUE(scene.drawDepth(view, {}, depth));
      ASSERT_TRUE(scene.drawDepth(view, {.color = HairDepthColor::kMotion}, motion));
      EXPECT_EQ(depth.passes.size(), 2u);
      EXPECT_EQ(motion.passes.size(), 3u);
      EXPECT_EQ(countPasses(motion, "transform_motion"), 1u);
      for (PassList* drawn : {&depth, &motion}) {
        for (const Pass& pass : drawn->passes) {
          expectOk(checkLimits(*pass.kernel, pass.pixel, limitsOf(tier), "a phone"));
        }
        scene.finish(*drawn);
        setDelivered(drawn->run);
      }
      EXPECT_EQ(scene.resources().count(), buffers + 2);
    }
    expectError(scene.drawDepth(view, {.maxBytes = 100}, list), "maxBytes");
    expectError(scene.drawDepth(view, {.maxBufferBytes = 100}, list), "maxBufferBytes");
    scene.trim();
    EXPECT_EQ(scene.resources().count(), buffers);
  }
}

TEST(StrandDepthErrors, NameTheMemberThatIsOutOfRange) {
  Scene scene;
  ASSERT_TRUE(scene.addHair(makeAsset(), {}));
  const View view = depthView({0, 0, 1}, {0, 0, 0});
  PassList list;
  const auto refuses = [&](const View& drawn, const HairDepthSettings& settings, const char* word) {
    expectError(scene.drawDepth(drawn, settings, list), word);
  };
  for (const float opacity : {-0.1f, 1.1f, kNan}) refuses(view, {.opacity = opacity}, "opacity");
  HairDepthSettings settings = {.color = HairDepthColor::kMotion};
  settings.previousWorldToClip.rows[2].y = kNan;
  refuses(view, settings, "previousWorldToClip");
  refuses(view, {.color = HairDepthColor::kMotion, .jitter = {0, kNan}}, "jitter");
  refuses(view, {.color = HairDepthColor::kMotion, .previousJitter = {INFINITY, 0}},
          "previousJitter");
  View empty = view;
  empty.width = 0;
  refuses(empty, {}, "pixels");
  EXPECT_TRUE(list.passes.empty());
  expectOk(scene.drawDepth(view, {}, list));
  EXPECT_EQ(list.passes.size(), 1u);
}

}  // namespace
}  // namespace pelage::test
