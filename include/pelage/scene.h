// A scene: hair objects and the pass lists that move and draw them.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "pelage/hair_object.h"
#include "pelage/ids.h"
#include "pelage/pass_list.h"
#include "pelage/result.h"
#include "pelage/sdf_collider.h"
#include "pelage/sdf_data.h"
#include "pelage/skeleton_pose.h"
#include "pelage/transparency.h"
#include "pelage/view.h"

namespace pelage {

struct ExactConstants;
namespace detail {
struct BufferNeed;
struct ColliderBuffers;
struct DrawOffers;
struct FrameCheckpoint;
struct SceneFrames;
struct SdfGridPlan;
template <class T>
struct Vector3;
}  // namespace detail

/// Holds hair objects and writes their pass lists. No graphics API: a runtime creates the buffers
/// of resources() and runs the lists, in the order in which they were made.
///
///     Scene scene;
///     auto hair = scene.addHair(asset, {.name = "groom"});
///     ...
///     scene.hair(*hair).setBones(bones);
///     scene.simulate(1.0f / 60, list);  // then the runtime runs the list
///
/// Nothing is delivered until it ran. A list of simulate() that is not recorded before the next
/// simulate() never runs, and one that was recorded may still turn out not to (vulkan::Runtime::
/// submitted(), setDelivered()): the scene is then as if that frame had never been written, and the
/// next one has all that it had: uploads, bones, resets, time. Nobody has to say so; docs/scene.md.
class Scene {
 public:
  /// Adds a hair object. Errors: an asset without strands, settings out of range, a follow hair of
  /// a guide that does not exist or with an offset that is not finite, bone weights of another
  /// groom, a skeleton that does not exist or has another number of bones, more strands than one
  /// dispatch takes: 4,194,240 guides, and 2,097,120 follow hairs where these are stored.
  Result<HairId> addHair(const HairAsset& asset, const HairDef& def);
  /// Removes a hair object and its buffers; with the last one also those that draw() has made.
  /// Error: the id names no hair object of this scene.
  Result<void> removeHair(HairId id);
  /// Asserts that the object exists; where the handler of the assertion returns, the program ends.
  HairObject& hair(HairId id);
  const HairObject& hair(HairId id) const;
  /// True while the id names something of this scene.
  bool isValid(HairId id) const { return objects_.find(id) != nullptr; }
  bool isValid(ColliderId id) const { return colliders_.find(id) != nullptr; }
  bool isValid(SkeletonId id) const { return skeletons_.find(id) != nullptr; }
  uint32_t hairCount() const;

  /// Adds a mesh that hair collides with, through a signed distance field: all hair, but for what
  /// HairObject::setMeshColliders() leaves out. It is built before the hair moves, in the frames in
  /// which hair can reach it and it has moved: what moved alone, or all of it. Open meshes and
  /// meshes with overlaps are taken, see SdfCollider::report().
  /// Errors: no bones, settings out of range, indices of vertices or bones that do not exist, a
  /// field over the memory cap, a vertex buffer that is too small, a skeleton that does not exist
  /// or has another number of bones.
  Result<ColliderId> addCollider(const CollisionMesh& mesh, const SdfColliderDef& def);
  /// The same with a field that was built before; it never moves. Errors: settings out of range, a
  /// skeleton.
  Result<ColliderId> addCollider(const SdfData& data, const SdfColliderDef& def);
  /// Error: the id names no collider of this scene.
  Result<void> removeCollider(ColliderId id);
  /// As hair().
  SdfCollider& collider(ColliderId id);
  const SdfCollider& collider(ColliderId id) const;
  /// Adds bones that hair objects and colliders can follow together: HairDef::skeleton,
  /// SdfColliderDef::skeleton. They are identities until SkeletonPose::setBones(). Error: no bones.
  Result<SkeletonId> addSkeleton(const SkeletonDef& def);
  /// Errors: the id names no skeleton of this scene; something follows it, which stays as it is.
  Result<void> removeSkeleton(SkeletonId id);
  /// As hair().
  SkeletonPose& skeleton(SkeletonId id);
  const SkeletonPose& skeleton(SkeletonId id) const;

