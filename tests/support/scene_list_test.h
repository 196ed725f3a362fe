// Tests of a scene's lists, without a device.
#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <cstring>
#include <string_view>
#include <vector>

#include "pelage/scene.h"
#include "support/errors.h"
#include "support/lists.h"
#include "support/plain_asset.h"

namespace pelage::test {

class SceneListTest : public testing::Test {
 protected:
  HairObject& addHair(const HairDef& def = {}, const HairAsset& asset = makeAsset()) {
    return scene_.hair(valueOf(scene_.addHair(asset, def)));
  }
  /// \param delivered  the frame runs, as far as the scene knows
  void simulate(float dt = 1.0f / 60, bool delivered = true) {
    const Result<void> done = scene_.simulate(dt, list_);
    ASSERT_TRUE(done) << done.error().message;
    scene_.finish(list_);
    if (delivered) setDelivered(list_.run);
  }
  /// Fails unless the frame is refused with all of these words.
  void expectRefused(std::initializer_list<std::string_view> words) {
    expectError(scene_.simulate(1.0f / 60, list_), words);
  }
  std::vector<const Pass*> passes(std::string_view name) const {
    std::vector<const Pass*> found;
    for (const Pass& pass : list_.passes)
      if (pass.name == name) found.push_back(&pass);
    return found;
  }
  size_t count(std::string_view name) const { return passes(name).size(); }
  /// Constants of the passes of a kernel.
  template <class T>
  std::vector<T> constantsOf(std::string_view name) const {
    std::vector<T> found;
    for (const Pass* pass : passes(name)) {
      for (const PassBinding& binding : list_.bindingsOf(*pass)) {
        if (binding.buffer != BufferId::kInvalid) continue;
        found.emplace_back();
        std::memcpy(&found.back(), list_.constants.data() + binding.offset, sizeof(T));
      }
    }
    return found;
  }
  /// The bytes of the first upload to a buffer; empty without one.
  template <class T>
  std::vector<T> uploaded(BufferId buffer) const {
    return test::uploaded<T>(list_, buffer);
  }

  Scene scene_;
  PassList list_;
};

}  // namespace pelage::test
