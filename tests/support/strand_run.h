// Runs the simulation kernels on buffers of a test's own.
#pragma once

#include <gtest/gtest.h>

#include <Eigen/Core>
#include <cmath>
#include <cstdint>
#include <limits>
#include <numbers>
#include <vector>

#include "pelage/gpu_structs.h"
#include "pelage/hair_asset.h"
#include "pelage/kernels.h"
#include "reference/classic_reference.h"
#include "support/contact_pass.h"
#include "support/gpu_fixture.h"

namespace pelage::test {

using Eigen::Vector3d;

/// Uniform numbers that are the same on every machine.
class Random {
 public:
  explicit Random(uint64_t seed) : state_(seed * 2 + 1) {}
  double unit() {
    state_ = state_ * 6364136223846793005u + 1442695040888963407u;
    return static_cast<double>(state_ >> 11) * 0x1p-53;
  }
  double between(double low, double high) { return low + (high - low) * unit(); }
  Vector3d vector(double size) {
    return {between(-size, size), between(-size, size), between(-size, size)};
  }
  Eigen::Quaterniond rotation() {
    return Eigen::Quaterniond(between(-1, 1), between(-1, 1), between(-1, 1), between(-1, 1))
        .normalized();
  }

 private:
  uint64_t state_;
};

inline Vector3d toVector(const Float4& v) {
  return {static_cast<double>(v.x), static_cast<double>(v.y), static_cast<double>(v.z)};
}
inline Float4 toFloat4(const Vector3d& v, double w = 0) {
  return {static_cast<float>(v.x()), static_cast<float>(v.y()), static_cast<float>(v.z()),
          static_cast<float>(w)};
}
inline RootTransform toRoot(const reference::Pose& pose) {
  const Eigen::Vector4f q = pose.rotation.coeffs().cast<float>();
  return {{q.x(), q.y(), q.z(), q.w()}, toFloat4(pose.position)};
}
inline reference::Pose toPose(const RootTransform& root) {
  return {Eigen::Quaterniond(root.rotation.w, root.rotation.x, root.rotation.y, root.rotation.z),
          toVector(root.position)};
}
inline bool isFinite(const Float4& v) {
  return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z) && std::isfinite(v.w);
}

/// Strands of about 0.3 m that start within 0.2 m of the origin and bend and curl differently.
inline HairAsset wavyAsset(uint32_t strands, uint32_t vertices, uint64_t seed = 1,
                           const std::vector<int>& held = {}) {
  HairAsset asset;
  asset.strandCount = strands;
  asset.verticesPerStrand = vertices;
  Random random(seed);
  for (uint32_t s = 0; s < strands; ++s) {
    const Vector3d root = random.vector(0.2);
    const Eigen::Quaterniond turn = random.rotation();
    const double curl = random.between(0.005, 0.04), rotations = random.between(0.5, 2.5);
    for (uint32_t v = 0; v < vertices; ++v) {
      const double t = static_cast<double>(v) / (vertices - 1);
      const double angle = 2 * std::numbers::pi * rotations * t;
      const Vector3d p =
          root + turn * Vector3d(curl * t * std::cos(angle), -0.3 * t, curl * t * std::sin(angle));
      asset.positions.push_back(toFloat4(p, v < 2 ? 0 : 1));
    }
    for (int v : held) asset.positions[s * vertices + static_cast<uint32_t>(v)].w = 0;
  }
  expectOk(asset.process());
  return asset;
}

inline std::vector<Vector3d> bindOf(const HairAsset& asset, uint32_t strand) {
  std::vector<Vector3d> bind;
  for (uint32_t v = 0; v < asset.verticesPerStrand; ++v)
    bind.push_back(toVector(asset.positions[strand * asset.verticesPerStrand + v]));
  return bind;
}

inline reference::Pose bindPose(const HairAsset& asset, uint32_t strand) {
  return {Eigen::Quaterniond::Identity(),
          toVector(asset.positions[size_t{strand} * asset.verticesPerStrand])};
}

