// The passes of the exact solver, on buffers of a test's own.
#pragma once

#include <algorithm>
#include <cstdint>
#include <optional>
#include <vector>

#include "pelage/constants.h"
#include "pelage/gpu_structs.h"
#include "pelage/kernels.h"
#include "support/contact_pass.h"
#include "support/gpu_fixture.h"

namespace pelage::test {

/// The state that strands start with.
struct ExactData {
  std::vector<ExactStrand> strands;  ///< in tiles of 32
  std::vector<Float4> state, rest, roots;
  uint32_t stride = 0, strandRecords = 0, outputs = 0;
};

/// Features of a sub-step, which choose its kernels.
struct ExactKey {
  bool globalShape = false;
  bool contacts = false;
  bool velocityShockPropagation = false;  ///< always with contacts
  bool forces = false;
  bool blocks = false;  ///< with contacts: several lanes a strand
};

class ExactPass {
 public:
  static constexpr uint32_t kReset = 1, kAgain = 128, kPose = 256;  // of ExactConstants::flags

  /// \param subSteps  at most, of a frame
  ExactPass(Gpu& gpu, const ExactKey& key, const ExactData& data, uint32_t subSteps = 1)
      : positions(gpu, "positions", std::vector<Float4>(data.outputs)),
        tangents(gpu, "tangents", std::vector<Float4>(data.outputs)),
        state(gpu, "state", data.state),
        rest(gpu, "rest", data.rest),
        roots(gpu, "rootFrames", data.roots),
        gpu_(gpu),
        key_(key),
        sleep_(gpu, "sleep",
               std::vector<uint32_t>(exact::kSleepHead + 2 * ((data.strands.size() + 31) / 32) +
                                     data.strands.size())) {
    constants.strandCount = static_cast<uint32_t>(data.strands.size());
    constants.simulatedCount = constants.fadeStart = constants.rootCount = constants.strandCount;
    constants.stateStride = data.stride;
    constants.strandRecords = data.strandRecords;
    constants.outputCount = data.outputs;
    if (key.contacts) addContacts(data, subSteps);
    expectOk(gpu.device()->update(gpu.resources));
  }

  ExactConstants constants = {};
  GuardedBuffer<Float4> positions, tangents, state, rest, roots;
  std::optional<ContactPass> contacts;

  /// Once before the first sub-step of a frame.
  void begin(PassList& list) {
    if (contacts) contacts->begin(list);
  }
  /// The passes of a sub-step, as scenes have them: the pose of a reset, contacts, the step, and
  /// again where a vertex has ended far from where its contact was found.
  void solve(PassList& list, detail::ContactStep step) {
    if (!contacts) {
      addStrandPass(list,
                    simulateExactVariant({.globalShape = key_.globalShape,
                                          .velocityShockPropagation = key_.velocityShockPropagation,
                                          .forces = key_.forces}),
                    constants);
      return;
    }
    constants.contactHead = contacts->contacts().layout().head(step.index);
    const detail::ContactHair hair = {.positions = positions.id(),
                                      .roots = gpu_.resources.whole(roots.id()),
                                      .rootCount = constants.rootCount,
                                      .strands = constants.simulatedCount,
                                      .origin = {}};
    const auto eliminate = [&](bool blocks) -> const KernelVariant& {
      return eliminateStrandsVariant(
          {.blocks = blocks, .globalShape = key_.globalShape, .forces = key_.forces});
    };
    ExactConstants values = constants;
    if (key_.blocks) values.flags |= exact::kNarrowFlag;
    const uint32_t flags = values.flags;
    values.flags |= kPose;
    if ((constants.flags & kReset) != 0) addStrandPass(list, eliminate(key_.blocks), values);
    values.flags = flags;
    for (const bool again : {false, true}) {
      const bool blocks = key_.blocks || again;
      if (again) values.flags |= kAgain;
      step.again = again;
      contacts->find(list, hair, step);
      addStrandPass(list, eliminate(blocks), values);
      PassBuilder builder(list);
      builder.dispatchIndirect(solveContactsVariant({}), contacts->contacts().words(),
                               listArguments(again ? contact_records::kContactSolveArguments
                                                   : contact_records::kContactGroupArguments));
      finish(builder, values);
      addStrandPass(list, rollOutStrandsVariant({.blocks = blocks}), values);
    }
  }
  /// Fails when a pattern behind a buffer was written to.
  void checkGuards() const {
    for (const auto* buffer : {&positions, &tangents, &state, &rest, &roots}) (void)buffer->read();
    if (contacts) contacts->checkGuards();
    (void)sleep_.read();
  }

 private:
  void addContacts(const ExactData& data, uint32_t subSteps) {
    detail::ContactStrands strands = {.strands = {}, .stateStride = data.stride};
    uint32_t most = 0;
    for (const ExactStrand& s : data.strands) {
      strands.strands.push_back(
          {.target = s.target, .count = s.count, .root = s.root, .state = s.state});
      most = std::max(most, s.count);
    }
    contacts.emplace(gpu_, strands, most, uint64_t{data.outputs}, subSteps);
    const detail::ContactLayout& found = contacts->contacts().layout();
    constants.contactList = found.list();
    constants.contactMasks = found.masks();
    constants.contactMaskWords = found.maskWords;
  }
  uint64_t listArguments(uint32_t arguments) const {
    return (uint64_t{constants.contactHead} + arguments) * sizeof(uint32_t);
  }
  void addStrandPass(PassList& list, const KernelVariant& variant, const ExactConstants& values) {
    PassBuilder builder(list);
    if ((values.flags & kAgain) != 0)
      builder.dispatchIndirect(variant, contacts->contacts().words(),
                               listArguments(contact_records::kContactStrandArguments));
    else if ((values.flags & exact::kNarrowFlag) != 0)
      builder.dispatch(variant, (constants.strandCount + exact::kNarrowStrands - 1) /
                                    exact::kNarrowStrands * variant.groupSize[0]);
    else
      builder.dispatch(variant, constants.strandCount);
    finish(builder, values);
  }
  void finish(PassBuilder& builder, const ExactConstants& values) {
    positions.bindTo(builder, "g_positions");
    tangents.bindTo(builder, "g_tangents");
    state.bindTo(builder, "g_state");
    rest.bindTo(builder, "g_rest");
    sleep_.bindTo(builder, "g_sleep");
    if (contacts) contacts->bindTo(builder);
    builder.constants("ExactConstants", values);
    expectOk(builder.finish());
  }

  Gpu& gpu_;
  ExactKey key_;
  GuardedBuffer<uint32_t> sleep_;
};

}  // namespace pelage::test
