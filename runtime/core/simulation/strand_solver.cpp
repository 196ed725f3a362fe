#include "simulation/strand_solver.h"

#include <utility>
#include <vector>

#include "pelage/assert.h"
#include "pelage/constants.h"
#include "pelage/kernels.h"

namespace pelage::detail {

void StrandSolver::remove(HairBuffers& buffers, const BufferFactory& factory) {
  for (BufferId* buffer : {&buffers.state, &buffers.rest, &buffers.sleep, &buffers.lodParents})
    factory.remove(*buffer);
  solver_.reset();
}

void StrandSolver::prepare(HairFrame& frame) {
  const Groom& groom = frame.groom;
  const SimulationSettings& s = frame.settings;
  const bool exact = s.solver == Solver::kExact;
  frame.otherSolver = solver_ != s.solver;
  if (frame.otherSolver) {
    remove(frame.buffers, frame.factory);
    frame.reset = true;
    solver_ = s.solver;
    if (exact)
      makeExactBuffers(frame);
    else
      makeState(frame, kClassicStateSets * frame.guideVertices());
  }
  const RestSets sets = {.targets = exact && (usesTargets(s) || groom.heldVertices),
                         .factors = !groom.strandFactors.empty() || s.curves != ParameterCurves{},
                         .strands = groom.strandFactors,
                         .curves = s.curves,
                         .sag = sagLoadOf(s)};
  const bool otherPose = memory_.restVersion != frame.inputs.rest.version;
  if (otherPose) {
    frame.factory.remove(frame.buffers.bindRoots);
    frame.buffers.bindRoots = frame.factory.share(frame.name, "bindRoots", kVector,
                                                  bytesOf(bindRootsOf(*frame.inputs.rest.asset)));
    memory_.restVersion = frame.inputs.rest.version;
  }
  if (otherPose || frame.buffers.rest == BufferId::kInvalid || !(sets == memory_.rest))
    makeRest(frame, sets);
  frame.roots = rootTransforms(frame.buffers);
  frame.otherRest = memory_.restChanged();
}

// The state, and behind it the roots, which other rooms bind alone.
void StrandSolver::makeState(const HairFrame& frame, uint64_t elements) {
  constexpr uint64_t kAlignment = exact::kRootAlignment;
  static_assert(kAlignment * kVector % 256 == 0, "devices ask for offsets of up to 256 bytes");
  static_assert(simulation::kRootAlignment == kAlignment);
  rootOffset_ = (elements + kAlignment - 1) / kAlignment * kAlignment * kVector;
  rootBytes_ = uint64_t{simulation::kRootSets} * frame.guideCount * sizeof(RootTransform);
  frame.buffers.state =
      frame.factory.add(frame.name + "/state", (rootOffset_ + rootBytes_) / kVector, kVector);
}

void StrandSolver::makeExactBuffers(HairFrame& frame) {
  const HairAsset& asset = *frame.inputs.rest.asset;
  const ExactStrands strands = exactStrandsOf(frame.groom, frame.inputs.rest);
  exact_ = ExactSolver(strands.stateStride);
  HairBuffers& buffers = frame.buffers;
  makeState(frame, exactStateCount(strands.stateStride, asset.strandCount));
  if (frame.groom.levelOfDetail) {
    const std::vector<uint32_t> parents = nearStrandsBefore(asset, strands);
    buffers.lodParents =
        frame.factory.share(frame.name, "lodParents", sizeof(uint32_t), bytesOf(parents));
  }
  buffers.sleep = frame.factory.add(frame.name + "/sleep", sleepWordCount(frame.guideCount),
                                    sizeof(uint32_t), {},
                                    BufferUsage::kStorage | BufferUsage::kIndirect |
                                        BufferUsage::kUpload | BufferUsage::kReadback);
}

void StrandSolver::makeRest(const HairFrame& frame, const RestSets& sets) {
  const HairAsset& asset = *frame.inputs.rest.asset;
  memory_.rest = sets;
  memory_.limpGuides = 0;
  frame.factory.remove(frame.buffers.rest);
  std::vector<Float4> rest;
  if (frame.settings.solver == Solver::kExact) {
    rest = packExactRest(asset, exactStrandsOf(frame.groom, frame.inputs.rest), sets,
                         &memory_.limpGuides);
  } else {
    Result<std::vector<Float4>> packed = packRest(asset);
    PELAGE_ASSERT(packed, "addHair() takes processed assets only");
    rest = std::move(*packed);
    if (sets.factors) {
      const std::vector<Float4> factors = packClassicFactors(asset, sets);
      rest.insert(rest.end(), factors.begin(), factors.end());
    }
  }
  frame.buffers.rest = frame.factory.share(frame.name, "rest", kVector, bytesOf(rest));
}

ContactStrands StrandSolver::strandsOf(const HairFrame& frame) {
  ContactStrands strands;
  if (frame.settings.solver == Solver::kExact) {
    const ExactStrands exact = exactStrandsOf(frame.groom, frame.inputs.rest);
    strands.stateStride = exact.stateStride;
    for (const ExactStrand& s : exact.strands)
      strands.strands.push_back(
          {.target = s.target, .count = s.count, .root = s.root, .state = s.state});
    return strands;
  }
  for (uint32_t guide = 0; guide < frame.guideCount; ++guide)
    strands.strands.push_back({.target = guide * frame.vertexCount,
                               .count = frame.vertexCount,
                               .root = guide,
                               .state = 0});
  return strands;
}

Result<void> StrandSolver::record(HairFrame& frame, const StepInputs& inputs) {
  Result<void> added = frame.settings.solver == Solver::kExact
                           ? exact_.record(frame, inputs, memory_)
                           : classic_.record(frame, inputs, memory_);
  if (!added) return added;
  keepFrame(frame);
  memory_.loadShareBefore = frame.loadShare;
  return {};
}

Result<void> StrandSolver::skin(HairFrame& frame) {
  Result<void> added = frame.settings.solver == Solver::kExact ? exact_.skin(frame, memory_)
                                                               : classic_.skin(frame, memory_);
  if (added) keepFrame(frame);
  return added;
}

void StrandSolver::keepFrame(const HairFrame& frame) {
  memory_.lastFrame = frame.length;
  memory_.settingsBefore = frame.settings;
  memory_.restVersionBefore = memory_.restVersion;
  memory_.followsShifted = false;
}

std::vector<MovedElements> StrandSolver::moved(const HairFrame& frame) const {
  using namespace move_rigidly;
  const HairBuffers& buffers = frame.buffers;
  const uint64_t guides = frame.guideCount, vertices = frame.guideVertices();
  const uint64_t stored = frame.groom.storesFollowHairs ? frame.followCount : 0;
  std::vector<MovedElements> all = {
      {buffers.state, rootOffset_ / kVector, rootBytes_ / kVector, 1, {kMovesFrame, kMovesPoint}},
      {buffers.tangents, 0, (guides + stored) * frame.vertexCount, 1, {kMovesDirection}}};
  if (solver_ == Solver::kClassic) {
    all.push_back({buffers.state, 0, 2 * vertices, 1, {kMovesPoint}});
    return all;
  }
  const uint64_t set = exact_.stateStride();
  static_assert(exact::kStateSets == 2 * exact::kStateSlots && exact::kStrandElements == 5);
  all.push_back({buffers.state,
                 0,
                 exact::kStateSets * set,
                 exact::kStateSlots * set,
                 {kMovesDirection, kMovesFrame}});
  // A rotation by which states were transported rotates as its axis does.
  all.push_back({buffers.state,
                 exact::kStateSets * set,
                 exact::kStateSlots * exact::kStrandElements * guides,
                 guides,
                 {kMovesDirection, kMovesPoint, kMovesPoint, kMovesDirection, kMovesDirection}});
  return all;
}

Result<void> StrandSolver::rewritePositions(const HairFrame& frame) const {
  return solver_ == Solver::kExact ? exact_.rewritePositions(frame, memory_)
                                   : ClassicSolver::rewritePositions(frame);
}

}  // namespace pelage::detail