inline std::vector<reference::Pose> bindPoses(const HairAsset& asset) {
  std::vector<reference::Pose> poses;
  for (uint32_t s = 0; s < asset.strandCount; ++s) poses.push_back(bindPose(asset, s));
  return poses;
}

/// The terms of a step; the constants of the others do not matter.
struct StrandTerms {
  bool wind = false;
  bool globalShape = false;
  bool localShape = false;
  bool velocityShockPropagation = false;
  bool contacts = false;
};

/// The constants with those terms alone.
inline SimulationConstants withTerms(SimulationConstants constants, const StrandTerms& terms) {
  if (!terms.wind) constants.wind.w = 0;
  if (!terms.globalShape) constants.globalStiffness = 0;
  if (!terms.localShape) constants.localIterations = 0;
  if (!terms.velocityShockPropagation) {
    constants.vspCoefficient = 0;
    constants.vspThreshold = std::numeric_limits<float>::infinity();
  }
  return constants;
}

/// The buffers of one groom on a device.
class StrandRun {
 public:
  StrandRun(Gpu& gpu, const HairAsset& asset, std::vector<FollowHairRecord> followHairRecords = {},
            std::vector<Float4> bones = {{1, 0, 0, 0}, {0, 1, 0, 0}, {0, 0, 1, 0}},
            std::vector<RootBinding> rootBindings = {})
      : gpu_(gpu),
        guides_(asset.strandCount),
        follows_(static_cast<uint32_t>(followHairRecords.size())),
        vertices_(asset.verticesPerStrand),
        positions_(gpu, "positions", std::vector<Float4>((guides_ + follows_) * vertices_)),
        tangents_(gpu, "tangents", std::vector<Float4>((guides_ + follows_) * vertices_)),
        rest_(gpu, "rest", packed(asset)),
        state_(gpu, "state", std::vector<Float4>(firstRoot() + size_t{4} * guides_)),
        bones_(gpu, "boneTransforms", bones),
        bindings_(
            gpu, "rootBindings",
            rootBindings.empty() ? std::vector<RootBinding>(guides_, oneBone()) : rootBindings),
        followHairRecords_(gpu, "followHairRecords", followHairRecords),
        contacts_(gpu, contactStrands(guides_, vertices_), vertices_,
                  uint64_t{guides_} * vertices_) {
    constants.guideCount = guides_;
    constants.followCount = follows_;
    constants.vertexCount = vertices_;
    constants.boneCount = static_cast<uint32_t>(bones.size()) / 3;
    constants.timeStep = 1.0f / 60;
    constants.timeStepRatio = 1;
    constants.rootBegin = 0;
    constants.rootEnd = 1;
    constants.dampingKeep = 1;
    constants.gravityStep = 1.0f / 3600;
    constants.forceShare = 1;
    constants.vspThreshold = std::numeric_limits<float>::infinity();
    constants.maxSpeed = 1e6f;
    constants.localIterations = 2;
    constants.lengthIterations = 4;
    constants.tipSeparation = 1;
    expectOk(gpu.device()->update(gpu.resources));
  }

  // Roots lie in g_state, from here on.
  size_t firstRoot() const { return (size_t{4} * guides_ * vertices_ + 15) / 16 * 16; }
  BufferRange rootRange() const {
    return {state_.id(), size_t{2} * guides_ * sizeof(RootTransform), firstRoot() * sizeof(Float4)};
  }

  static RootBinding oneBone() {
    RootBinding binding = {};
    binding.weights.x = 1;
    return binding;
  }

  SimulationConstants constants = {};

