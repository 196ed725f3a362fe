// The objects of a scene, and what all of them share.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <utility>

#include "base/ids.h"
#include "passes/buffer_factory.h"
#include "pelage/scene.h"
#include "scene/hair_internals.h"
#include "sdf/sdf_room.h"
#include "skinning/skeleton_pose.h"

namespace pelage::detail {

/// The objects of the slots that are not empty, as a range. (Views of std::ranges do not compile
/// with clang-tidy 14.)
template <class Id, class T>
class Objects {
 public:
  using Slot = decltype(std::declval<const Slots<Id, T>&>().begin());

  class Iterator {
   public:
    using value_type = T;
    using difference_type = std::ptrdiff_t;

    Iterator() = default;
    Iterator(Slot slot, Slot end) : slot_(slot), end_(end) { skipEmpty(); }
    T& operator*() const { return **slot_; }
    Iterator& operator++() {
      ++slot_;
      skipEmpty();
      return *this;
    }
    Iterator operator++(int) {
      const Iterator before = *this;
      ++*this;
      return before;
    }
    friend bool operator==(const Iterator& a, const Iterator& b) { return a.slot_ == b.slot_; }

   private:
    void skipEmpty() {
      while (slot_ != end_ && *slot_ == nullptr) ++slot_;
    }
    Slot slot_ = {}, end_ = {};
  };

  explicit Objects(const Slots<Id, T>& slots) : begin_(slots.begin()), end_(slots.end()) {}
  Iterator begin() const { return {begin_, end_}; }
  Iterator end() const { return {end_, end_}; }

 private:
  Slot begin_, end_;
};

/// Holds the objects of a scene by id, their buffers, and what is the same for all of them.
class HairStore {
 public:
  ResourceTable resources;
  HazardTracker hazards;
  SharedTables shared;
  Slots<HairId, HairObject> hairSlots;
  Slots<SkeletonId, SkeletonPose> skeletonSlots;
  SdfRoom sdfs;
  double time = 0;          ///< that is simulated [s]
  Vector3<double> shifted;  ///< sum of all shifts of the world [m]
  uint64_t frame = 1;       ///< simulate() begins another one
  uint64_t moves = 0;       ///< rises with each list that moves hair, or turns out not to have run
  /// Buffers that the frame which is recorded has no use for; nullptr between frames.
  HostArray<RemovedBuffer>* removed = nullptr;

  static HairInternals& of(HairObject& hair) { return *hair.internals_; }
  static const HairInternals& of(const HairObject& hair) { return *hair.internals_; }
  static SdfColliderInternals& of(SdfCollider& collider) { return *collider.internals_; }
  static SkeletonInternals& of(SkeletonPose& skeleton) { return *skeleton.internals_; }
  static HairBuffers& buffersOf(HairObject& hair) { return hair.buffers_; }
  static SdfColliderBuffers& buffersOf(SdfCollider& collider) { return collider.buffers_; }
  Objects<HairId, HairObject> hairs() const { return Objects(hairSlots); }
  Objects<SkeletonId, SkeletonPose> skeletons() const { return Objects(skeletonSlots); }
  Objects<ColliderId, SdfCollider> colliders() const { return Objects(sdfs.colliders); }
  // They assert that the object exists.
  HairObject& hair(HairId id) const;
  SkeletonPose& skeleton(SkeletonId id) const;
  SdfCollider& collider(ColliderId id) const;

  /// \param owner  of buffers that are removed: a hair object or a collider; nullptr: the scene
  BufferFactory factory(const void* owner = nullptr) {
    return {resources, hazards, removed, owner, &shared};
  }
  Result<HairId> addHair(std::shared_ptr<const HairAsset> asset, const HairDef& def);
  Result<SkeletonId> addSkeleton(const SkeletonDef& def);
  /// Errors: what follows the skeleton.
  Result<void> checkUnused(SkeletonPose& skeleton) const;
  /// The skeleton that a definition names; nullptr for bones of its own. Errors do not name the
  /// object.
  Result<SkeletonPose*> findSkeleton(SkeletonId id, uint32_t boneCount) const;
  /// Errors: bones on the GPU that an engine has got wrong, and that something follows.
  Result<void> checkSkeletons() const;
  /// Takes over the bones that have changed.
  void followSkeletons();
  /// Removes copies of bones that nothing reads any more.
  void removeUnusedCopies();
};

/// Removes all that an object has in the table.
void removeHairBuffers(HairBuffers& buffers, HairFrameState& state, bool hasSkeleton,
                       const BufferFactory& factory);

/// Lets the next frame upload what an object has on the GPU beside its strands' state.
void sendAgain(HairInternals& hair);
void sendAgain(SdfColliderInternals& collider);

}  // namespace pelage::detail
