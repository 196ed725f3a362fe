// The collision of stored follow hairs: finds the contacts of their vertices with colliders, and
// moves them out.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "contact/hair_contacts.h"
#include "pelage/gpu_structs.h"
#include "pelage/pass_list.h"
#include "pelage/result.h"

namespace pelage::detail {

/// Follow hairs of an object, stored after its guides.
struct FollowHairs {
  BufferId positions = BufferId::kInvalid;  ///< [strand][vertex] Float4 in world space
  BufferId tangents = BufferId::kInvalid;   ///< as many
  uint32_t first = 0;                       ///< strand
  Float3 origin;                            ///< of the colliders [m]
  /// Groups of update_follow_hairs for an indirect dispatch; kInvalid: all strands are awake.
  BufferId awake = BufferId::kInvalid;
  uint64_t argumentBytes = 0;  ///< offset of these in `awake`
};

/// The contacts of one hair object.
class FollowContacts {
 public:
  /// Creates the buffers. The caller has removed earlier ones.
  void prepare(ResourceTable& resources, const std::string& name, uint32_t strands,
               uint32_t verticesPerStrand);
  bool isPrepared() const { return words_ != BufferId::kInvalid; }
  /// Adds the passes of a frame: find and walk, then both once more for the marked strands. \param
  /// known buffers have positions of the last frame
  Result<void> add(PassList& list, const ResourceTable& resources, const FollowHairs& hairs,
                   const ColliderBuffers& colliders, bool known);
  void remove(const RoomBuffers& room) {
    for (BufferId* buffer : {&before_, &contacts_, &words_}) room.remove(*buffer);
  }

  /// The last frame has collided: before() is of its end.
  bool goesOn() const { return goesOn_; }
  void forget() { goesOn_ = false; }
  BufferId before() const { return before_; }
  uint64_t beforeCount() const { return 2 * vertices(); }  ///< elements of it
  BufferId words() const { return words_; }
  /// What a rigid motion of the object moves.
  std::vector<MovedElements> moved() const {
    if (!goesOn_) return {};
    return {{before_, 0, beforeCount(), 1, {move_rigidly::kMovesPoint}, true}};
  }

 private:
  uint64_t vertices() const { return uint64_t{strands_} * vertices_; }
  uint64_t beforeBytes() const { return 2 * vertices() * sizeof(Float4); }
  uint64_t contactBytes() const { return 2 * vertices() * sizeof(FollowContact); }
  uint64_t wordBytes() const;
  uint32_t tiles() const;
  uint32_t rows() const;
  Result<void> addPass(PassList& list, const ResourceTable& resources, const KernelVariant& variant,
                       const FollowHairs& hairs, const ColliderBuffers& colliders,
                       const FollowCollisionConstants& constants) const;

  BufferId before_ = BufferId::kInvalid, contacts_ = BufferId::kInvalid,
           words_ = BufferId::kInvalid;
  bool goesOn_ = false;
  uint32_t strands_ = 0, vertices_ = 0;  ///< follow hairs; vertices each
};

}  // namespace pelage::detail