  uint32_t vertexCount() const { return vertices_; }
  void setRoots(const std::vector<reference::Pose>& now, const std::vector<reference::Pose>& last) {
    std::vector<RootTransform> roots;
    for (const auto& pose : now) roots.push_back(toRoot(pose));
    for (const auto& pose : last) roots.push_back(toRoot(pose));
    setRootTransforms(roots);
  }
  /// Colliders of the contacts permutation.
  void setColliders(const std::vector<Collider>& colliders) {
    contacts_.setCapsules(list_, colliders);
  }
  /// The same of SDFs; keys and surface stay as they are after the first time.
  void setSdfs(const std::vector<Sdf>& sdfs, const std::vector<uint32_t>& keys,
               const std::vector<Uint4>& surface) {
    contacts_.setSdfs(list_, sdfs, keys, surface);
  }
  void setState(const std::vector<Float4>& state) {
    addUpload(list_, state_.id(), std::as_bytes(std::span(state)));
  }
  void setBones(const std::vector<Float4>& bones) { bones_.upload(list_, bones); }
  void setRootTransforms(const std::vector<RootTransform>& roots) {
    addUpload(list_, state_.id(), std::as_bytes(std::span(roots)), firstRoot() * sizeof(Float4));
  }

  void skinRoots(bool dualQuaternions = false) {
    const uint32_t flags = constants.flags;
    if (dualQuaternions) constants.flags |= 4;
    pass(skinRootsVariant(), guides_);
    constants.flags = flags;
  }
  void simulate(const StrandTerms& terms) {
    if (terms.contacts) findContacts();
    const SimulationConstants all = constants;
    constants = withTerms(all, terms);
    pass(simulateClassicVariant({.contacts = terms.contacts}), guides_);
    constants = all;
  }
  void updateFollowHairs() { pass(updateFollowHairsVariant({}), (follows_ + 3) / 4, vertices_); }
  /// Sets roots to `now` for both frames and takes the goals.
  void reset(const std::vector<reference::Pose>& now) {
    setRoots(now, now);
    constants.flags = 1;
    simulate({});
    contacts_.forget();
    constants.flags = 0;
    run();
  }
  /// A reset with the follow hairs.
  void resetWithFollowHairs(const std::vector<reference::Pose>& now) {
    reset(now);
    updateFollowHairs();
    run();
  }
  /// Runs what has been recorded.
  void run() { gpu_.execute(list_); }

  std::vector<Float4> positions() const { return positions_.read(); }
  std::vector<Float4> tangents() const { return tangents_.read(); }
  std::vector<Float4> state() const {
    std::vector<Float4> all = state_.read();
    all.resize(size_t{3} * guides_ * vertices_);  // without the scratch and the roots
    return all;
  }
  std::vector<RootTransform> roots() const {
    const std::vector<Float4> all = state_.read();
    std::vector<RootTransform> roots(size_t{2} * guides_);
    for (size_t i = 0; i < roots.size(); ++i)
      roots[i] = {all[firstRoot() + 2 * i], all[firstRoot() + 2 * i + 1]};
    return roots;
  }
  /// [vertex][2] of the last search for contacts.
  std::vector<ContactRecord> contactRecords() const {
    std::vector<ContactRecord> records(size_t{2} * guides_ * vertices_);
    Result<std::vector<std::byte>> bytes = gpu_.device()->read(contacts_.contacts().records());
    if (bytes)
      std::memcpy(records.data(), bytes->data(), records.size() * sizeof(ContactRecord));
    else
      ADD_FAILURE() << bytes.error().message;
    return records;
  }
  void setContactRecords(const std::vector<ContactRecord>& records) {
    addUpload(list_, contacts_.contacts().records(), std::as_bytes(std::span(records)));
  }
  /// Fails when a pattern behind a buffer was written to.
  void checkGuards() const {
    (void)positions_.read();
    (void)tangents_.read();
    (void)rest_.read();
    contacts_.checkGuards();
    (void)state_.read();
    (void)bones_.read();
    (void)bindings_.read();
    (void)followHairRecords_.read();
  }
  static StrandTerms terms(bool wind = false, bool globalShape = false, bool localShape = false,
                           bool velocityShockPropagation = false, bool contacts = false) {
    return {.wind = wind,
            .globalShape = globalShape,
            .localShape = localShape,
            .velocityShockPropagation = velocityShockPropagation,
            .contacts = contacts};
  }

