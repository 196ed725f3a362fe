// Checkpoints of frames that may turn out not to run.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <span>

#include "passes/buffer_factory.h"
#include "passes/list_run.h"
#include "pelage/scene.h"
#include "scene/hair_internals.h"
#include "scene/hair_store.h"
#include "sdf/sdf_collider.h"
#include "skinning/skeleton_pose.h"

namespace pelage::detail {

struct HairCheckpoint {
  HairObject* object = nullptr;
  HairFrameState state;
  HairOutputs buffers;
};

struct ColliderCheckpoint {
  SdfCollider* collider = nullptr;
  SdfFrameState state;
  SdfOutputs buffers;
};

struct SkeletonCheckpoint {
  SkeletonPose* skeleton = nullptr;
  LocalOrigin origin;
  bool originKnown = false;
  std::array<SkeletonInternals::Copy, 2> copies;
};

/// The host's data as they were before a frame. A frame that does not run changes nothing on the
/// GPU, so going back to these is enough.
struct FrameCheckpoint {
  uint64_t number = 0;  ///< PassList::frame
  double time = 0;
  BufferId sdfKeys = BufferId::kInvalid, sdfSurface = BufferId::kInvalid;
  HostArray<HairCheckpoint> hairs;
  HostArray<ColliderCheckpoint> colliders;
  HostArray<SkeletonCheckpoint> skeletons;

  /// Versions of the table before and after the frame: it owns the buffers added in between.
  uint64_t firstVersion = 0, lastVersion = 0;
  /// Buffers that it has no use for any more. They go once it has run.
  HostArray<RemovedBuffer> removed;

  std::shared_ptr<RunRecord> run;  ///< of its list; nullptr before Scene::finish()
  bool abandoned = false;
};

/// Keeps a checkpoint of each frame until the frame has run, and goes back to it where the frame
/// does not run.
class FrameJournal {
 public:
  /// Changes of the scene that a list makes. Without keep() they are taken back.
  class Recording {
   public:
    /// Saves a checkpoint; a list that has one keeps its own.
    Recording(FrameJournal& journal, PassList& list);
    ~Recording();
    void keep() { kept_ = true; }

   private:
    FrameJournal& journal_;
    PassList& list_;
    bool kept_ = false;
  };

  explicit FrameJournal(HairStore& store) : store_(store) {}
  void finish(PassList& list);
  void abandon(const PassList& list);
  /// Finds out which open frames have run, and takes back the lost ones.
  /// \param boundary  a frame begins: lists that are not recorded by now never are
  void settle(bool boundary);
  /// Lets go of the frames that have run.
  void commit();
  void takeBackAll();
  /// Sends everything again to a GPU that may have lost it. \param kept  objects without a reset
  void resetAll(std::span<HairObject* const> kept = {});
  /// Call it before an object is removed.
  void forgetOwner(const void* owner);
  /// Call it when the SDFs have got other offsets between two frames.
  void relayFrames();
  /// Removes tables that no object has, and no open frame.
  void collectShared();
  bool isLast(const PassList& list) const {
    return !open_.empty() && open_.back().number == list.frame;
  }
  bool allHaveRun() const;
  /// All open frames, which go back to what is in them.
  std::span<FrameCheckpoint> open() { return open_; }

 private:
  void save();
  void restore();
  void removeOf(FrameCheckpoint& frame, const void* owner);

  HairStore& store_;
  HostArray<FrameCheckpoint> open_;   ///< from the oldest one on; each was written on top of it
  HostArray<FrameCheckpoint> spare_;  ///< for their memory
};

}  // namespace pelage::detail
