// Tests of whole scenes: the parameters that they run with, and what is there before and after
// each.
#pragma once

#include <gtest/gtest.h>

#include <string>
#include <tuple>

#include "support/scene_run.h"

namespace pelage::test {

inline const char* solverName(Solver solver) {
  return solver == Solver::kExact ? "Exact" : "Classic";
}

/// Checks that no driver or layer complains, too.
template <class Parameter>
class SceneTestOn : public SceneRunTest<Parameter> {
 protected:
  void SetUp() override {
    SceneRunTest<Parameter>::SetUp();
    if (this->run_.device() != nullptr) messages_ = this->run_.device()->messageCount();
  }
  void TearDown() override {
    SceneRunTest<Parameter>::TearDown();
    if (this->run_.device() == nullptr) return;
    EXPECT_EQ(this->run_.device()->messageCount(), messages_) << "the driver or a layer complained";
  }

 private:
  uint32_t messages_ = 0;
};

/// With the Api as parameter.
using SceneTest = SceneTestOn<Api>;

/// With an Api and a Solver, which the settings have.
class SolverTest : public SceneTestOn<std::tuple<Api, Solver>> {
 protected:
  SolverTest() { settings_.solver = std::get<1>(GetParam()); }
  static Api api() { return std::get<0>(GetParam()); }
  bool exact() const { return settings_.solver == Solver::kExact; }

  SimulationSettings settings_;
};

/// Both solvers on the first API of the build, for tests of the host's code.
inline auto solversOnFirstApi() {
  return testing::Combine(testing::Values(kFirstApi),
                          testing::Values(Solver::kExact, Solver::kClassic));
}

/// Both solvers on every API.
inline auto allSolversOnApis() {
  return testing::Combine(testing::ValuesIn(kApis),
                          testing::Values(Solver::kExact, Solver::kClassic));
}

/// Both solvers on each runtime.
inline auto allSolversOnRuntimes() {
  return testing::Combine(testing::ValuesIn(kRuntimeApis),
                          testing::Values(Solver::kExact, Solver::kClassic));
}

}  // namespace pelage::test
