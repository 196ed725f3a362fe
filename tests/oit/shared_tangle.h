// A tangle on a device that all tests of a program have in common: most of their time is that of
// making pipelines.
#pragma once

#include <map>
#include <memory>

#include "oit/tangle.h"
#include "support/required_devices.h"

namespace pelage::test {

/// A transparency method, and the samples of the targets that it draws into.
struct Method {
  const char* name;
  Transparency transparency;
  uint32_t samples = 1;
};
inline constexpr Method kMethods[] = {
    {"alpha test", Transparency::kAlphaTest}, {"stochastic", Transparency::kStochastic, 4},
    {"windowed", Transparency::kWindowed},    {"hybrid 4", Transparency::kHybrid4},
    {"hybrid 8", Transparency::kHybrid8},     {"hybrid 16", Transparency::kHybrid16},
    {"ShortCut", Transparency::kShortCut},    {"tiles", Transparency::kTiles}};

/// Makes one TangleRun for each API of the parameters, or skips.
template <class Parameter = Api>
class SharedTangleTest : public testing::TestWithParam<Parameter> {
 protected:
  static void TearDownTestSuite() { runs().clear(); }
  void SetUp() override {
    const Api api = apiOf(this->GetParam());
    std::unique_ptr<TangleRun>& run = runs()[api];
    if (run == nullptr) {
      run = std::make_unique<TangleRun>(api);
      if (hasDevice()) fill(*run);
    }
    if (!hasDevice()) PELAGE_SKIP_WITHOUT_DEVICE() << "skipped: no " << apiName(api) << " device";
  }
  /// Adds what the scene has in all tests.
  virtual void fill(TangleRun& run) = 0;

  TangleRun& tangleRun() { return *runs()[apiOf(this->GetParam())]; }
  HeadlessDevice& device() { return *tangleRun().run.device(); }
  /// False where SetUp() has skipped the test.
  bool hasDevice() { return tangleRun().run.device() != nullptr; }
  bool hasTarget(const Method& method) {
    return (device().info().sampleCounts & method.samples) != 0;
  }

 private:
  static std::map<Api, std::unique_ptr<TangleRun>>& runs() {
    static std::map<Api, std::unique_ptr<TangleRun>> all;
    return all;
  }
};

}  // namespace pelage::test
