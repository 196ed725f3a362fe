// The collision of stored follow hairs: finds the contacts of their vertices with colliders, and
// moves them out.
#pragma once

#include <cstdint>
#include <vector>

#include "contact/hair_contacts.h"
#include "pelage/gpu_structs.h"
#include "pelage/pass_list.h"
#include "pelage/result.h"
#include "skinning/hair_frame.h"

namespace pelage::detail {

/// The contacts of one hair object.
class FollowContacts {
 public:
  /// Adds the passes of a frame: find and walk, then both once more for the marked strands.
  Result<void> record(HairFrame& frame, const ColliderBuffers& colliders);
  void pause(HairFrame&) { goesOn_ = false; }
  void lose(HairBuffers&, const BufferFactory&) { goesOn_ = false; }
  void remove(const BufferFactory& factory) {
    for (BufferId* buffer : {&before_, &contacts_, &words_}) factory.remove(*buffer);
  }
  /// The last frame has collided: the next one goes on from where the hairs were.
  bool goesOn() const { return goesOn_; }
  std::vector<MovedElements> moved(const HairFrame&) const {
    if (!goesOn_) return {};
    return {{before_, 0, 2 * vertices(), 1, {move_rigidly::kMovesPoint}, true}};
  }

 private:
  uint64_t vertices() const { return uint64_t{strands_} * vertices_; }
  uint64_t beforeBytes() const { return 2 * vertices() * sizeof(Float4); }
  uint64_t contactBytes() const { return 2 * vertices() * sizeof(FollowContact); }
  uint64_t wordBytes() const;
  uint32_t tiles() const;
  uint32_t rows() const;
  void makeBuffers(const HairFrame& frame);
  Result<void> addPass(const HairFrame& frame, const KernelVariant& variant,
                       const ColliderBuffers& colliders,
                       const FollowCollisionConstants& constants) const;

  BufferId before_ = BufferId::kInvalid, contacts_ = BufferId::kInvalid,
           words_ = BufferId::kInvalid;
  bool goesOn_ = false;
  uint32_t strands_ = 0, vertices_ = 0;  ///< follow hairs; vertices each
};

}  // namespace pelage::detail
