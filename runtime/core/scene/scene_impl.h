// What a scene holds: its objects, the frames that may turn out not to run, and the rooms.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "pelage/scene.h"
#include "scene/hair_internals.h"
#include "scene/scene_delivery.h"
#include "scene/scene_draw.h"
#include "sdf/sdf_room.h"
#include "simulation/hair_frame.h"
#include "skinning/skeleton_pose.h"

namespace pelage::detail {

struct HairSnapshot;

/// The functions of Scene, and what they share. Scene has their documentation.
class SceneImpl {
 public:
  Result<HairId> addHair(std::shared_ptr<const HairAsset> shared, const HairDef& def);
  Result<void> removeHair(HairId id);
  HairObject& hair(HairId id);
  const HairObject& hair(HairId id) const;
  bool isValid(HairId id) const { return objects_.find(id) != nullptr; }
  bool isValid(ColliderId id) const { return sdfs_.colliders.find(id) != nullptr; }
  bool isValid(SkeletonId id) const { return skeletons_.find(id) != nullptr; }
  uint32_t hairCount() const;
  Result<ColliderId> addCollider(const CollisionMesh& mesh, const SdfColliderDef& def);
  Result<ColliderId> addCollider(const SdfData& data, const SdfColliderDef& def);
  Result<ColliderId> addCollider(const DenseSdf& sdf, const SdfColliderDef& def);
  Result<void> removeCollider(ColliderId id);
  SdfCollider& collider(ColliderId id);
  const SdfCollider& collider(ColliderId id) const;
  Result<SkeletonId> addSkeleton(const SkeletonDef& def);
  Result<void> removeSkeleton(SkeletonId id);
  SkeletonPose& skeleton(SkeletonId id);
  const SkeletonPose& skeleton(SkeletonId id) const;
  void trim();
  Result<SdfData> copySdf(ColliderId id, std::span<const std::byte> keys,
                          std::span<const std::byte> surface) const;
  BufferId sdfKeys() const { return sdfs_.keys; }
  BufferId sdfSurface() const { return sdfs_.surface; }
  ResourceTable& resources() { return resources_; }
  const ResourceTable& resources() const { return resources_; }
  ObjectBytes objectBytes(HairId id);
  ObjectBytes objectBytes(ColliderId id);
  DrawBytes drawBytes() const;
  Result<void> simulate(float dt, PassList& list);
  Result<void> draw(const View& view, const Light& light, PassList& list);
  Result<void> draw(const View& view, std::span<const Light> lights,
                    const TransparencySettings& settings, std::vector<PassList>& lists);
  Result<void> interpolate(float share, PassList& list);
  Result<void> drawDepth(const View& view, const HairDepthSettings& settings, PassList& list);
  float shareForView(HairId id, const View& view, float pixels) const;
  TransparencyWork predictWork(const View& view) const;
  Result<uint32_t> castShadows(std::span<const Light> lights, PassList& list);
  void setShadowMemory(uint64_t maxBytes);
  void setTier(Tier tier);
  void setLevels(bool on) { hazards_.setLevels(on); }
  BufferId shadowWords() const;
  BufferId shadowViews() const;
  BufferId transparencyCounters() const;
  TransparencyTiles transparencyTiles() const;
  Result<void> drawCollider(ColliderId id, const View& view, const Light& light,
                            const ColliderLook& look, PassList& list);
  Result<void> checkColliderDraw(ColliderId id, std::span<const std::byte> counts) const;
  Result<void> drawContacts(HairId id, const View& view, const ContactLook& look, PassList& list);
  Result<float> deepestContact(HairId id, std::span<const std::byte> contacts,
                               std::span<const std::byte> contactWords,
                               std::span<const std::byte> positions) const;
  void finish(PassList& list);
  void abandon(const PassList& list);
  Result<void> shiftOrigin(Float3 shift);
  Result<void> teleport(HairId id, const AffineTransform& motion);
  Result<std::shared_ptr<const SnapshotData>> takeSnapshot(const BufferReader& read);
  /// \param snapshot nullptr: none
  Result<uint32_t> recover(const SnapshotData* snapshot);
  double time() const { return time_; }

  DrawRooms& rooms() { return draws_; }

 private:
  /// \param owner  of what is removed: a hair object or a collider; nullptr: the scene
  RoomBuffers room(const void* owner = nullptr) {
    return {resources_, hazards_, frames_.recording ? &frames_.open.back().removed : nullptr, owner,
            &shared_};
  }
  Vector3<double> shifted() const { return {shifted_[0], shifted_[1], shifted_[2]}; }

