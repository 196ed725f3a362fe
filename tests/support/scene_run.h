// A scene on a device of its own, for tests of the whole simulation.
#pragma once

#include <gtest/gtest.h>

#include <array>
#include <cstring>
#include <memory>
#include <span>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include "pelage/scene.h"
#include "support/full_stress.h"
#include "support/gpu_fixture.h"
#include "support/required_devices.h"

namespace pelage::test {

/// Scenes with each solver on Vulkan, and on OpenGL and OpenGL ES with one of them: solvers know
/// nothing of APIs, and runtimes nothing of solvers. Each kernel has tests on every API.
/// PELAGE_STRESS=full: every solver on every API. The sanitizers see the host's code alone.
inline std::vector<std::tuple<Api, Solver>> solversOnApis() {
  if (kSanitized)
    return {
        {Api::kVulkan, Solver::kExact}, {Api::kGl, Solver::kClassic}, {Api::kGles, Solver::kExact}};
  if (!fullStress())
    return {{Api::kVulkan, Solver::kExact},
            {Api::kVulkan, Solver::kClassic},
            {Api::kGl, Solver::kExact},
            {Api::kGles, Solver::kClassic}};
  std::vector<std::tuple<Api, Solver>> all;
  for (const Api api : kApis)
    for (const Solver solver : {Solver::kExact, Solver::kClassic}) all.emplace_back(api, solver);
  return all;
}

/// These leave OpenGL ES out, as kRuntimeApis does.
inline std::vector<std::tuple<Api, Solver>> solversOnRuntimes() {
  std::vector<std::tuple<Api, Solver>> all = solversOnApis();
  std::erase_if(all, [](const auto& one) { return std::get<0>(one) == Api::kGles; });
  return all;
}

/// Names of tests by the parameters above.
inline std::string solverTestName(const testing::TestParamInfo<std::tuple<Api, Solver>>& test) {
  return std::string(apiName(std::get<0>(test.param))) +
         (std::get<1>(test.param) == Solver::kExact ? "Exact" : "Classic");
}

/// Finishes the lists of a view, updates the device and draws them one behind the other.
inline Result<RenderedImage> renderLists(Scene& scene, HeadlessDevice& device,
                                         std::span<PassList> lists, const RenderTargetDef& target) {
  std::vector<const PassList*> pointers;
  for (PassList& list : lists) {
    scene.finish(list);
    pointers.push_back(&list);
  }
  expectOk(device.update(scene.resources()));
  return device.render(pointers, target);
}

/// The picture; an empty one of the target's size after a failure.
inline RenderedImage imageOf(Result<RenderedImage> image, const RenderTargetDef& target) {
  if (image) return std::move(*image);
  ADD_FAILURE() << image.error().message;
  return {target.width, target.height, std::vector<Float4>(size_t{target.width} * target.height)};
}

class SceneRun {
 public:
  /// Without a device() where the API is not there; a driver that fails to start fails the test.
  explicit SceneRun(Api api) {
    auto made = createDevice({.api = api, .validation = true});
    if (!made) {
      missingDevice(made.error().message);
      made = createDevice({.api = api});
    }
    if (made) {
      device_ = std::move(*made);
      scene.setTier(device_->info().tier);
    } else if (made.error().code != ErrorCode::kUnsupported) {
      ADD_FAILURE() << made.error().message;
    }
  }
  ~SceneRun() {
    if (device_ != nullptr) {
      EXPECT_EQ(device_->messageCount(), 0u) << "the driver or a layer complained";
    }
  }

