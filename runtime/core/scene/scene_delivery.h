// What a scene keeps of frames that may turn out not to run.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <vector>

#include "passes/list_run.h"
#include "passes/room_buffers.h"
#include "pelage/scene.h"
#include "scene/hair_internals.h"
#include "sdf/sdf_collider.h"
#include "skinning/skeleton_pose.h"

namespace pelage::detail {

struct HairCheckpoint {
  HairObject* object = nullptr;
  HairFrameState state;
  HairBuffers buffers;
};

struct ColliderCheckpoint {
  SdfCollider* collider = nullptr;
  SdfFrameState state;
  SdfColliderBuffers buffers;
};

struct SkeletonCheckpoint {
  SkeletonPose* skeleton = nullptr;
  LocalOrigin origin;
  bool originKnown = false;
  std::array<SkeletonInternals::Copy, 2> copies;
};

/// What a frame changes on the host, as it was before it. On the GPU a frame that does not run
/// changes nothing, so with this everything is as it was.
struct FrameCheckpoint {
  uint64_t number = 0;  ///< PassList::frame
  double time = 0;
  BufferId sdfKeys = BufferId::kInvalid, sdfSurface = BufferId::kInvalid;
  HostArray<HairCheckpoint> hairs;
  HostArray<ColliderCheckpoint> colliders;
  HostArray<SkeletonCheckpoint> skeletons;

  /// Of the table, before the frame and after it: buffers that were added in between are its own.
  uint64_t firstVersion = 0, lastVersion = 0;
  /// Buffers that it has no use for any more. They go once it has run.
  HostArray<RemovedBuffer> removed;

  std::shared_ptr<RunRecord> run;  ///< of its list; nullptr before Scene::finish()
  bool abandoned = false;
};

struct SceneFrames {
  HostArray<FrameCheckpoint> open;   ///< from the oldest one on; each was written on top of it
  HostArray<FrameCheckpoint> spare;  ///< for their memory
  bool recording = false;            ///< simulate() is at work on the last one
};

/// Lets the next frame upload what an object has on the GPU beside its strands' state.
void sendAgain(HairInternals& hair);
void sendAgain(SdfColliderInternals& collider);

}  // namespace pelage::detail
