// simulate_exact against the float reference bit by bit, the double one, and its invariants.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <map>
#include <span>
#include <string>
#include <vector>

#include "pelage/gpu_structs.h"
#include "pelage/kernels.h"
#include "reference/rod/exact_rod.h"
#include "simulation/exact_solver.h"
#include "support/exact_pass.h"
#include "support/not_numbers.h"
#include "support/strand_measures.h"

namespace pelage::rod {
namespace {

using test::apiTestName;
using test::ExactKey;
using test::expectOk;
using test::Gpu;
using test::GpuTest;
using test::isFinite;
using test::kApis;
using test::keepLargest;
using test::kNan;
using test::Random;
using test::sameBits;

constexpr uint32_t kTile = 32;

Float4 toFloat4(const Vector3d& v, double w = 0) {
  return {static_cast<float>(v.x), static_cast<float>(v.y), static_cast<float>(v.z),
          static_cast<float>(w)};
}
Float4 toFloat4(const Quaterniond& q) { return toFloat4(q.vector(), q.w); }
Vector3d toVector(const Float4& v) { return Vector3d(Vector3<float>(v.x, v.y, v.z)); }

/// A helix of 0.25 m, anywhere from nearly straight to a tight curl.
RestStrand makeStrand(Random& random, int vertices) {
  const double radius = random.between(0.002, 0.022), rotations = random.between(0.3, 4.3);
  std::vector<Vector3d> points = helixPoints(vertices, radius, 0.25 / rotations, rotations);
  const Quaterniond relativeRotation =
      normalized(Quaterniond(random.between(-0.5, 0.5), random.between(-0.5, 0.5),
                             random.between(-0.5, 0.5), random.unit() + 0.01));
  const Vector3d root(random.between(0, 0.1), random.between(0, 0.1), random.between(0, 0.1));
  for (Vector3d& p : points) p = rotate(relativeRotation, p) + root;
  return RestStrand(points);
}

std::vector<RestStrand> makeStrands(const std::vector<int>& counts, uint64_t seed = 7) {
  Random random(seed);
  std::vector<RestStrand> strands;
  for (const int count : counts) strands.push_back(makeStrand(random, count));
  return strands;
}

/// The buffers of one object on a device, in tiles of 32 strands sorted by vertex count.
class RodRun {
 public:
  RodRun(Gpu& gpu, const std::vector<RestStrand>& rests, const ExactKey& key, bool holdTip = false)
      : RodRun(gpu, rests, key, pack(rests, holdTip)) {}

  /// Advances by `dt` seconds from one pose of the roots to another, as ExactRod::step() does.
  void step(double dt, const RootPose& from, const RootPose& to, const RodSettings& settings) {
    std::vector<Float4> roots;
    for (const RootPose* pose : {&to, &from}) {
      for (const RestStrand& rest : rests_) {
        roots.push_back(toFloat4(pose->rotation));
        roots.push_back(toFloat4(pose->apply(rest.positions[0])));
      }
    }
    setRoots(roots);
    stepWithRoots(dt, settings);
  }
  /// A frame of 1/60 s of the head's motion.
  void stepHead(int frame, const RodSettings& settings) {
    step(1.0 / 60, shakenHead(frame / 60.0), shakenHead((frame + 1) / 60.0), settings);
  }
  /// The same with root transforms as they were last set.
  void stepWithRoots(double dt, const RodSettings& settings) {
    pass_.begin(list_);
    for (int k = 0; k < settings.subSteps; ++k) {
      const double h = dt / settings.subSteps;
      setConstants(h, settings);
      constants.rootBegin = static_cast<float>(static_cast<double>(k) / settings.subSteps);
      constants.rootEnd = static_cast<float>(static_cast<double>(k + 1) / settings.subSteps);
      constants.frameTime = static_cast<float>(dt);
      constants.frameTimeBefore = static_cast<float>(frameBefore_ > 0 ? frameBefore_ : dt);
      constants.flags = (stepBefore_ > 0 ? 0u : 1u) | (k + 1 == settings.subSteps ? 2u : 0u) |
                        (constants.rotationRatio != 1 ? 32u : 0u);
      const auto& g = settings.gravity;
      pass_.solve(list_, {.index = static_cast<uint32_t>(k),
                          .begin = constants.rootBegin,
                          .end = constants.rootEnd,
                          .length = static_cast<float>(h),
                          .gravity = {static_cast<float>(g.x), static_cast<float>(g.y),
                                      static_cast<float>(g.z)},
                          .furtherRange = furtherRange_});
      constants.slot = (constants.slot + 1) % 4;
      stepBefore_ = h;
    }
    frameBefore_ = dt;
    gpu_.execute(list_);
  }
  /// The next step starts from the rest shape, without history.
  void reset() {
    stepBefore_ = frameBefore_ = 0;
    coefficients_ = coefficientsBefore_ = {};
    if (pass_.contacts) pass_.contacts->forget();
  }
  /// Colliders of the contacts permutation.
  void setColliders(const std::vector<Collider>& colliders) {
    pass_.contacts->setCapsules(list_, colliders);
  }
  /// Contacts are found within this more than scenes find them in [m].
  void setFurtherRange(float range) { furtherRange_ = range; }
  ContactCounters counters() const { return pass_.contacts->counters(); }

