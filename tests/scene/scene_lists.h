// A scene and the lists of its frames, without a GPU.
#pragma once

#include <gtest/gtest.h>

#include "pelage/scene.h"
#include "support/errors.h"
#include "support/lists.h"
#include "support/plain_asset.h"

namespace pelage::test {

inline constexpr float kFrameSeconds = 1.0f / 60;

/// As if all lists ran, and looks at each of them.
template <class Look>
FrameExecutor executorOf(const Look& look) {
  return {.update = [](const ResourceTable&) { return Result<void>(); },
          .record =
              [look](const FrameStep& step) {
                look(*step.list);
                setDelivered(step.list->run);
                return Result<void>();
              },
          .draw = [](const FrameStep&) { return Result<void>(); }};
}

class SceneListTest : public testing::Test {
 protected:
  HairId addHair(const HairDef& def = {}) { return addHair(makeAsset(), def); }
  HairId addHair(const HairAsset& asset, const HairDef& def) {
    return valueOf(scene_.addHair(asset, def));
  }
  ColliderId addCollider(const CollisionMesh& mesh, const SdfColliderDef& def) {
    return valueOf(scene_.addCollider(mesh, def));
  }
  void write(PassList& list, float dt = kFrameSeconds) {
    expectOk(scene_.simulate(dt, list));
    scene_.finish(list);
  }
  /// In place of a runtime: all of it has run.
  PassList& simulate(float dt = kFrameSeconds) {
    write(list_, dt);
    setDelivered(list_.run);
    return list_;
  }
  /// As a runtime does it, which looks whether it may.
  void run() {
    write(list_);
    ASSERT_TRUE(checkRun(list_));
    setDelivered(list_.run);
  }
  size_t count(std::string_view name) const { return countPasses(list_, name); }

  Scene scene_;
  PassList list_;
};

}  // namespace pelage::test
