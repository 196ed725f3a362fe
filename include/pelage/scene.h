// A scene: hair objects and the pass lists that move and draw them.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "pelage/hair_object.h"
#include "pelage/pass_list.h"
#include "pelage/result.h"
#include "pelage/sdf_collider.h"
#include "pelage/sdf_data.h"
#include "pelage/view.h"

namespace pelage {

struct ExactConstants;
namespace detail {
struct SdfGridPlan;
}

/// A hair object of a scene.
enum class HairId : uint32_t { kInvalid = 0xffffffffu };

/// Holds hair objects and writes their pass lists. No graphics API: a runtime creates the buffers
/// of resources() and runs the lists, in the order in which they were made.
///
///     Scene scene;
///     auto hair = scene.addHair(asset, {.name = "groom"});
///     ...
///     scene.hair(*hair).setBones(bones);
///     scene.simulate(1.0f / 60, list);  // then the runtime runs the list
class Scene {
 public:
  /// Adds a hair object. Errors: an asset without strands, settings out of range, a follow hair of
  /// a guide that does not exist, bone weights of another groom.
  Result<HairId> addHair(const HairAsset& asset, const HairDef& def);
  /// Removes a hair object and its buffers.
  void removeHair(HairId id);
  /// Asserts that the object exists.
  HairObject& hair(HairId id);
  const HairObject& hair(HairId id) const;
  uint32_t hairCount() const;

  /// Adds a mesh that all hair collides with, through a signed distance field. It is built before
  /// the hair moves, in the frames in which hair can reach it and it has moved: what moved alone,
  /// or all of it. Open meshes and meshes with overlaps are taken, see SdfCollider::report().
  /// Errors: no bones, settings out of range, indices of vertices or bones that do not exist, a
  /// field over the memory cap, a vertex buffer that is too small.
  Result<ColliderId> addCollider(const CollisionMesh& mesh, const SdfColliderDef& def);
  /// The same with a field that was built before; it never moves. Errors: settings out of range.
  Result<ColliderId> addCollider(const SdfData& data, const SdfColliderDef& def);
  void removeCollider(ColliderId id);
  /// Asserts that the collider exists.
  SdfCollider& collider(ColliderId id);
  const SdfCollider& collider(ColliderId id) const;
  /// What the last build of a collider left in sdfKeys() and sdfSurface(), read back, as data that
  /// can be saved. Error: there was no build since it got its place there, or the buffers are not
  /// the scene's.
  Result<SdfData> copyField(ColliderId id, std::span<const std::byte> keys,
                            std::span<const std::byte> surface) const;
  /// Keys and records of all colliders; kInvalid without any.
  BufferId sdfKeys() const { return sdfKeys_; }
  BufferId sdfSurface() const { return sdfSurface_; }

  /// The buffers that a runtime is to create before it runs the next list. Add buffers of your own
  /// to use them in passes beside the scene's.
  ResourceTable& resources() { return resources_; }
  const ResourceTable& resources() const { return resources_; }

  /// Writes the passes that advance every hair object by dt.
  /// \param dt seconds, >= 0. 0 skips the simulation. Steps are at most 1/60 s: a longer dt is cut
  ///   into equal sub-steps, at most kMaxSubSteps of them; time beyond that is dropped. The exact
  ///   solver cuts each of them further into SimulationSettings::subSteps.
  /// \param list cleared first.
  /// Errors: dt or a setting is out of range; a share without HairDef::levelOfDetail; a buffer of
  /// setForces() that is too small; an object with too many strands for one dispatch. After one of
  /// the first three nothing has changed: bones and resets wait for the next frame.
  Result<void> simulate(float dt, PassList& list);
  /// Adds draws of all visible hair objects to a list (which is not cleared).
  Result<void> draw(const View& view, const Light& light, PassList& list);
  /// Adds the passes and the draw that show a collider as its field has it, for debugging: the
  /// surface where the distance is the look's level. Draws nothing before the first simulation.
  /// Errors: a grid that is too large for it.
  Result<void> drawCollider(ColliderId id, const View& view, const Light& light,
                            const ColliderLook& look, PassList& list);
  /// Whether the last drawCollider() that ran drew all of it. \param counts what
  /// SdfColliderBuffers::isoCounts holds, read back. Error: the surface is larger than what there
  /// is room for, and incomplete.
  Result<void> checkColliderDraw(ColliderId id, std::span<const std::byte> counts) const;
  /// Computes the barriers of a list that is complete. Call it once for each list, in the order in
  /// which the lists run; lists of your own that touch the scene's buffers included.
  void finish(PassList& list) { hazards_.resolve(list); }

  /// Seconds simulated so far; the phase of the wind.
  double time() const { return time_; }

  static constexpr uint32_t kMaxSubSteps = 4;

 private:
  struct Frame;
  void addSolverBuffers(HairObject& object);
  void removeSolverBuffers(HairObject& object);
  void removeBuffer(BufferId& buffer);
  Result<void> checkObject(const HairObject& object) const;
  Result<std::vector<std::optional<detail::SdfGridPlan>>> checkColliders() const;
  bool planCollider(SdfCollider& collider, const detail::SdfGridPlan& plan);
  void addColliderBuffers(SdfCollider& collider);
  void layOutFields();
  void removeIsoSurface(SdfCollider& collider);
  bool isReached(const SdfCollider& collider) const;
  Result<void> buildCollider(SdfCollider& collider, PassList& list);
  Result<void> addSkinningPass(SdfCollider& collider, PassList& list);
  void addFields(Frame& frame);
  uint64_t bytesOfBuffer(BufferId id) const;
  Result<void> simulateObject(HairObject& object, float length, uint32_t steps, PassList& list);
  Result<void> addRootPass(const Frame& frame);
  Result<void> addClassicPasses(const Frame& frame);
  Result<void> addExactPasses(Frame& frame);
  Result<void> addSleepPass(Frame& frame, ExactConstants constants);
  void setLevelOfDetail(const Frame& frame, ExactConstants& constants);
  Result<void> addInterpolationPass(const Frame& frame, const ExactConstants& constants,
                                    uint32_t strands);
  void bindExact(const Frame& frame, PassBuilder& builder) const;
  Result<void> addFollowPass(const Frame& frame);
  void addHairGrid(HairObject& object);
  void removeHairGrid(HairObject& object);
  Result<void> addHairGridPasses(HairObject& object, double h, bool reset, PassList& list);
  void finishHairGrid(HairObject& object, double frame);
  BufferId forcesOf(const HairObject& object) const;

  ResourceTable resources_;
  HazardTracker hazards_;
  std::vector<std::unique_ptr<HairObject>> objects_;
  std::vector<std::unique_ptr<SdfCollider>> colliders_;
  BufferId sdfKeys_ = BufferId::kInvalid, sdfSurface_ = BufferId::kInvalid;
  double time_ = 0;
};

}  // namespace pelage