  std::vector<Float4> positions() const { return pass_.positions.read(); }
  std::vector<Float4> tangents() const { return pass_.tangents.read(); }
  /// Without the scratch and the roots behind it.
  std::vector<Float4> state() const {
    std::vector<Float4> all = pass_.state.read();
    all.resize(size_t{8} * constants.stateStride + 20 * rests_.size());
    return all;
  }
  void setState(const std::vector<Float4>& state) {
    addUpload(list_, pass_.state.id(), std::as_bytes(std::span(state)));
  }
  void setRoots(const std::vector<Float4>& roots) {
    pass_.roots.upload(list_, roots);
    addUpload(list_, pass_.state.id(), std::as_bytes(std::span(roots)),
              firstRoot(stride(), rests_.size()) * sizeof(Float4));
  }
  const std::vector<ExactStrand>& records() const { return packed_.records; }
  void setRecords(const std::vector<ExactStrand>& records) {
    pass_.rest.upload(list_, withRecords(packed_.rest, records));
  }
  uint32_t stride() const { return constants.stateStride; }
  void checkGuards() const { pass_.checkGuards(); }

 private:
  // Element of g_state.
  static size_t firstRoot(size_t stride, size_t strands) {
    return (14 * stride + 20 * strands + 15) / 16 * 16;
  }
  // As g_rest has them.
  static std::vector<Float4> withRecords(std::vector<Float4> sets,
                                         const std::vector<ExactStrand>& records) {
    const size_t end = sets.size();
    sets.resize(end + records.size() * sizeof(ExactStrand) / sizeof(Float4));
    std::memcpy(static_cast<void*>(sets.data() + end), records.data(),
                records.size() * sizeof(ExactStrand));
    return sets;
  }
  struct Packed {
    std::vector<ExactStrand> records;
    std::vector<Float4> rest;
    uint32_t stride = 0, outputs = 0;
  };

  RodRun(Gpu& gpu, const std::vector<RestStrand>& rests, const ExactKey& key, const Packed& packed)
      : gpu_(gpu),
        rests_(rests),
        packed_(packed),
        pass_(gpu, key,
              {.strands = packed.records,
               .state =
                   std::vector<Float4>(firstRoot(packed.stride, rests.size()) + 4 * rests.size()),
               .rest = withRecords(packed.rest, packed.records),
               .roots = std::vector<Float4>(4 * rests.size()),
               .stride = packed.stride,
               .strandRecords = static_cast<uint32_t>(packed.rest.size()),
               .outputs = packed.outputs},
              kMaxSubSteps) {}

  static Packed pack(const std::vector<RestStrand>& rests, bool holdTip) {
    Packed packed;
    for (uint32_t s = 0; s < rests.size(); ++s) {
      const auto count = static_cast<uint32_t>(rests[s].size());
      packed.records.push_back({.count = count,
                                .target = packed.outputs,
                                .root = s,
                                .seed = s,
                                .strandLength = static_cast<float>(rests[s].length())});
      packed.outputs += count;
    }
    std::stable_sort(packed.records.begin(), packed.records.end(),
                     [](const auto& a, const auto& b) { return a.count < b.count; });
    for (size_t from = 0; from < packed.records.size(); from += kTile) {
      const size_t to = std::min(packed.records.size(), from + kTile);
      for (size_t s = from; s < to; ++s)
        packed.records[s].state = packed.stride + static_cast<uint32_t>(s - from);
      packed.stride += kTile * packed.records[to - 1].count;
    }
    packed.rest.resize(size_t{2} * packed.stride);
    for (const ExactStrand& record : packed.records) {
      const RestStrand& rest = rests[record.root];
      for (int v = 0; v < rest.size(); ++v) {
        const auto i = static_cast<size_t>(v);
        const size_t at = record.state + kTile * i;
        const bool tip = v + 1 == rest.size();
        if (v == 0)
          packed.rest[at] = toFloat4(rest.relative[0]);
        else if (tip)
          packed.rest[at] = toFloat4(Vector3d(rest.lengths[0], 0, 0), rest.voronoiLengths[i]);
        else
          packed.rest[at] = packJoint(rest, i);
        packed.rest[packed.stride + at] =
            toFloat4(rest.positions[i] - rest.positions[0], holdTip && tip ? -1 : rest.share[i]);
      }
    }
    return packed;
  }