 private:
  static std::vector<Float4> packed(const HairAsset& asset) {
    Result<std::vector<Float4>> rest = packRest(asset);
    if (rest) return std::move(*rest);
    ADD_FAILURE() << rest.error().message;
    return {};
  }
  static detail::ContactStrands contactStrands(uint32_t guides, uint32_t vertices) {
    detail::ContactStrands strands;
    for (uint32_t guide = 0; guide < guides; ++guide)
      strands.strands.push_back(
          {.target = guide * vertices, .count = vertices, .root = guide, .state = 0});
    return strands;
  }
  void findContacts() {
    const Float4 origin = constants.origin;
    contacts_.begin(list_);
    contacts_.find(list_,
                   {.positions = positions_.id(),
                    .roots = rootRange(),
                    .rootCount = guides_,
                    .strands = guides_,
                    .origin = {.metres = {double{origin.x}, double{origin.y}, double{origin.z}}}},
                   {.begin = constants.rootBegin,
                    .end = constants.rootEnd,
                    .length = constants.timeStep,
                    .gravity = {constants.gravity.x, constants.gravity.y, constants.gravity.z}});
    const detail::ContactLayout& contacts = contacts_.contacts().layout();
    constants.contactMasks = contacts.masks();
    constants.contactMaskWords = contacts.maskWords;
  }
  void pass(const KernelVariant& variant, uint32_t threadsX, uint32_t threadsY = 1) {
    PassBuilder builder(list_);
    builder.dispatch(variant, threadsX, threadsY);
    positions_.bindTo(builder, "g_positions");
    tangents_.bindTo(builder, "g_tangents");
    rest_.bindTo(builder, "g_rest");
    state_.bindTo(builder, "g_state");
    const BufferRange roots = rootRange();
    builder.bind("g_rootTransforms", roots.buffer, roots.size, roots.offset);
    bones_.bindTo(builder, "g_boneTransforms");
    bindings_.bindTo(builder, "g_rootBindings");
    followHairRecords_.bindTo(builder, "g_followHairRecords");
    contacts_.bindTo(builder);
    builder.constants("SimulationConstants", constants);
    expectOk(builder.finish());
  }

  Gpu& gpu_;
  uint32_t guides_, follows_, vertices_;
  PassList list_;
  GuardedBuffer<Float4> positions_, tangents_, rest_;
  GuardedBuffer<Float4> state_;
  GuardedBuffer<Float4> bones_;
  GuardedBuffer<RootBinding> bindings_;
  GuardedBuffer<FollowHairRecord> followHairRecords_;
  ContactPass contacts_;
};

/// The constants as the reference takes them.
inline reference::ClassicStep toStep(const SimulationConstants& all, const StrandTerms& terms) {
  const SimulationConstants c = withTerms(all, terms);
  reference::ClassicStep step;
  step.timeStep = c.timeStep;
  step.timeStepRatio = c.timeStepRatio;
  step.dampingKeep = c.dampingKeep;
  step.gravityStep = c.gravityStep;
  step.forceShare = c.forceShare;
  step.gravity = toVector(c.gravity);
  step.maxSpeed = c.maxSpeed;
  step.lengthIterations = static_cast<int>(c.lengthIterations);
  step.wind = toVector(c.wind);
  step.airDrag = c.wind.w;
  step.globalStiffness = c.globalStiffness;
  step.globalRange = c.globalRange;
  step.localStiffness = c.localIterations > 0 ? c.localStiffness : 0;
  step.localIterations = static_cast<int>(c.localIterations);
  step.vspCoefficient = c.vspCoefficient;
  step.vspThreshold = c.vspThreshold;
  return step;
}

}  // namespace pelage::test