  /// Gives back what the next frame can make again: the buffers that draw() has made for all hair
  /// together (lists, layers, tiles, shadow maps), which else stay at the largest size that a view
  /// has asked for, and those of drawCollider(); and those that a change of settings has put others
  /// in place of, which else stay until the next simulate(). Lists that were written before must
  /// not run any more; shadowWords(), shadowViews() and transparencyCounters() are kInvalid until
  /// the next draw().
  void trim();

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
  /// \param list cleared first. Lists of earlier frames that have not been recorded yet are
  ///   abandoned.
  /// Errors: dt or a setting is out of range; a share without HairDef::levelOfDetail; a buffer of
  /// setForces() or the vertex buffer of a collider that is gone or too small; a collider that has
  /// grown over its memory cap; settings that take more strands than a dispatch has room for. After
  /// an error nothing has changed: bones and resets wait for the next frame.
  Result<void> simulate(float dt, PassList& list);
  /// Adds draws of all hair objects that are visible and in view to a list (which is not cleared),
  /// without sorting: Transparency::kStochastic. It may make buffers: update the runtime before the
  /// list runs. A list takes one view: the shadows of a second one would be those of the first,
  /// too. Errors: as below.
  Result<void> draw(const View& view, const Light& light, PassList& list);
  /// Draws them with transparency. The lists run one after another, each with its draws in a render
  /// pass that keeps what is in the target. What is opaque is drawn before, into the same depth
  /// target: earlier, or by draws that lists[0] has already. All views share the buffers, and a
  /// larger one makes them anew: with several views a frame, run the lists of one before the next
  /// one is drawn, or draw the largest one first.
  /// \param lists lists[0] is not cleared, the others are; as many as the method needs, or more.
  /// Errors: a view without pixels, or whose worldToClip has no inverse; too many lights or
  /// shadows; a light or setting out of range; a memory cap that is too small; more hair objects in
  /// view than lists can tell apart (64).
  Result<void> draw(const View& view, std::span<const Light> lights,
                    const TransparencySettings& settings, std::vector<PassList>& lists);
  /// Level of detail for a view: the share of strands that is enough when fibres are drawn at least
  /// `pixels` wide, in the middle of the object: 1 up close, then falling with the distance, down
  /// to 1/64. Set HairObject::drawnShare to it, and simulatedShare (with HairDef::levelOfDetail),
  /// so that the simulation falls with it. 1 where the view or the place of the hair is not finite.
  float shareForView(HairId id, const View& view, float pixels = 0.4f) const;
  /// What drawing this view with an exact method takes, from the hair's size on the screen alone:
  /// within a factor of two or so. For chooseTransparency(). Nothing where draw() would draw
  /// nothing or refuse the view.
  TransparencyWork predictWork(const View& view) const;
  /// Adds the passes that fill the shadow maps of these lights, as draw() does, and no draws: for
  /// shaders of your own (sample/engine_shader). A list takes either this or one draw().
  /// \return number of maps, in the order of the lights that cast a shadow; 0 without visible hair.
  /// Errors: a light out of range; too many shadows.
  Result<uint32_t> castShadows(std::span<const Light> lights, PassList& list);
  /// Words of the shadow maps of the last draw or castShadows(), for pixel kernels of your own
  /// (SHADOW_WORDS of kernels/shading/strand_shadow.hlsli); kInvalid before the first one.
  BufferId shadowWords() const { return shadowWords_; }
  /// What those kernels need to know of each map: kMaxStrandShadows elements of StrandShadowView,
  /// of which as many are written as there are maps; kInvalid likewise.
  BufferId shadowViews() const { return shadowViews_; }
  /// Words for readTransparencyCounters(); kInvalid before the first draw with linked
  /// lists or tiles.
  BufferId transparencyCounters() const { return lists_.counters; }
  /// Adds the passes and the draw that show a collider as its field has it, for debugging: the
  /// surface where the distance is the look's level. Draws nothing before the first simulation.
  /// Errors: a grid that is too large for it.
  Result<void> drawCollider(ColliderId id, const View& view, const Light& light,
                            const ColliderLook& look, PassList& list);
  /// Whether the last drawCollider() that ran drew all of it. \param counts what
  /// SdfColliderBuffers::isoCounts holds, read back. Error: the surface is larger than what there
  /// is room for, and incomplete.
  Result<void> checkColliderDraw(ColliderId id, std::span<const std::byte> counts) const;
  /// Adds the draw of an object's contact records, for debugging: those of the last simulation, on
  /// the GPU. Vertices that touch nothing have no pixels; an object that was in reach of no
  /// collider has no draw. It also shows hidden objects. Asserts that the object exists. Errors: a
  /// view as draw() refuses it; a length, width or depth of the look that is not finite and > 0.
  Result<void> drawContacts(HairId id, const View& view, const ContactLook& look, PassList& list);
  /// How deep the deepest vertex is behind the plane of its contact [m]; 0 where none is.
  /// \param contacts, contactWords, positions what these HairBuffers hold, read back after the last
  ///   simulation. Infinite where a record or a position with one is not finite. Error: a buffer
  ///   has another size.
  Result<float> deepestContact(HairId id, std::span<const std::byte> contacts,
                               std::span<const std::byte> contactWords,
                               std::span<const std::byte> positions) const;
  /// Computes the barriers of a list that is complete. Call it once for each list, in the order in
  /// which the lists run; lists of your own that touch the scene's buffers included.
  void finish(PassList& list);
  /// Says that a list does not run, though it was recorded, submitted or reported as delivered.
  /// Only needed then: what the scene and the runtimes see by themselves they see without it. It
  /// abandons what was written after the list, too. Until the next simulate() the scene is then as
  /// if the frame had never been written. A list that was delivered before the last simulate()
  /// leaves nothing to go back to: all hair is reset, and everything is sent again.
  void abandon(const PassList& list);