  static Float4 packJoint(const RestStrand& rest, size_t i) {
    const Quaterniond& q = rest.relative[i];
    const double scale = (q.w < 0 ? -1 : 1) / (1 + std::abs(q.w));
    return toFloat4(Vector3d(q.y * scale, q.z * scale, rest.lengths[i]), rest.voronoiLengths[i]);
  }

  void setConstants(double h, const RodSettings& s) {
    const StepCoefficients c = StepCoefficients::of(h, stepBefore_, stepBefore_ > 0);
    const double weight = 1 / (c.he * c.he) + s.material.airDrag / c.he;
    const Vector3d drift = (s.gravity + s.wind * s.material.airDrag) * (1 / weight);
    constants.drift = toFloat4(drift);
    constants.historyShare = static_cast<float>(c.a2);
    constants.inverseStep = static_cast<float>(1 / c.he);
    constants.weight = static_cast<float>(weight);
    const StepCoefficients &c1 = coefficients_, &c2 = coefficientsBefore_;
    const double share = 1 / (c.he * weight);
    const double rate = c1.he > 0 ? 1 / c1.he : 0, rateBefore = c2.he > 0 ? 1 / c2.he : 0;
    constants.displacementShare = static_cast<float>(share * (1 - c.a2) * rate - c.a2);
    constants.displacementShareBefore =
        static_cast<float>(share * ((1 - c.a2) * c1.a2 * rate + c.a2 * rateBefore));
    constants.displacementShareEarlier = static_cast<float>(share * c.a2 * c2.a2 * rateBefore);
    coefficientsBefore_ = coefficients_;
    coefficients_ = c;
    constants.rotationRatio = stepBefore_ > 0 ? static_cast<float>(h / stepBefore_) : 0;
    constants.slowRotation = RodTuning<float>::slowRotation(h, s.material.airDrag);
    constants.twistInertia = RodTuning<float>::twistInertia(h);
    constants.guessTrend = RodTuning<float>::guessTrend(s.material.airDrag);
    constants.bendStiffness = static_cast<float>(s.material.bend);
    constants.twistStiffness = static_cast<float>(s.material.twist);
    constants.damping = static_cast<float>(s.material.relaxation / h);
    constants.targetStiffness =
        static_cast<float>(s.globalStiffness * 3600 / std::max(1 - s.globalStiffness, 1e-3));
    constants.targetRange = static_cast<float>(s.globalRange);
    constants.passTolerance = static_cast<float>(s.passTolerance);
    constants.vspCoefficient = static_cast<float>(s.transport);
    constants.vspThreshold = static_cast<float>(s.transportThreshold);
  }

  static constexpr uint32_t kMaxSubSteps = 3;

  Gpu& gpu_;
  std::vector<RestStrand> rests_;
  Packed packed_;
  PassList list_;
  double stepBefore_ = 0, frameBefore_ = 0;
  StepCoefficients coefficients_, coefficientsBefore_;  // of the last steps; he = 0 without
  test::ExactPass pass_;
  float furtherRange_ = 0;

 public:
  ExactConstants& constants = pass_.constants;
};

/// Something that strands go through.
struct Case {
  std::string name;
  ExactKey key;
  std::vector<int> counts;
  int frames;
  /// Largest distance to the double reference over the strand's length, in the frames that are
  /// compared. It is float's own: the float reference has the same one.
  double tolerance;
  int toleranceFrames;
  RodSettings settings = {};
  std::vector<Collider> colliders = {};
  bool varyingSteps = false;
  bool teleport = false;

