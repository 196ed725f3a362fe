// The colliders of a hair object: the SDFs and capsules in reach, and the contacts with them.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <vector>

#include "base/bounds.h"
#include "base/rigid_move.h"
#include "contact/hair_contacts.h"
#include "passes/buffer_factory.h"
#include "passes/moved_elements.h"
#include "pelage/collider.h"
#include "pelage/host_allocator.h"
#include "pelage/result.h"
#include "sdf/sdf_room.h"
#include "skinning/hair_frame.h"

namespace pelage::detail {

/// The colliders of one object. A copy of it is what a frame is taken back to.
class HairColliders {
 public:
  /// Strands in the order of the solver.
  using Strands = std::function<ContactStrands()>;

  /// Removes contacts that were made for another solver.
  void prepare(HairFrame& frame);
  /// Sub-steps that a frame of so many steps needs: SimulationSettings::maxSubSteps.
  /// \param bonesBefore  of the last frame; empty: not known
  /// \param sdfs  that the hair collides with; nullptr: none
  uint32_t subSteps(const HairInputs& inputs, std::span<const AffineTransform> bonesBefore,
                    const SimulationSettings& settings, const Ball& ball, const SdfRoom* sdfs,
                    uint32_t steps) const;
  /// Sends what strands in a ball can reach, and begins the contacts of the frame.
  void record(HairFrame& frame, SdfRoom& sdfs, const Ball& ball, const Strands& strands);
  /// Adds the pass that finds the contacts of a sub-step.
  Result<void> find(const HairFrame& frame, const ContactPart& part);
  /// In a frame without collisions: contacts of later frames have no history.
  void pause(HairFrame& frame);
  /// The next frame sends the SDFs again.
  void forget() { sdfsBefore_.clear(); }
  void move(const WorldMove& move);
  std::vector<MovedElements> moved(const HairFrame&) const { return contacts_.moved(); }
  void remove(HairBuffers& buffers, const BufferFactory& factory);

  HairContacts& contacts() { return contacts_; }
  const HairContacts& contacts() const { return contacts_; }
  const ColliderBuffers& inReach() const { return inReach_; }

 private:
  bool sendSdfs(HairFrame& frame, SdfRoom& sdfs, const Ball& ball);
  bool sendCapsules(HairFrame& frame, const Ball& ball);
  void beginContacts(HairFrame& frame, const Strands& strands);
  ContactInputs inputs() const;

  HairContacts contacts_;
  ColliderBuffers inReach_;                    ///< of the last frame
  HostArray<CapsuleCollider> capsulesBefore_;  ///< of the last frame
  HostArray<std::byte> sdfsBefore_;            ///< contents of their buffer
  uint32_t capsuleCapacity_ = 0;               ///< elements of the buffer
  uint32_t sdfCapacity_ = 0;                   ///< likewise
  /// Extent of moves since the last frame [m]; bounds the rounding of capsules that an engine sends
  /// again.
  double rounded_ = 0;
};

}  // namespace pelage::detail