  HeadlessDevice* device() const { return device_.get(); }
  HairObject& add(const HairAsset& asset, const HairDef& def = {}) {
    const Result<HairId> added = scene.addHair(asset, def);
    EXPECT_TRUE(added) << added.error().message;
    hairs_.push_back(*added);
    return scene.hair(*added);
  }
  /// \param shape  a CollisionMesh, SdfData or DenseSdf
  template <class Shape>
  ColliderId add(const Shape& shape, const SdfColliderDef& def) {
    const Result<ColliderId> added = scene.addCollider(shape, def);
    EXPECT_TRUE(added) << added.error().message;
    colliders_.push_back(*added);
    return *added;
  }
  SkeletonId add(const SkeletonDef& def) {
    const Result<SkeletonId> added = scene.addSkeleton(def);
    EXPECT_TRUE(added) << added.error().message;
    skeletons_.push_back(*added);
    return *added;
  }
  /// A buffer that stands for one of an engine.
  template <class T>
  BufferId add(std::string name, const std::vector<T>& values) {
    buffers_.push_back(scene.resources().add(std::move(name), values,
                                             BufferUsage::kStorage | BufferUsage::kUpload));
    return buffers_.back();
  }
  void remove(ColliderId id) {
    EXPECT_TRUE(scene.removeCollider(id));
    std::erase(colliders_, id);
  }
  void remove(HairId id) {
    EXPECT_TRUE(scene.removeHair(id));
    std::erase(hairs_, id);
  }
  /// Removes all that add() has added.
  void clear() {
    for (const HairId id : hairs_) EXPECT_TRUE(scene.removeHair(id));
    for (const ColliderId id : colliders_) EXPECT_TRUE(scene.removeCollider(id));
    for (const SkeletonId id : skeletons_) EXPECT_TRUE(scene.removeSkeleton(id));
    for (const BufferId id : buffers_) scene.resources().remove(id);
    hairs_.clear();
    colliders_.clear();
    skeletons_.clear();
    buffers_.clear();
  }
  void step(float dt = 1.0f / 60) {
    expectOk(scene.simulate(dt, list_));
    execute(list_);
  }
  /// Finishes a list of the scene and runs it.
  void execute(PassList& list) {
    scene.finish(list);
    expectOk(device_->update(scene.resources()));
    expectOk(device_->execute(list));
  }
  /// A camera at `eye` that looks along -z, square and with 45 degrees.
  static View viewFrom(Float3 eye, uint32_t pixels) {
    View view;
    view.worldToClip = lookAt(eye, {eye.x, eye.y, eye.z - 1}, {0, 1, 0}, 0.785f, 1, 0.1f, 10.0f);
    view.eye = eye;
    view.width = view.height = pixels;
    return view;
  }
  /// The view of that camera.
  RenderedImage render(Float3 eye, uint32_t pixels) {
    PassList list;
    expectOk(scene.draw(viewFrom(eye, pixels), {}, list));
    return render(list, pixels);
  }
  /// The picture of a list's draws, square; black where there is none.
  RenderedImage render(PassList& list, uint32_t pixels) {
    scene.finish(list);
    expectOk(device_->update(scene.resources()));
    RenderTargetDef target;
    target.width = target.height = pixels;
    Result<RenderedImage> image = device_->render(list, target);
    if (image) return std::move(*image);
    ADD_FAILURE() << image.error().message;
    return {pixels, pixels, std::vector<Float4>(size_t{pixels} * pixels)};
  }
  Result<RenderedImage> renderLists(std::span<PassList> lists, const RenderTargetDef& target) {
    return test::renderLists(scene, *device_, lists, target);
  }
  template <class T = Float4>
  std::vector<T> read(BufferId buffer) const {
    const auto raw = device_->read(buffer);
    EXPECT_TRUE(raw) << raw.error().message;
    std::vector<T> values(raw ? raw->size() / sizeof(T) : 0);
    if (raw) std::memcpy(values.data(), raw->data(), values.size() * sizeof(T));
    return values;
  }
  /// How many strands are awake.
  uint32_t awake(const HairObject& hair) const {
    const std::vector<uint32_t> words = read<uint32_t>(hair.buffers().sleep);
    return readCounters(std::as_bytes(std::span(words))).awakeStrands;
  }
  /// The SDF of a collider as it is on the device.
  SdfData copySdf(ColliderId id) const {
    const auto keys = device_->read(scene.sdfKeys()), surface = device_->read(scene.sdfSurface());
    EXPECT_TRUE(keys && surface);
    return valueOf(scene.copySdf(id, *keys, *surface));
  }
  /// The object that was added last.
  HairId lastHair() const { return hairs_.back(); }
  std::vector<Float4> positions(const HairObject& hair) const {
    return read(hair.buffers().positions);
  }

  /// The list of the last step().
  const PassList& list() const { return list_; }

  Scene scene;

 private:
  std::unique_ptr<HeadlessDevice> device_;
  PassList list_;
  std::vector<HairId> hairs_;
  std::vector<ColliderId> colliders_;
  std::vector<SkeletonId> skeletons_;
  std::vector<BufferId> buffers_;
};

/// The bone of an object or collider that has one.
template <class Object>
void setBone(Object& object, const AffineTransform& bone) {
  object.setBones({&bone, 1});
}

/// The only capsule that hair collides with.
inline void setCollider(HairObject& hair, const CapsuleCollider& capsule) {
  hair.setColliders({&capsule, 1});
}

inline CapsuleCollider sphereCollider(const Float3& center, float radius, float friction = 0.3f) {
  return {.head = center,
          .headRadius = radius,
          .tail = center,
          .tailRadius = radius,
          .friction = friction};
}

/// One for all tests of a program, because drivers compile kernels for each device: clear() it.
inline SceneRun& sharedSceneRun(Api api) {
  static auto all = std::make_unique<std::array<std::unique_ptr<SceneRun>, kApis.size()>>();
  struct Cleanup : testing::Environment {
    void TearDown() override { all.reset(); }
  };
  [[maybe_unused]] static testing::Environment* const cleanup =
      testing::AddGlobalTestEnvironment(new Cleanup);
  std::unique_ptr<SceneRun>& run = (*all)[static_cast<size_t>(api)];
  if (!run) run = std::make_unique<SceneRun>(api);
  return *run;
}

inline Api apiOf(Api api) { return api; }
template <class... Others>
Api apiOf(const std::tuple<Api, Others...>& parameter) {
  return std::get<0>(parameter);
}

/// Tests on the shared run of the parameter's API, which is left empty; skipped without a device.
template <class Parameter = Api>
class SceneRunTest : public testing::TestWithParam<Parameter> {
 protected:
  SceneRunTest() : run_(sharedSceneRun(apiOf(this->GetParam()))) {}
  void SetUp() override {
    if (run_.device() == nullptr)
      PELAGE_SKIP_WITHOUT_DEVICE() << "no " << apiName(apiOf(this->GetParam())) << " device";
  }
  void TearDown() override {
    if (run_.device() != nullptr) run_.clear();
  }

  SceneRun& run_;
};

}  // namespace pelage::test