  double stepAt(int frame) const {
    if (!varyingSteps) return 1.0 / 60;
    // Ratios inside and outside the range of BDF2. Few of them, because lavapipe compiles a kernel
    // anew for every value of a constant that it branches on.
    constexpr std::array<double, 6> kRates = {240, 15, 30, 60, 45, 90};
    return 1 / kRates[static_cast<size_t>(frame) % kRates.size()];
  }
  RootPose poseAt(double time) const {
    RootPose pose = shakenHead(time);
    if (teleport && time > 0.49) pose.translation += Vector3d(1, 0, 0);
    return pose;
  }
};

/// Settings of its own for every axis that is on.
Case makeCase(std::string name, const ExactKey& key, std::vector<int> counts, int frames,
              double tolerance, int toleranceFrames) {
  Case c{std::move(name), key, std::move(counts), frames, tolerance, toleranceFrames};
  c.settings.material = {.bend = 1e-3, .twist = 0.5e-3, .airDrag = 3};
  c.settings.wind = {1, 0, -0.5};
  if (key.globalShape) {
    c.settings.globalStiffness = 0.02;
    c.settings.globalRange = 0.5;
  }
  if (key.contacts) {
    c.settings.material.relaxation = 1e-3;
    c.colliders = {{{0.05f, -0.1f, 0, 0.08f},
                    {0.05f, -0.1f, 0, 0.08f},
                    {0.05f, -0.1f, 0, 0.3f},
                    {0.05f, -0.1f, 0, 0},
                    {}},
                   {{0.1f, 0.1f, 0.1f, 0.04f},
                    {0.2f, 0, 0, 0.06f},
                    {0.1f, 0.1f, 0.1f, 0},
                    {0.2f, 0.001f, 0, 0},
                    {}}};
  }
  if (key.velocityShockPropagation) {
    c.settings.transport = 0.4;
    c.settings.transportThreshold = 200;
  }
  return c;
}

RodCollider toReference(const Collider& c) {
  return {.head = toVector(c.head),
          .tail = toVector(c.tail),
          .headBefore = toVector(c.headBefore),
          .tailBefore = toVector(c.tailBefore),
          .headRadius = c.head.w,
          .tailRadius = c.tail.w,
          .friction = c.headBefore.w};
}

/// Positions of the two references, [frame][strand][vertex] in one row a frame.
struct Expected {
  std::vector<RestStrand> rests;
  std::vector<std::vector<Vector3<float>>> floats;
  std::vector<std::vector<Vector3d>> doubles;
  long sweptPasses = 0, matrixPasses = 0;  ///< of all strands
};

/// Computed once for all APIs.
const Expected& expectedOf(const Case& c) {
  static std::map<std::string, Expected> all;
  const auto [found, made] = all.try_emplace(c.name);
  Expected& expected = found->second;
  if (!made) return expected;
  expected.rests = makeStrands(c.counts);
  std::vector<ExactRod<float>> floats;
  std::vector<ExactRod<double>> doubles;
  double time = 0;
  RodSettings settings = c.settings;
  std::vector<RodCollider> colliders;
  for (const Collider& from : c.colliders) colliders.push_back(toReference(from));
  settings.colliders = colliders;
  for (int frame = 0; frame < c.frames; ++frame) {
    const double dt = c.stepAt(frame);
    time += dt;
    const RootPose pose = c.poseAt(time);
    auto& f = expected.floats.emplace_back();
    auto& d = expected.doubles.emplace_back();
    for (size_t s = 0; s < expected.rests.size(); ++s) {
      if (frame == 0) {
        floats.emplace_back(expected.rests[s], pose);
        doubles.emplace_back(expected.rests[s], pose);
      }
      floats[s].step(dt, pose, settings);
      if (frame < c.toleranceFrames) doubles[s].step(dt, pose, settings);
      for (int v = 0; v < floats[s].size(); ++v) {
        f.push_back(floats[s].position(v));
        d.push_back(doubles[s].position(v));
      }
    }
  }
  for (const ExactRod<float>& rod : floats) {
    expected.sweptPasses += rod.statistics().sweptPasses;
    expected.matrixPasses += rod.statistics().contactPasses - rod.statistics().sweptPasses;
  }
  return expected;
}

class SimulateExact : public GpuTest {
 protected:
  /// Whether the device's square root and division are exact, which no API promises: the software
  /// drivers' are the CPU's.
  bool exactDevice() { return gpu().device()->info().software; }