  /// Moves the origin of the world, for worlds that are larger than floats are fine: what was at p
  /// is at p - shift from now on. Hair does not notice: nothing jerks, wakes or is reset.
  ///
  ///     scene.shiftOrigin(camera);  // first, then all that is set in the new coordinates
  ///     scene.hair(*hair).setBones(bones);
  ///     scene.simulate(seconds, list);
  ///
  /// All that you have set so far moves along: bones, capsules, bounds of vertices, fields. Set
  /// what moves, in the new coordinates, after it; what stands still need not be set again. Yours
  /// to move before the next list runs are views, lights with a position and the contents of
  /// buffers of your own: SdfColliderDef::vertices, and the forces of setForces() where they depend
  /// on a place. Buffers of positions are in the new coordinates when the next list of simulate(),
  /// also with dt = 0, draw(), castShadows() or drawContacts() has run.
  ///
  /// \param shift [m], -16,777,216..16,777,216 (2^24) along each axis, of any fraction. After whole
  ///   metres the solvers' states have the same bits as without it.
  ///
  /// Errors: a component is not finite or out of range. Nothing has changed then.
  /// Cost: a pass over the guides' positions in the next list; with collisions, hair contact or
  /// stored follow hairs one more for each of them. docs/scene.md says what floats hold.
  /// Source: PxScene::shiftOrigin() of NVIDIA PhysX.
  Result<void> shiftOrigin(Float3 shift);

  /// Seconds simulated so far; the phase of the wind. Without frames that were abandoned.
  double time() const { return time_; }

  static constexpr uint32_t kMaxSubSteps = 4;

