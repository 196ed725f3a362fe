#include "strand_solver.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "pelage/skeleton.h"
#include "simulation/copy_load.h"

namespace bench {

using pelage::BufferId;
using pelage::PassList;
using pelage::PassTiming;
using pelage::Result;
using pelage::rod::RootPose;

namespace {

pelage::AffineTransform toBone(const RootPose& pose) {
  const auto& q = pose.rotation;
  const auto f = [](double x) { return static_cast<float>(x); };
  return pelage::rigidTransform(
      {f(q.x), f(q.y), f(q.z), f(q.w)},
      {f(pose.translation.x), f(pose.translation.y), f(pose.translation.z)});
}

pelage::SimulationSettings settingsOf(const BenchScene& scene, const SolverChoice& choice) {
  pelage::SimulationSettings s;
  s.gravity = {0, -static_cast<float>(scene.gravity), 0};
  s.damping = static_cast<float>(1 - std::exp(-scene.airDrag / 60));
  s.bendLength = static_cast<float>(std::cbrt(scene.bend / 9.81));
  s.twistRatio = scene.bend > 0 ? static_cast<float>(scene.twist / scene.bend) : 0.75f;
  s.localStiffness = scene.localStiffness;
  s.vspCoefficient = static_cast<float>(scene.carry);
  s.vspThreshold = std::numeric_limits<float>::infinity();
  // The hair of a fast head is to follow it, not a limit.
  s.maxSpeed = 1000;
  s.sleep.enabled = scene.sleeps;
  if (choice.kind == SolverKind::kExact) {
    s.solver = pelage::Solver::kExact;
    s.subSteps = choice.effort;
  } else {
    s.solver = pelage::Solver::kClassic;
    s.lengthIterations = choice.effort;
  }
  return s;
}

/// pelage's own solvers, through the scene as an engine uses it.
class SceneSolver : public StrandSolver {
 public:
  static Result<std::unique_ptr<StrandSolver>> create(Workbench& workbench, const BenchScene& scene,
                                                      const SolverChoice& choice) {
    const auto settings = settingsOf(scene, choice);
    auto hair = workbench.scene.addHair(scene.asset, {.name = scene.name, .settings = settings});
    if (!hair) return hair.error();
    return std::unique_ptr<StrandSolver>(new SceneSolver(workbench.scene, *hair));
  }
  ~SceneSolver() override { (void)scene_.removeHair(hair_); }

  Result<void> advance(const RootPose& pose, PassList& list) override {
    pelage::HairObject& hair = scene_.hair(hair_);
    const pelage::AffineTransform bone = toBone(pose);
    hair.setBones({&bone, 1});
    // The bind pose without gravity is at rest, so the first frame stays in it.
    const pelage::Float3 gravity = hair.settings.gravity;
    if (first_) hair.settings.gravity = {};
    Result<void> done = scene_.simulate(static_cast<float>(kFrameSeconds), list);
    hair.settings.gravity = gravity;
    // The exact solver steps in the frame of a reset: without a history in which there was no
    // gravity, which would cost it a third of the first step's. The classic one only takes the
    // pose.
    if (first_ && hair.settings.solver == pelage::Solver::kExact) hair.reset();
    first_ = false;
    if (done) scene_.finish(list);
    return done;
  }
  BufferId positions() const override { return scene_.hair(hair_).buffers().positions; }

 private:
  SceneSolver(pelage::Scene& scene, pelage::HairId hair) : scene_(scene), hair_(hair) {}

  pelage::Scene& scene_;
  pelage::HairId hair_;
  bool first_ = true;
};

}  // namespace

const char* solverName(SolverKind kind) {
  switch (kind) {
    case SolverKind::kExact:
      return "exact";
    case SolverKind::kClassic:
      return "classic";
    case SolverKind::kSweeps:
      return "tressfx_like";
    case SolverKind::kCosserat:
      return "xpbd_cosserat";
  }
  return "unknown";
}

std::string SolverChoice::setting() const {
  const std::string count = std::to_string(effort);
  switch (kind) {
    case SolverKind::kExact:
    case SolverKind::kCosserat:
      return count + (effort == 1 ? " sub-step" : " sub-steps");
    case SolverKind::kClassic:
      return count + (effort == 1 ? " length solve" : " length solves");
    case SolverKind::kSweeps:
      return count + " sweeps";
  }
  return count;
}

Result<std::vector<PassTiming>> Workbench::run(PassList& list) {
  if (Result<void> done = device.update(scene.resources()); !done) return done.error();
  std::vector<PassTiming> timings;
  if (Result<void> done = device.execute(list, &timings); !done) return done.error();
  return timings;
}

Result<std::unique_ptr<StrandSolver>> makeSolver(Workbench& workbench, const BenchScene& scene,
                                                 const SolverChoice& choice) {
  if (choice.kind == SolverKind::kSweeps) return makeSweepsSolver(workbench, scene, choice.effort);
  if (choice.kind == SolverKind::kCosserat)
    return makeCosseratSolver(workbench, scene, choice.effort, kEdgeInertia);
  return SceneSolver::create(workbench, scene, choice);
}

Result<double> copyFloor(Workbench& workbench, uint32_t vertices, uint64_t bytes) {
  constexpr int kTries = 20;
  // More are copied in this many at a time: a buffer has a largest size on some devices.
  constexpr uint64_t kMostSets = 7;
  const uint64_t perSet = uint64_t{vertices} * sizeof(pelage::Float4);
  CopyLoad copy(workbench.device, workbench.scene, vertices,
                std::clamp<uint64_t>((bytes + perSet) / (2 * perSet), 1, kMostSets));
  const double copies = static_cast<double>(bytes) / static_cast<double>(copy.bytes());
  const auto timings = copy.run(kTries);
  if (!timings) return timings.error();
  double least = 0;
  for (const PassTiming& timing : *timings) {
    const double us = 1000 * timing.milliseconds * copies;
    if (us > 0 && (least == 0 || us < least)) least = us;
  }
  return least;
}

}  // namespace bench