  void compare(const Case& c) {
    SCOPED_TRACE(c.name);
    const Expected& expected = expectedOf(c);
    RodRun run(gpu(), expected.rests, c.key, c.settings.holdTip);
    if (!c.colliders.empty()) run.setColliders(c.colliders);
    double time = 0, worst = 0, stretch = 0;
    size_t different = 0;
    int firstDifferent = -1;
    for (int frame = 0; frame < c.frames; ++frame) {
      const double dt = c.stepAt(frame);
      const RootPose to = c.poseAt(time + dt);
      // A strand that starts has come from where it is.
      const RootPose from = frame == 0 ? to : c.poseAt(time);
      time += dt;
      run.step(dt, from, to, c.settings);
      const std::vector<Float4> positions = run.positions();
      const auto row = static_cast<size_t>(frame);
      size_t at = 0;
      for (const RestStrand& rest : expected.rests) {
        for (size_t v = 0; v < rest.positions.size(); ++v, ++at) {
          const Vector3<float>& f = expected.floats[row][at];
          const Float4 wanted = {f.x, f.y, f.z, v < 2 ? 0.0f : 1.0f};
          ASSERT_TRUE(isFinite(positions[at])) << "frame " << frame;
          if (!sameBits(positions[at], wanted)) {
            ++different;
            if (firstDifferent < 0) firstDifferent = frame;
          }
          const Vector3d p = toVector(positions[at]);
          if (frame < c.toleranceFrames)
            keepLargest(worst, length(p - expected.doubles[row][at]) / rest.length());
          if (v > 0) {
            const double edge = length(p - toVector(positions[at - 1]));
            const double rounding = 2e-7 * (std::abs(p.x) + std::abs(p.y) + std::abs(p.z));
            keepLargest(stretch,
                        (std::abs(edge - rest.lengths[v - 1]) - rounding) / rest.lengths[v - 1]);
          }
        }
      }
    }
    if (exactDevice()) {
      EXPECT_EQ(different, 0u) << "of the float reference, from frame " << firstDifferent;
    }
    EXPECT_LT(worst, c.tolerance) << "to the double reference";
    EXPECT_LT(stretch, 1e-5);
    for (const Float4& t : run.tangents()) {
      ASSERT_NEAR(length(toVector(t)), 1, 1e-6);
      ASSERT_EQ(t.w, 0);
    }
    run.checkGuards();
  }
};

const std::vector<int> kAllSizes = {2,   256, 3,  4,  5,  8,  16, 31, 32, 33, 64, 100, 128,
                                    255, 7,   9,  10, 11, 12, 13, 14, 15, 17, 18, 19,  20,
                                    21,  22,  23, 24, 25, 26, 27, 28, 29, 30, 34, 35};
const std::vector<int> kFewSizes = {2, 40, 3, 4, 5, 8, 16, 24, 32, 33, 9, 64};

// K2
TEST_P(SimulateExact, HasTheBitsOfTheFloatReference) {
  compare(makeCase("strands of all sizes", {}, kAllSizes, 60, 1e-3, 60));
}

TEST_P(SimulateExact, HasTheBitsOfTheFloatReferenceInStepsOfEveryKind) {
  const ExactKey shock = {.velocityShockPropagation = true};
  Case steps = makeCase("steps of 1/240 to 1/15 s", {}, kFewSizes, 60, 5e-4, 60);
  steps.varyingSteps = true;
  Case subSteps = makeCase("3 sub-steps", shock, kFewSizes, 60, 5e-3, 60);
  subSteps.settings.subSteps = 3;
  Case onePass = makeCase("one pass", {}, kFewSizes, 60, 5e-3, 20);
  onePass.settings.passTolerance = 5;
  Case heldTip = makeCase("held tip", {.globalShape = true}, {3, 5, 16, 40}, 60, 5e-3, 30);
  heldTip.settings.holdTip = true;
  Case teleport = makeCase("teleport", shock, kFewSizes, 60, 5e-4, 60);
  teleport.teleport = true;
  for (const Case& c : {steps, subSteps, onePass, heldTip, teleport}) compare(c);
}

// Each of the permutations on one API, since drivers take longer to compile one than to run it;
// those of the other tests and all features at once on every one. Contacts: see below.
TEST_P(SimulateExact, HasTheBitsOfTheFloatReferenceInEveryPermutation) {
  const std::array<std::vector<uint32_t>, 3> masks = {{{2, 4, 7}, {1, 3, 5, 7}, {6, 7}}};
  for (const uint32_t mask : masks[static_cast<size_t>(GetParam())]) {
    const ExactKey key = {.globalShape = (mask & 1) != 0,
                          .velocityShockPropagation = (mask & 4) != 0};
    Case c = makeCase("permutation " + std::to_string(mask), key, kFewSizes, 60, 1e-2, 60);
    if ((mask & 2) != 0) c.settings.material.relaxation = 1e-3;
    compare(c);
  }
}

/// The permutations with contacts.
ExactKey contactKey(bool globalShape) {
  return {.globalShape = globalShape, .contacts = true, .velocityShockPropagation = true};
}
/// A sphere around which nothing is within a metre.
Collider farSphere() {
  return {{0, -3, 0, 0.5f}, {0, -3, 0, 0.5f}, {0, -3, 0, 0.3f}, {0, -3, 0, 0}, {}};
}

// K2: with contacts, strands that have no record have the bits that they have without.
TEST_P(SimulateExact, HasTheSameBitsWithContactsWhereNothingIsWithinReach) {
  for (const bool globalShape : {false, true}) {
    SCOPED_TRACE(globalShape);
    ExactKey key = contactKey(globalShape);
    ExactKey without = key;
    without.contacts = false;
    key.blocks = globalShape;
    Case c = makeCase("", key, {}, 0, 0, 0);
    c.settings.subSteps = 2;
    const std::vector<RestStrand> rests = makeStrands(kAllSizes);
    RodRun run(gpu(), rests, key), plain(gpu(), rests, without);
    run.setColliders({farSphere()});
    for (int frame = 0; frame < 30; ++frame) {
      for (RodRun* r : {&run, &plain}) r->stepHead(frame, c.settings);
      ASSERT_EQ(run.counters().records, 0u);
    }
    EXPECT_TRUE(sameBits(run.positions(), plain.positions()));
    EXPECT_TRUE(sameBits(run.state(), plain.state()));
    run.checkGuards();
  }
}

TEST_P(SimulateExact, HasTheBitsOfTheFloatReferenceInContact) {
  for (const int subSteps : {1, 3}) {
    Case c = makeCase("contacts, sub-steps " + std::to_string(subSteps), contactKey(false),
                      kFewSizes, 60, 1, 0);
    c.settings.subSteps = subSteps;
    // With 1 sub-step drag makes the second round rare, with 3 it does not.
    c.settings.passTolerance =
        RodTuning<float>::passTolerance(1.0 / 60 / subSteps, c.settings.material.airDrag, 0.5);
    for (const bool blocks : {false, true}) {
      c.key.blocks = blocks;
      compare(c);
    }
    // With the matrix, and with more contacts than it has.
    EXPECT_GT(expectedOf(c).sweptPasses, 10);
    EXPECT_GT(expectedOf(c).matrixPasses, 100);
  }
}

// Several lanes a strand have the bits of one, with every permutation, and strands that are not
// whole blocks.
TEST_P(SimulateExact, HasTheSameBitsInBlocks) {
  for (const bool globalShape : {false, true}) {
    SCOPED_TRACE(globalShape);
    ExactKey key = contactKey(globalShape);
    Case c = makeCase("", key, {}, 0, 0, 0);
    c.settings.subSteps = 2;
    const std::vector<RestStrand> rests = makeStrands(kAllSizes);
    RodRun one(gpu(), rests, key);
    key.blocks = true;
    RodRun several(gpu(), rests, key);
    for (RodRun* r : {&one, &several}) r->setColliders(c.colliders);
    uint32_t again = 0;
    for (int frame = 0; frame < 20; ++frame) {
      for (RodRun* r : {&one, &several}) r->stepHead(frame, c.settings);
      EXPECT_GT(several.counters().records, 0u);
      again += several.counters().strandsSolvedAgain;
      ASSERT_TRUE(sameBits(one.positions(), several.positions())) << frame;
    }
    EXPECT_GT(again, 0u);
    EXPECT_TRUE(sameBits(one.state(), several.state()));
    several.checkGuards();
  }
}

/// On the first API: the others have its bits, and this takes seconds.
class SimulateExactOnce : public SimulateExact {};
INSTANTIATE_TEST_SUITE_P(Api, SimulateExactOnce, testing::Values(test::kFirstApi), apiTestName);

/// Strands with records of a plane that is meters below all of them move as if they had none.
TEST_P(SimulateExactOnce, PlanesThatAreFarPushNothing) {
  const ExactKey key = contactKey(false);
  const std::vector<RestStrand> rests = makeStrands(kFewSizes);
  const Case c = makeCase("", key, {}, 0, 0, 0);
  RodRun run(gpu(), rests, key), plain(gpu(), rests, key);
  for (RodRun* r : {&run, &plain}) r->setColliders({farSphere()});
  run.setFurtherRange(10);
  const RootPose pose = shakenHead(0.7);
  double worst = 0;
  for (int frame = 0; frame < 600; ++frame) {
    for (RodRun* r : {&run, &plain}) r->step(1.0 / 60, pose, pose, c.settings);
    if (frame != 0 && frame != 5 && frame != 599) continue;
    EXPECT_GT(run.counters().records, 100u) << "nothing has a record";
    ASSERT_EQ(plain.counters().records, 0u);
    const std::vector<Float4> a = run.positions(), b = plain.positions();
    worst = 0;
    for (size_t v = 0; v < a.size(); ++v)
      keepLargest(worst, length(toVector(a[v]) - toVector(b[v])));
    std::printf("[ FIGURE ] frame %d: %g m\n", frame, worst);
    // The iterations leave a small share of the penalties.
    if (frame == 0) {
      EXPECT_LT(worst, 5e-5);
    }
  }
  // At rest it does not count.
  EXPECT_LT(worst, 1e-5);
}

TEST_P(SimulateExact, TakesAnyNumberOfStrands) {
  for (const int strands : {1, 31, 33, 65}) {
    std::vector<int> counts;
    for (int s = 0; s < strands; ++s) counts.push_back(2 + (s * 7) % 23);
    compare(makeCase(std::to_string(strands) + " strands", {}, counts, 4, 1e-5, 4));
  }
}

TEST_P(SimulateExact, AddsItsOriginToWhatIsDrawnOnly) {
  const std::vector<RestStrand> rests = makeStrands({2, 9, 20});
  const Case c = makeCase("", {}, {}, 0, 0, 0);
  RodRun near(gpu(), rests, {}), far(gpu(), rests, {});
  far.constants.origin = {1024, -512, 0.5f, 0};
  for (int frame = 0; frame < 10; ++frame) {
    for (RodRun* run : {&near, &far}) run->stepHead(frame, c.settings);
  }
  const std::vector<Float4> a = near.positions(), b = far.positions();
  for (size_t v = 0; v < a.size(); ++v)
    ASSERT_TRUE(sameBits(b[v], {a[v].x + 1024, a[v].y - 512, a[v].z + 0.5f, a[v].w}));
  EXPECT_TRUE(sameBits(near.state(), far.state()));
}

TEST_P(SimulateExact, ResetForgetsWhatWas) {
  const std::vector<RestStrand> rests = makeStrands(kFewSizes);
  const ExactKey key = contactKey(true);
  const Case c = makeCase("", key, {}, 0, 0, 0);
  RodRun used(gpu(), rests, key), fresh(gpu(), rests, key);
  for (RodRun* run : {&used, &fresh}) run->setColliders(c.colliders);
  for (int frame = 0; frame < 20; ++frame)
    used.step(1.0 / 60, shakenHead(1 + frame / 60.0), shakenHead(1 + (frame + 1) / 60.0),
              c.settings);
  used.reset();
  for (int frame = 0; frame < 5; ++frame) {
    const RootPose to = shakenHead((frame + 1) / 60.0),
                   from = frame ? shakenHead(frame / 60.0) : to;
    for (RodRun* run : {&used, &fresh}) run->step(1.0 / 60, from, to, c.settings);
    ASSERT_TRUE(sameBits(used.positions(), fresh.positions())) << frame;
  }
}

TEST_P(SimulateExact, LosesWhatIsNotANumberInAFewSteps) {
  const std::vector<RestStrand> rests = makeStrands({2, 3, 8, 16, 33, 20, 20, 20, 20});
  for (const bool all : {false, true}) {
    SCOPED_TRACE(all);
    const ExactKey key = all ? contactKey(true) : ExactKey{};
    const Case c = makeCase("", key, {}, 0, 0, 0);
    RodRun run(gpu(), rests, key);
    if (all) run.setColliders(c.colliders);
    for (int frame = 0; frame < 5; ++frame) run.stepHead(frame, c.settings);
    std::vector<Float4> state = run.state();
    const std::vector<Float4> healthy = state;
    for (const ExactStrand& record : run.records()) {
      // The longest strand stays as it is, and must not learn of the others.
      if (record.count == 33) continue;
      for (uint32_t v = 0; v < record.count; ++v) {
        for (uint32_t set = 0; set < 8; ++set) {
          Float4& site = state[set * run.stride() + record.state + kTile * v];
          const bool frame = set >= 4;
          // The root's vertices have no ways of their own, the tip no edge.
          if (frame ? v + 1 == record.count : v < 2) continue;
          // One strand loses its ways, one its frames, others everything at one vertex.
          const bool lost = record.root == 5   ? !frame
                            : record.root == 6 ? frame
                                               : v == record.count / 2;
          if (lost) site = {kNan, v % 2 == 0 ? kNan : INFINITY, 1e38f, kNan};
        }
      }
      // And one what the state has of the strand as a whole.
      for (uint32_t element = 0; record.root == 7 && element < 20; ++element) {
        const auto index = static_cast<uint32_t>(&record - run.records().data());
        state[8 * run.stride() + element * rests.size() + index] = {kNan, 1e38f, kNan, kNan};
      }
    }
    run.setState(state);
    RodRun other(gpu(), rests, key);
    if (all) other.setColliders(c.colliders);
    for (int frame = 0; frame < 5; ++frame) other.stepHead(frame, c.settings);
    for (int frame = 5; frame < 13; ++frame) {
      run.stepHead(frame, c.settings);
      other.stepHead(frame, c.settings);
    }
    const std::vector<Float4> positions = run.positions(), undisturbed = other.positions();
    for (const Float4& s : run.state()) ASSERT_TRUE(isFinite(s));
    for (const Float4& t : run.tangents()) ASSERT_NEAR(length(toVector(t)), 1, 1e-5);
    for (const ExactStrand& record : run.records()) {
      for (uint32_t v = 0; v < record.count; ++v) {
        const size_t at = record.target + v;
        ASSERT_TRUE(isFinite(positions[at]));
        if (record.count == 33) {
          ASSERT_TRUE(sameBits(positions[at], undisturbed[at]));
        }
        if (v == 0) continue;
        const double rest = rests[record.root].lengths[v - 1];
        ASSERT_NEAR(length(toVector(positions[at]) - toVector(positions[at - 1])), rest, 1e-6);
      }
    }
    run.checkGuards();
  }
}

TEST_P(SimulateExact, StandsRootTransformsThatNobodyWrote) {
  const std::vector<RestStrand> rests = makeStrands({2, 8, 12});
  const ExactKey key = contactKey(true);
  Case c = makeCase("", key, {}, 0, 0, 0);
  c.settings.gravity = c.settings.wind = Vector3d();
  RodRun run(gpu(), rests, key);
  // Nothing at all; a pose that is not a number in this frame alone; in both.
  const Float4 identity = {0, 0, 0, 1}, site = {0.5f, 0, 0, 0};
  run.setRoots({{0, 0, 0, 0},
                {0, 0, 0, 0},
                {kNan, 0, 0, 1},
                site,
                identity,
                {kNan, 0, 0, 0},
                {0, 0, 0, 0},
                {0, 0, 0, 0},
                identity,
                site,
                {kNan, 0, 0, 1},
                site});
  run.stepWithRoots(1.0 / 60, c.settings);
  const std::vector<Float4> positions = run.positions();
  size_t at = 0;
  for (const RestStrand& rest : rests) {
    const Vector3d root = &rest == &rests[1] ? Vector3d(0.5, 0, 0) : Vector3d();
    for (const Vector3d& p : rest.positions)
      EXPECT_LT(length(toVector(positions[at++]) - (p - rest.positions[0] + root)), 1e-5);
  }
}

TEST_P(SimulateExact, LeavesOutStrandsWhoseRecordsDoNotFit) {
  const std::vector<RestStrand> rests = makeStrands({5, 5, 5, 5, 5, 5, 5, 5, 5});
  const Case c = makeCase("", {}, {}, 0, 0, 0);
  RodRun run(gpu(), rests, {}), whole(gpu(), rests, {});
  std::vector<ExactStrand> records = run.records();
  const uint32_t huge = 0xffffffffu;
  records[0].count = 1;
  records[1].count = 257;
  records[2].count = huge;
  records[3].state = run.stride();
  records[4].state = run.stride() - 4 * kTile;
  records[5].target = run.constants.outputCount - 4;
  records[6].target = huge;
  records[7].root = run.constants.rootCount;
  run.setRecords(records);
  const std::vector<Float4> before = run.state();
  for (RodRun* r : {&run, &whole}) r->step(1.0 / 60, shakenHead(0.5), shakenHead(0.5), c.settings);
  const std::vector<Float4> positions = run.positions(), expected = whole.positions();
  for (size_t v = 0; v < positions.size(); ++v) {
    const bool fits = v / 5 == 8;
    EXPECT_TRUE(sameBits(positions[v], fits ? expected[v] : Float4{})) << v;
  }
  const std::vector<Float4> after = run.state();
  for (size_t i = 0; i < after.size(); ++i) {
    // The ninth strand's places in the sets, and behind them.
    const size_t sets = size_t{8} * run.stride();
    const size_t strand = i < sets ? i % kTile : (i - sets) % rests.size();
    if (strand != 8) {
      ASSERT_TRUE(sameBits(after[i], before[i])) << i;
    }
  }
  run.checkGuards();
}

/// Everything that the kernel wrote after 30 frames of two sub-steps with all features.
std::vector<Float4> simulated(Gpu& gpu) {
  const ExactKey key = contactKey(true);
  Case c = makeCase("", key, {}, 0, 0, 0);
  c.settings.subSteps = 2;
  RodRun run(gpu, makeStrands(kFewSizes), key);
  run.setColliders(c.colliders);
  for (int frame = 0; frame < 30; ++frame) run.stepHead(frame, c.settings);
  EXPECT_GT(run.counters().records, 0u);
  std::vector<Float4> all = run.state();
  for (const Float4& p : run.positions()) all.push_back(p);
  for (const Float4& t : run.tangents()) all.push_back(t);
  return all;
}

TEST_P(SimulateExact, HasTheSameBitsOfContactsTwice) {
  EXPECT_TRUE(sameBits(simulated(gpu()), simulated(gpu())));
}

INSTANTIATE_TEST_SUITE_P(Api, SimulateExact, testing::ValuesIn(kApis), apiTestName);

TEST(SimulateExactAgreement, HasTheSameBitsOnVulkanAndGl) {
  std::vector<Float4> expected;
  for (Gpu* gpu : test::gpusOfOneDriver()) {
    const std::vector<Float4> all = simulated(*gpu);
    if (expected.empty()) expected = all;
    ASSERT_EQ(all.size(), expected.size());
    size_t different = 0;
    for (size_t i = 0; i < all.size(); ++i) different += sameBits(all[i], expected[i]) ? 0 : 1;
    EXPECT_EQ(different, 0u) << "of " << all.size() << " on " << gpu->device()->info().name;
  }
  if (expected.empty()) PELAGE_SKIP_WITHOUT_DEVICE() << "no device";
}

}  // namespace
}  // namespace pelage::rod
