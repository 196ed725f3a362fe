// A scene on a device of its own, for tests of what the whole simulation does.
#pragma once

#include <gtest/gtest.h>

#include <array>
#include <cstring>
#include <memory>
#include <tuple>
#include <utility>
#include <vector>

#include "pelage/scene.h"
#include "support/gpu_fixture.h"

namespace pelage::test {

/// Every solver on every API. The sanitizers see the host's code alone, in which solvers know
/// nothing of APIs and runtimes nothing of solvers: there, every API and every solver once or more.
inline std::vector<std::tuple<Api, Solver>> solversOnApis() {
  if (kSanitized)
    return {
        {Api::kVulkan, Solver::kExact}, {Api::kGl, Solver::kClassic}, {Api::kGles, Solver::kExact}};
  std::vector<std::tuple<Api, Solver>> all;
  for (const Api api : kApis)
    for (const Solver solver : {Solver::kExact, Solver::kClassic}) all.emplace_back(api, solver);
  return all;
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
  ColliderId add(const CollisionMesh& mesh, const SdfColliderDef& def) {
    const Result<ColliderId> added = scene.addCollider(mesh, def);
    EXPECT_TRUE(added) << added.error().message;
    colliders_.push_back(*added);
    return *added;
  }
  ColliderId add(const SdfData& data, const SdfColliderDef& def) {
    const Result<ColliderId> added = scene.addCollider(data, def);
    EXPECT_TRUE(added) << added.error().message;
    colliders_.push_back(*added);
    return *added;
  }
  void remove(ColliderId id) {
    EXPECT_TRUE(scene.removeCollider(id));
    std::erase(colliders_, id);
  }
  /// Removes all that add() has added.
  void clear() {
    for (const HairId id : hairs_) EXPECT_TRUE(scene.removeHair(id));
    for (const ColliderId id : colliders_) EXPECT_TRUE(scene.removeCollider(id));
    hairs_.clear();
    colliders_.clear();
  }
  void step(float dt = 1.0f / 60) {
    expectOk(scene.simulate(dt, list_));
    scene.finish(list_);
    expectOk(device_->update(scene.resources()));
    expectOk(device_->execute(list_));
  }
  /// What a camera at `eye` that looks along -z sees, square and with 45 degrees.
  RenderedImage render(Float3 eye, uint32_t pixels) {
    View view;
    view.worldToClip = lookAt(eye, {eye.x, eye.y, eye.z - 1}, {0, 1, 0}, 0.785f, 1, 0.1f, 10.0f);
    view.eye = eye;
    view.width = view.height = pixels;
    PassList list;
    expectOk(scene.draw(view, {}, list));
    scene.finish(list);
    expectOk(device_->update(scene.resources()));
    RenderTargetDef target;
    target.width = target.height = pixels;
    Result<RenderedImage> image = device_->render(list, target);
    if (image) return std::move(*image);
    ADD_FAILURE() << image.error().message;
    return {pixels, pixels, std::vector<Float4>(size_t{pixels} * pixels)};
  }
  template <class T = Float4>
  std::vector<T> read(BufferId buffer) const {
    const auto raw = device_->read(buffer);
    EXPECT_TRUE(raw) << raw.error().message;
    std::vector<T> values(raw ? raw->size() / sizeof(T) : 0);
    if (raw) std::memcpy(values.data(), raw->data(), values.size() * sizeof(T));
    return values;
  }
  /// Of the object that was added last.
  HairId lastHair() const { return hairs_.back(); }
  std::vector<Float4> positions(const HairObject& hair) const {
    return read(hair.buffers().positions);
  }

  /// That the last step() ran.
  const PassList& list() const { return list_; }

  Scene scene;

 private:
  std::unique_ptr<HeadlessDevice> device_;
  PassList list_;
  std::vector<HairId> hairs_;
  std::vector<ColliderId> colliders_;
};

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

}  // namespace pelage::test
