// The passes of the classic solver.
#include <algorithm>
#include <cmath>

#include "passes/dispatch_rows.h"
#include "pelage/bindings.h"
#include "pelage/constants.h"
#include "pelage/kernels.h"
#include "simulation/hair_passes.h"
#include "simulation/strand_solver.h"

namespace pelage::detail {
namespace {

// Stiffness 1 would be an infinite spring.
constexpr double kMaxGlobalStiffness = 0.9999;
// Beyond this the local shape's sweeps overshoot; found by sweeping it on curled strands.
constexpr double kMaxLocalStiffness = 0.95;

// Displacement in a step of t for 1 m/s2 [s2], at the terminal velocity that steps of 1/60 s have.
double squareOf(double t, double damping) {
  if (!(damping > 1e-6)) return t * t;
  return t * kReferenceStep * (1 - std::pow(1 - damping, t / kReferenceStep)) / damping;
}

// A share s of the way to a goal in 1/60 s as a share for a step of h: a spring of the same
// frequency, solved implicitly.
double mapStiffness(double s, double h) {
  const double ratio = h / kReferenceStep;
  const double spring = ratio * ratio * s / (1 - s);
  return spring / (1 + spring);
}

// Constants that do not depend on the step.
SimulationConstants stepConstants(const HairFrame& frame, const RestSets& rest) {
  const SimulationSettings& s = frame.settings;
  const double h = static_cast<double>(frame.length) / frame.steps;
  // Forces are found for steps of 1/60 s or more, and shorter steps take a share of them.
  const double forceStep = std::max(h, kReferenceStep);
  const double damping = static_cast<double>(s.damping);

  SimulationConstants constants = constantsOf(frame);
  const Float3 gravity = frame.gravity();
  constants.gravity = {gravity.x, gravity.y, gravity.z, 1 - frame.loadShare};
  const Float3 wind = frame.air.velocity;
  constants.wind = {wind.x, wind.y, wind.z, s.airDrag};
  const Float3 gust0 = frame.air.gust0, gust1 = frame.air.gust1;
  constants.gust0 = {gust0.x, gust0.y, gust0.z, s.wind.strandVariation};
  constants.gust1 = {gust1.x, gust1.y, gust1.z, 0};
  constants.factorSet = rest.factors ? 2 : 0;
  constants.timeStep = static_cast<float>(h);
  constants.dampingKeep = static_cast<float>(std::pow(1 - damping, forceStep / kReferenceStep));
  constants.gravityStep = static_cast<float>(squareOf(forceStep, damping));
  constants.forceShare = static_cast<float>(squareOf(h, damping) / squareOf(forceStep, damping));
  constants.localStiffness = static_cast<float>(
      mapStiffness(std::min(static_cast<double>(s.localStiffness), kMaxLocalStiffness), forceStep));
  if (usesTargets(s)) {
    constants.globalStiffness = static_cast<float>(mapStiffness(
        std::min(static_cast<double>(s.globalStiffness), kMaxGlobalStiffness), forceStep));
  }
  constants.globalRange = s.globalRange;
  constants.vspCoefficient = s.vspCoefficient;
  constants.vspThreshold = s.vspThreshold;
  constants.maxSpeed = s.maxSpeed;
  constants.localIterations = s.localStiffness > 0 ? s.localIterations : 0;
  constants.lengthIterations = s.lengthIterations;

  constants.contactMasks = frame.contacts.masks;
  constants.contactMaskWords = frame.contacts.maskWords;
  // Still air does not drag.
  if (isZero(s.wind.velocity)) constants.wind.w = 0;
  return constants;
}

// The bindings of every pass of the solver.
SimBindings bindingsOf(const HairFrame& frame, const SimulationConstants& constants) {
  return {.simulationConstants = constants,
          .state = frame.factory.resources.whole(frame.buffers.state)};
}

BufferRange restOf(const HairFrame& frame, const RestSets& rest) {
  return {frame.buffers.rest, (rest.factors ? 3 : 2) * frame.guideVertices() * kVector};
}

SimPosTanBindings outputsOf(const HairFrame& frame) {
  const uint64_t bytes = frame.guideVertices() * kVector;
  return {.positions = {frame.buffers.positions, bytes},
          .tangents = {frame.buffers.tangents, bytes}};
}

}  // namespace

Result<void> ClassicSolver::record(const HairFrame& frame, const StepInputs& inputs,
                                   const SolverMemory& memory) {
  const uint64_t guides = frame.guideCount, vertices = frame.guideVertices();
  SimulationConstants constants = stepConstants(frame, memory.rest);
  SimulateClassicKey key;
  key.contacts = frame.contacts.any;
  key.forces = frame.forces != BufferId::kInvalid;
  const KernelVariant& variant = simulateClassicVariant(key);
  const auto steps = static_cast<float>(frame.steps);
  for (uint32_t step = 0; step < frame.steps; ++step) {
    constants.flags = 0;
    if (step == 0 && frame.reset) constants.flags |= simulation::kResetFlag;
    if (step == 0 && !isZero(frame.rebase)) constants.flags |= simulation::kRebaseFlag;
    constants.rootBegin = static_cast<float>(step) / steps;
    constants.rootEnd = static_cast<float>(step + 1) / steps;
    constants.timeStepRatio = lastStep_ > 0 ? constants.timeStep / lastStep_ : 1.0f;
    lastStep_ = constants.timeStep;
    if (frame.contacts.any) {
      Result<void> found = inputs.findContacts(
          {.step = step, .steps = frame.steps, .strands = frame.guideCount, .again = false});
      if (!found) return found;
    }
    PassBuilder builder(frame.list);
    // State read and written twice each, rest data, positions and tangents.
    builder.dispatch(variant, frame.guideCount)
        .bytes(8 * vertices * kVector + 2 * guides * sizeof(RootTransform));
    SimBindings bindings = bindingsOf(frame, constants);
    bindings.rest = restOf(frame, memory.rest);
    bindings.contacts = {frame.contacts.records.buffer, frame.contacts.recordBytes};
    bindings.strandForces = {frame.forces, vertices * kVector};
    bindings.contactWords = frame.contacts.words;
    if (Result<void> added = builder.finish(outputsOf(frame), bindings); !added) return added;
  }
  return {};
}

// The bind shape under the roots.
Result<void> ClassicSolver::skin(const HairFrame& frame, const SolverMemory& memory) {
  const uint64_t vertices = frame.guideVertices();
  SimulationConstants constants = constantsOf(frame);
  constants.vspCoefficient = frame.settings.vspCoefficient;
  lastStep_ = frame.length;
  PassBuilder builder(frame.list);
  dispatchRows(builder, skinClassicStrandsVariant({}), vertices);
  builder.bytes(5 * vertices * kVector);
  SimBindings bindings = bindingsOf(frame, constants);
  bindings.rest = restOf(frame, memory.rest);
  return builder.finish(outputsOf(frame), bindings);
}

// Positions from the state, after a shift of the world.
Result<void> ClassicSolver::rewritePositions(const HairFrame& frame) {
  const uint64_t vertices = frame.guideVertices();
  SimulationConstants constants = constantsOf(frame);
  const Float3 origin = frame.stateOrigin.world();
  constants.origin = {origin.x, origin.y, origin.z, 0};
  PassBuilder builder(frame.list);
  dispatchRows(builder, rewriteClassicPositionsVariant({}), vertices);
  builder.bytes(3 * vertices * kVector);
  return builder.finish(
      SimPosTanBindings{.positions = {frame.buffers.positions, vertices * kVector}},
      bindingsOf(frame, constants));
}

}  // namespace pelage::detail