  // Frames that may turn out not to run: scene_delivery.cpp.
  void settleFrames(bool boundary);
  void saveFrame();
  void restoreFrame();
  void commitFrames();
  void forgetOwner(const void* owner);
  void removeOf(FrameCheckpoint& frame, const void* owner);
  void relayFrames();
  /// \param kept  objects that are not to be reset
  void sendEverything(std::span<HairObject* const> kept = {});
  std::vector<BufferId> ownBuffers(const HairObject& object);
  bool hasBuffersOf(const HairObject& object, const HairSnapshot& saved);
  void restoreHair(HairInternals& hair, const HairFrameState& state,
                   const Vector3<double>& shifted);

  // Objects.
  static void removeHairBuffers(HairBuffers& buffers, HairFrameState& state, bool hasSkeleton,
                                const RoomBuffers& room);
  void addHairBuffers(HairObject& object, const HairAsset& asset, const HairDef& def);
  Result<void> checkSkeletons() const;
  void followSkeletons();
  Result<SkeletonPose*> findSkeleton(SkeletonId id, uint32_t boneCount) const;
  void removeUnusedCopies();
  void collectShared();
  void removeDrawBuffers(const char* reason);

  // Simulation.
  Result<void> checkObject(const HairObject& object) const;
  /// Whether a solver moves it.
  static bool isSimulated(const HairObject& object);
  std::optional<HairReach> reachOf(const HairObject& object) const;
  Result<void> simulateFrame(float length, uint32_t steps, PassList& list);
  HairFrame frameOf(HairObject& object, const SimulationSettings& settings, float length,
                    uint32_t steps, PassList& list);
  static FieldHair fieldHairOf(const HairFrame& frame, const HairInternals& hair);
  static BufferId forcesOf(const HairFrame& frame, const HairInternals& hair);
  static GridHair gridHairOf(const HairFrame& frame, const HairInternals& hair);
  static MotionHair motionHairOf(const HairFrame& frame, const HairInternals& hair,
                                 uint64_t shifted);
  /// Whether the hair counts as not having moved in the frame: after resets and teleports.
  static bool startsStill(const HairFrame& frame, const HairInternals& hair) {
    return frame.reset || hair.teleport.has_value();
  }
  // What was before a frame, for motion vectors and interpolation: scene_interpolation.cpp.
  static InterpolatedHair interpolatedHairOf(const HairFrame& frame, const HairInternals& hair,
                                             const MotionHair& positions);
  static void prepareBefore(const HairObject& object, HairFrame& frame, const MotionHair& motion);
  /// \param placed  elements, from the first, that are where a pending teleport brings them
  static Result<void> keepBefore(HairInternals& hair, const HairFrame& frame,
                                 const MotionHair& motion, uint64_t placed);
  Result<void> keepBehind(const HairObject& object, const HairFrame& frame,
                          const MotionHair& motion) const;
  Result<void> interpolateObject(HairObject& object, float share, PassList& list);

  Result<void> simulateObject(HairObject& object, float length, uint32_t steps, PassList& list);
  static float blendOf(HairObject& object, float length);
  Result<void> skinObject(HairObject& object, HairFrame& frame);
  Result<void> beginBones(HairObject& object, HairFrame& frame) const;
  Result<void> sendBones(HairObject& object, PassList& list) const;
  void sendSdfs(HairObject& object, HairFrame& frame);
  static void sendCapsules(HairObject& object, HairFrame& frame);
  Result<void> poseNewHair(PassList& list);
  Result<void> poseObject(HairObject& object, PassList& list);

  // Shifts of the world, and teleports.
  static Result<void> addTeleport(const HairFrame& frame, const HairInternals& hair);
  Result<void> addPendingShifts(PassList& list);
  void shiftFrames(const Vector3<double>& by);
  void finishShift();
  static Result<void> addShiftPasses(const HairFrame& frame, HairInternals& hair);
  static Result<void> addFollowShift(const HairFrame& frame, const HairInternals& hair);
  Result<void> addMotionShift(const HairFrame& frame, const HairInternals& hair) const;
  static Result<void> addInterpolationShift(const HairFrame& frame, const HairInternals& hair);

  // Drawing.
  static Result<void> checkLook(const HairObject& object);
  /// \param list  that the view is drawn into, behind what it has
  Result<DrawnView> beginDraw(const View& view, std::span<const Light> lights,
                              const PassList* list = nullptr) const;
  Result<ShadowCast> checkShadows(std::span<const Light> lights, bool draws);
  Result<void> checkOpaques(std::span<const Light> lights, ShadowCast& cast) const;
  Result<void> addShadows(ShadowCast& cast, DrawnView& frame, PassList& list);

  ResourceTable resources_;
  HazardTracker hazards_;
  SharedTables shared_;
  Slots<HairId, HairObject> objects_;
  Slots<SkeletonId, SkeletonPose> skeletons_;
  SdfRoom sdfs_;
  DrawRooms draws_;
  double time_ = 0;
  std::array<double, 3> shifted_ = {};  ///< sum of all shifts [m]
  SceneFrames frames_;
};

}  // namespace pelage::detail
