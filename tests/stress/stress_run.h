// Shared by the stress tests: figures that they print, and checks.
#pragma once

#include <cstdio>
#include <fstream>
#include <string>
#include <vector>

#include "support/full_stress.h"
#include "support/scene_test.h"
#include "support/strand_measures.h"

namespace pelage::test {

/// A line of the README of this folder.
inline void printFigure(const std::string& what, double measured) {
  std::printf("[ FIGURE ] %s: %.4g\n", what.c_str(), measured);
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

/// A test of a whole scene for each API and solver. Lavapipe (Mesa 22.3) may compile a kernel anew
/// in every dispatch (docs/decisions/0008): these tests have forces along y and z alone, and always
/// some wind and shock propagation, unless they are run in full.
class StressTest : public SolverTest {
 protected:
  std::string label() const {
    return std::string(solverName(settings_.solver)) + " on " + apiName(api()) + ", " +
           run_.device()->info().name;
  }
  /// Until the test's end, or remove().
  HairId add(const HairAsset& asset, const HairDef& def) {
    run_.add(asset, def);
    return run_.lastHair();
  }
  void remove(HairId id) { run_.remove(id); }

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
};

/// Resident memory of this process [bytes]; 0 where the system does not say.
inline uint64_t residentMemory() {
  std::ifstream status("/proc/self/status");
  for (std::string line; std::getline(status, line);)
    if (line.rfind("VmRSS:", 0) == 0) return std::stoull(line.substr(6)) * 1024;
  return 0;
}

}  // namespace pelage::test
