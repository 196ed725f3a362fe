// What the stress tests share: how much of them runs, what they print, and what they check.
#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <memory>
#include <string>
#include <tuple>
#include <vector>

#include "support/extremes.h"
#include "support/required_devices.h"
#include "support/scene_run.h"
#include "support/strand_run.h"

namespace pelage::test {

/// PELAGE_STRESS=full runs everything; without it a share of it that suits software drivers and CI.
inline bool fullStress() {
  const char* wanted = std::getenv("PELAGE_STRESS");
  return wanted != nullptr && std::string(wanted) == "full";
}

/// A line of docs/stress.md.
inline void printFigure(const std::string& what, double measured) {
  std::printf("[ FIGURE ] %s: %.4g\n", what.c_str(), measured);
}

inline AffineTransform toTransform(const Eigen::Matrix3d& rotation, const Vector3d& shift) {
  AffineTransform result;
  for (int row = 0; row < 3; ++row)
    result.rows[row] = toFloat4(rotation.row(row).transpose(), shift[row]);
  return result;
}

inline double distance(const Float4& a, const Float4& b) {
  return (toVector(a) - toVector(b)).norm();
}

/// How far off the rest lengths the edges of a strand are, relative to them. An edge that is
/// shorter than the rounding of its ends has no length of its own: `rounding` metres and a
/// nanometre are added to the rest length so that 1 % of them are no stretch.
inline double stretchOf(const HairAsset& asset, const std::vector<Float4>& positions,
                        uint32_t strand, double rounding) {
  const size_t first = size_t{strand} * asset.verticesPerStrand;
  double worst = 0;
  for (size_t i = first; i + 1 < first + asset.verticesPerStrand; ++i) {
    const double rest = static_cast<double>(asset.restLengths[i]);
    const double off = std::abs(distance(positions[i], positions[i + 1]) - rest);
    keepLargest(worst, off / (rest + rounding + 1e-9));
  }
  return worst;
}

inline bool allFinite(const std::vector<Float4>& values) {
  return std::all_of(values.begin(), values.end(), [](const Float4& v) { return isFinite(v); });
}

inline const char* solverName(Solver solver) {
  return solver == Solver::kExact ? "Exact" : "Classic";
}

/// A test of a whole scene for each API and solver. Lavapipe (Mesa 22.3) may compile a kernel anew
/// in every dispatch (docs/decisions/0008): these tests have forces along y and z alone, and always
/// some wind and shock propagation, unless they are run in full.
class StressTest : public testing::TestWithParam<std::tuple<Api, Solver>> {
 protected:
  StressTest() : run_(shared(api())) { settings_.solver = std::get<1>(GetParam()); }
  void SetUp() override {
    if (run_.device() == nullptr) PELAGE_SKIP_WITHOUT_DEVICE() << "no device";
    messages_ = run_.device()->messageCount();
  }
  void TearDown() override {
    while (!ids_.empty()) remove(ids_.back());
    if (run_.device() != nullptr) {
      EXPECT_EQ(run_.device()->messageCount(), messages_) << "the driver or a layer complained";
    }
  }
  static Api api() { return std::get<0>(GetParam()); }
  bool exact() const { return settings_.solver == Solver::kExact; }
  std::string label() const {
    return std::string(solverName(settings_.solver)) + " on " + apiName(api()) + ", " +
           run_.device()->info().name;
  }
  /// Until the test's end, or remove().
  HairId add(const HairAsset& asset, const HairDef& def) {
    const Result<HairId> added = run_.scene.addHair(asset, def);
    if (added) {
      ids_.push_back(*added);
      return *added;
    }
    ADD_FAILURE() << added.error().message;
    return HairId::kInvalid;
  }
  void remove(HairId id) {
    EXPECT_TRUE(run_.scene.removeHair(id));
    std::erase(ids_, id);
  }

  /// Settings of hair that is back in its place well within a second.
  void makeHairReturnSoon() {
    settings_.damping = 0.3f;
    settings_.globalStiffness = 0.2f;
    settings_.globalRange = 1;
    // Curls of softer hair have a second shape in which they come to rest.
    settings_.bendLength = 0.2f;
    settings_.wind.velocity.z = 0.5f;
    settings_.wind.gustStrength = 0;
  }

  SceneRun& run_;
  SimulationSettings settings_;

 private:
  /// One device an API, because drivers compile kernels for each device.
  static SceneRun& shared(Api api) {
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

  std::vector<HairId> ids_;
  uint32_t messages_ = 0;
};

inline std::string stressTestName(const testing::TestParamInfo<std::tuple<Api, Solver>>& info) {
  return std::string(apiName(std::get<0>(info.param))) + solverName(std::get<1>(info.param));
}

}  // namespace pelage::test