 private:
  struct Frame;
  struct DrawFrame;
  /// Of per-pixel linked lists, as in kernels/layouts/ppll_build.hlsli.
  struct ListBuffers {
    BufferId heads = BufferId::kInvalid, nodes = BufferId::kInvalid, counters = BufferId::kInvalid,
             tiles = BufferId::kInvalid, tail = BufferId::kInvalid;
  };
  /// Of strands in tiles, as in kernels/layouts/strand_tiles.hlsli; the counters are those of
  /// lists.
  struct TileBuffers {
    BufferId records = BufferId::kInvalid, tiles = BufferId::kInvalid,
             references = BufferId::kInvalid, sums = BufferId::kInvalid,
             picture = BufferId::kInvalid;
  };
  /// Of methods with a fixed number of layers, as in kernels/layouts/hybrid_depths.hlsli,
  /// hybrid_colors.hlsli and short_cut_*.hlsli.
  struct LayerBuffers {
    BufferId depths = BufferId::kInvalid, colors = BufferId::kInvalid, tail = BufferId::kInvalid,
             counters = BufferId::kInvalid, tiles = BufferId::kInvalid;
  };
  void settleFrames(bool boundary);
  void saveFrame();
  void restoreFrame();
  void commitFrames();
  void forgetOwner(const void* owner);
  void removeOf(detail::FrameCheckpoint& frame, const void* owner);
  void relayFrames();
  void sendEverything();
  Result<void> simulateFrame(float frame, uint32_t steps, PassList& list);
  void addSolverBuffers(HairObject& object);
  void removeSolverBuffers(HairObject& object);
  void removeContacts(HairObject& object);
  void removeBuffer(BufferId& buffer);
  Result<void> checkObject(const HairObject& object) const;
  Result<std::vector<std::optional<detail::SdfGridPlan>>> checkColliders() const;
  bool planCollider(SdfCollider& collider, const detail::SdfGridPlan& plan);
  void addColliderTables(SdfCollider& collider);
  void layOutFields();
  void removeIsoSurface(SdfCollider& collider);
  bool isReached(size_t collider) const;
  void followSkeletons();
  Result<SkeletonPose*> findSkeleton(SkeletonId id, uint32_t boneCount) const;
  BufferId skeletonBuffer(detail::SkeletonInternals& skeleton, SkinningMethod method);
  void removeUnusedCopies();
  void removeDrawBuffers();
  Result<void> buildCollider(size_t place, PassList& list);
  Result<void> addSkinningPass(SdfCollider& collider, PassList& list);
  void addFields(Frame& frame);
  uint64_t bytesOfBuffer(BufferId id) const;
  Result<void> simulateObject(HairObject& object, float length, uint32_t steps, PassList& list);
  Result<void> addRootPass(const Frame& frame);
  Result<void> addClassicPasses(const Frame& frame);
  Result<void> addExactPasses(Frame& frame);
  void prepareContacts(Frame& frame);
  detail::ColliderBuffers colliderBuffers(const Frame& frame) const;
  Result<void> addContactPass(const Frame& frame, uint32_t step, uint32_t steps, bool again);
  Result<void> addSleepPass(Frame& frame, ExactConstants constants);
  void setLevelOfDetail(const Frame& frame, ExactConstants& constants);
  Result<void> addInterpolationPass(const Frame& frame, const ExactConstants& constants,
                                    uint32_t strands);
  void bindExact(const Frame& frame, PassBuilder& builder) const;
  Result<void> finishExactPass(const Frame& frame, PassBuilder& builder,
                               const ExactConstants& constants) const;
  Result<void> addFollowPass(const Frame& frame);
  Result<void> addFollowCollision(const Frame& frame);
  void addHairGrid(HairObject& object);
  void removeHairGrid(HairObject& object);
  Result<void> addHairGridPasses(HairObject& object, double h, bool reset, PassList& list);
  void finishHairGrid(HairObject& object, double frame);
  BufferId forcesOf(const HairObject& object) const;
  detail::Vector3<double> shifted() const;
  Result<void> addPendingShifts(PassList& list);
  void shiftFrames(const detail::Vector3<double>& by);
  void finishShift();
  Result<void> addShiftPasses(const Frame& frame);
  Result<void> addFollowShift(const Frame& frame);
  Result<void> addShift(const Frame& frame, BufferId buffer, uint64_t first, uint64_t count);
  Result<void> addExactRewrite(const Frame& frame);
  Result<void> addClassicRewrite(const Frame& frame);
  Result<DrawFrame> beginDraw(const View& view, std::span<const Light> lights) const;
  Result<uint32_t> addShadows(DrawFrame& frame, PassList& list);
  Result<void> addStrandDraw(const DrawFrame& frame, size_t material, bool smooth,
                             const KernelVariant& pixel, DrawState state,
                             const detail::DrawOffers& offers, PassList& list) const;
  /// Smooth ribbons of all objects into the buffers of a method.
  Result<void> addStrandDraws(const DrawFrame& frame, const KernelVariant& pixel,
                              const detail::DrawOffers& offers, PassList& list) const;
  Result<void> addOpaqueDraws(const DrawFrame& frame, bool stochastic, PassList& list) const;
  Result<void> addListPasses(const DrawFrame& frame, const TransparencySettings& settings,
                             const TransparencyPlan& plan, std::vector<PassList>& lists);
  void makeRoom(const detail::BufferNeed& need);
  Result<void> addTransparency(const DrawFrame& frame, const TransparencySettings& settings,
                               const TransparencyPlan& plan, uint64_t vertices,
                               std::vector<PassList>& lists);
  Result<void> addHybridPasses(const DrawFrame& frame, uint32_t layers,
                               std::vector<PassList>& lists);
  Result<void> addShortCutPasses(const DrawFrame& frame, std::vector<PassList>& lists);
  Result<void> addTilePasses(const DrawFrame& frame, const TransparencySettings& settings,
                             const TransparencyPlan& plan, uint64_t vertices, PassList& list);
  void offerStrands(const DrawFrame& frame, size_t material, PassBuilder& builder) const;

  ResourceTable resources_;
  HazardTracker hazards_;
  detail::Slots<HairId, HairObject> objects_;
  detail::Slots<ColliderId, SdfCollider> colliders_;
  detail::Slots<SkeletonId, SkeletonPose> skeletons_;
  BufferId sdfKeys_ = BufferId::kInvalid, sdfSurface_ = BufferId::kInvalid;
  ListBuffers lists_;
  LayerBuffers hybrid_, shortCut_;
  TileBuffers tiles_;
  BufferId shadowWords_ = BufferId::kInvalid, shadowViews_ = BufferId::kInvalid;
  double time_ = 0;
  std::array<double, 3> shifted_ = {};           ///< sum of all shifts [m]
  std::shared_ptr<detail::SceneFrames> frames_;  ///< nullptr before the first simulate()
};

}  // namespace pelage
