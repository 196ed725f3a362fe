// A scene: hair objects and the pass lists that move and draw them.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <vector>

#include "pelage/export.h"
#include "pelage/frame.h"
#include "pelage/hair_depth.h"
#include "pelage/hair_object.h"
#include "pelage/ids.h"
#include "pelage/pass_list.h"
#include "pelage/result.h"
#include "pelage/sdf_collider.h"
#include "pelage/skeleton_pose.h"
#include "pelage/tier.h"
#include "pelage/transparency.h"
#include "pelage/view.h"

namespace pelage {

namespace detail {
struct SceneParts;
struct SnapshotData;
}  // namespace detail

/// Width of a fiber below which Scene::shareForView() leaves some out [pixels]. Against the picture
/// of all strands PSNR is 40 dB or more (docs/oit.md).
inline constexpr float kDetailPixels = 0.25f;

/// Reads a buffer of Scene::resources() back from the device, behind all that has run.
using BufferReader = std::function<Result<std::vector<std::byte>>(BufferId)>;

/// The state of the hair of a scene at a time, on the host: Scene::takeSnapshot(). Copies share it.
class PELAGE_API SceneSnapshot {
 public:
  /// Sum in bytes.
  uint64_t bytes() const;

 private:
  friend class Scene;
  std::shared_ptr<const detail::SnapshotData> data_;
};

/// Bytes of the buffers of an object of a scene.
struct ObjectBytes {
  uint64_t own = 0;     ///< go with the object
  uint64_t shared = 0;  ///< in buffers that others have, too: see Scene::bytesOf()
};

/// Bytes of the buffers that Scene::draw() has made for all hair together.
struct DrawBytes {
  std::vector<uint64_t> views;  ///< [n] of the n-th view of a frame, for all methods it has had
  uint64_t shadows = 0;         ///< of the maps of all lights
};

/// Holds hair objects and writes their pass lists. No graphics API: a runtime creates the buffers
/// of resources() and runs the lists, in the order in which they were made.
///
///     Scene scene;
///     auto hair = scene.addHair(asset, {.name = "groom"});
///     ...
///     scene.hair(*hair).setBones(bones);
///     auto frame = scene.simulate(1.0f / 60);
///     if (frame) drawn = frame->draw(view, lights);  // then a runtime takes the frame
///
/// Nothing is delivered until it ran. A list of simulate() that is not recorded before the next
/// simulate() never runs, and one that was recorded may still turn out not to (vulkan::Runtime::
/// submitted(), setDelivered()): the scene is then as if that frame had never been written, and the
/// next one has all that it had: uploads, bones, resets, time. Nobody has to say so; docs/scene.md.
///
/// Threads: one thread at a time, for the scene and everything that it hands out. Two scenes share
/// nothing and may be used from two threads.
class PELAGE_API Scene {
 public:
  Scene();
  ~Scene();
  /// The scene that was moved from is empty; frames go with the objects.
  Scene(Scene&& other) noexcept;
  Scene& operator=(Scene&& other) noexcept;

  /// Adds a hair object. Errors: an asset without strands, settings out of range, a follow hair of
  /// a guide that does not exist or with an offset that is not finite, bone weights of another
  /// groom, a skeleton that does not exist or has another number of bones, more strands than one
  /// dispatch takes: 4,194,240 guides, and 2,097,120 follow hairs where these are stored.
  Result<HairId> addHair(const HairAsset& asset, const HairDef& def);
  /// The same without a copy of the asset: for objects that share it. With either, objects with the
  /// same tables have one buffer for them (rest shape, bindings, follow hairs, colors and others
  /// that never change): do not write into these.
  Result<HairId> addHair(std::shared_ptr<const HairAsset> asset, const HairDef& def);
  /// Removes a hair object and its buffers; with the last one also those that draw() has made.
  /// Error: the id names no hair object of this scene.
  Result<void> removeHair(HairId id);
  /// Asserts that the object exists; where the handler of the assertion returns, the program ends.
  HairObject& hair(HairId id);
  const HairObject& hair(HairId id) const;
  /// True while the id names something of this scene.
  bool isValid(HairId id) const;
  bool isValid(ColliderId id) const;
  bool isValid(SkeletonId id) const;
  uint32_t hairCount() const;

  /// Adds a mesh that hair collides with, through a signed distance field. All hair collides with
  /// it, except objects that HairObject::setMeshColliders() excludes. The field is built before the
  /// hair moves, in frames in which the mesh has moved and hair can touch it: only the part that
  /// moved, or all of it. Open meshes and meshes with overlaps are allowed, see
  /// SdfCollider::report().
  /// Errors: no triangles, a vertex that is not finite, no bones, settings out of range, indices of
  /// vertices or bones that do not exist, a field over the memory cap, a vertex buffer that is too
  /// small, a skeleton that does not exist or has another number of bones.
  Result<ColliderId> addCollider(const CollisionMesh& mesh, const SdfColliderDef& def);
  /// The same with a field that was built before; it never moves. Errors: settings out of range, a
  /// skeleton.
  Result<ColliderId> addCollider(const SdfData& data, const SdfColliderDef& def);
  /// The same with an SDF that your engine has on the GPU. Contacts are those of the trilinear
  /// distance and its gradient, and know no motion of the surface: friction is against a surface at
  /// rest. Of the definition, only the name counts. Errors: no such buffer, or one that is too
  /// small; a grid that is not finite, without cells, or with more than 2^28 nodes.
  Result<ColliderId> addCollider(const DenseSdf& sdf, const SdfColliderDef& def);
  /// Error: the id names no collider of this scene.
  Result<void> removeCollider(ColliderId id);
  /// As hair().
  SdfCollider& collider(ColliderId id);
  const SdfCollider& collider(ColliderId id) const;
  /// Adds bones that hair objects and colliders can follow together: HairDef::skeleton,
  /// SdfColliderDef::skeleton. They are identities until SkeletonPose::setBones(). Errors: no
  /// bones; a source or a deviation out of range; a skin table without BoneSource::kSurface, or
  /// that validate() refuses, or with another number of roots.
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

  /// Converts a collider's field, as its last build left it in sdfKeys() and sdfSurface() and you
  /// read it back, to data that can be saved. Error: the field has not been built since the
  /// collider got its range in these buffers, or the buffers are not the scene's.
  Result<SdfData> copySdf(ColliderId id, std::span<const std::byte> keys,
                          std::span<const std::byte> surface) const;
  /// Keys and records of all colliders; kInvalid without any.
  BufferId sdfKeys() const;
  BufferId sdfSurface() const;

  /// The buffers that a runtime is to create before it runs the next list. Add buffers of your own
  /// to use them in passes beside the scene's.
  ResourceTable& resources();
  const ResourceTable& resources() const;

  /// Bytes of an object's buffers in resources(), of which removing it gives `own` back. Of hair,
  /// `shared` are tables that objects with the same contents have together, and that go with the
  /// last of them; of a collider its part of sdfKeys() and sdfSurface(). Buffers that a frame has
  /// replaced, which stay until the next one, are in ResourceTable::totalBytes() alone. Asserts
  /// that the object exists. Cost: some lookups.
  ObjectBytes bytesOf(HairId id) const;
  ObjectBytes bytesOf(ColliderId id) const;
  /// Size of the memory that trim() gives back, without drawCollider()'s.
  DrawBytes drawBytes() const;

  /// Begins a frame that advances every hair object by dt: draw its views, and give it to a runtime
  /// before the next one. \param dt seconds, as below. Errors: as below.
  Result<pelage::Frame> simulate(float dt);

  // The layer below frames, for engines that keep lists of their own: docs/scene.md says when.

  /// Adds the passes that place the objects with HairObject::interpolates between their last two
  /// states, as Frame::interpolate() does, to a list behind simulate() and before all draws of the
  /// frame; call it once a frame. \param list  that of simulate(), or one of your own (which is not
  /// cleared). Errors: those of Frame::interpolate(); a list of an earlier frame.
  Result<void> interpolate(float share, PassList& list);

  /// Writes the passes that advance every hair object by dt.
  /// \param dt seconds, >= 0. 0 skips the simulation; hair that has not moved since it was added or
  ///   reset is shown in its bind pose under the bones. Steps are at most 1/60 s: a longer dt is
  ///   cut into equal sub-steps, at most kMaxSubSteps of them; time beyond that is dropped. The
  ///   exact solver cuts each of them further into SimulationSettings::subSteps.
  /// \param list cleared first. Lists of earlier frames that have not been recorded yet are
  ///   abandoned.
  /// Errors: dt or a setting is out of range; a share without HairDef::levelOfDetail; a buffer of
  /// setForces() or the vertex buffer of a collider that is gone or too small; a collider that has
  /// grown over its memory cap; settings that take more strands than a dispatch has room for. After
  /// an error nothing has changed: bones and resets wait for the next frame.
  Result<void> simulate(float dt, PassList& list);
  /// Adds draws of all hair objects that are visible and in view to a list (which is not cleared),
  /// without sorting: Transparency::kStochastic. It may make buffers: update the runtime before the
  /// list runs. Errors: as below.
  Result<void> draw(const View& view, const Light& light, PassList& list);
  /// Draws them with transparency. The lists run one after another, each with its draws in a render
  /// pass that keeps what is in the target. What is opaque is drawn before, into the same depth
  /// target: earlier, or by draws that lists[0] has already. Every view whose lists have not run
  /// yet has buffers of its own; later views have them again. More than 64 hair objects whose
  /// materials shade differently are drawn in batches by lists and tiles: docs/oit.md.
  /// \param lists lists[0] is not cleared, the others are; as many as the method needs, or more.
  /// Errors, which name the field: a view without pixels, whose worldToClip is not finite or has no
  /// inverse, or with samples that no target has; lists[0] with draws of another viewport; too many
  /// lights or shadows; a light without a direction, or not finite; a light, setting or material
  /// out of range or of no value of its enum; a memory cap that is too small; engine lights that
  /// lack a kernel. Nothing has changed then.
  Result<void> draw(const View& view, std::span<const Light> lights,
                    const TransparencySettings& settings, std::vector<PassList>& lists);
  /// Adds draws of depth, and of motion, of all hair objects that are visible and in view to a list
  /// (which is not cleared): of strands alone, beside every method of draw(). Where several
  /// fragments are in a pixel, the depth test keeps the nearest one. It may make buffers below
  /// Tier::kWide: update the runtime before the list runs.
  ///
  /// Motion is that of hair since the last frame with HairObject::tracksMotion, and of the camera.
  /// It is that of the camera alone without it; in frames in which the object is reset or new; and
  /// in frames of simulate(0), which move nothing.
  /// Errors: a view as draw() refuses it; settings out of range; below Tier::kWide a memory cap
  /// that is too small. Nothing has changed then.
  Result<void> drawDepth(const View& view, const HairDepthSettings& settings, PassList& list);
  /// Level of detail for a view: the share of strands that is enough when fibers are drawn at least
  /// `pixels` wide, where the object is nearest: 1 up close, then falling with the distance, down
  /// to 1/64. Set HairObject::drawnShare to it, and simulatedShare (with HairDef::levelOfDetail),
  /// so that the simulation falls with it. 1 where the view or the position of the hair is not
  /// finite, or `pixels` is 0.
  float shareForView(HairId id, const View& view, float pixels = kDetailPixels) const;
  /// Predicts the work of drawing this view with an exact method, from the hair's size on the
  /// screen alone: within a factor of two or so. For chooseTransparency(). Zero where draw() would
  /// draw nothing or refuse the view.
  TransparencyWork predictWork(const View& view) const;
  /// Adds the passes that fill the shadow maps of these lights, as draw() does, and no draws: for
  /// shaders of your own (sample/engine_shader). A light that a list of this frame has a map of
  /// already, from simulate() to simulate(), has no passes.
  /// \return number of maps, in the order of the lights that cast a shadow; 0 without visible hair.
  /// Errors: a light out of range; too many shadows; maps over setShadowMemory().
  Result<uint32_t> castShadows(std::span<const Light> lights, PassList& list);
  /// Bytes that the shadow maps of a frame may take, 1 GiB until it is called. A light that more
  /// than one view of a frame sees has one map for all of them. Lights over the cap are an error of
  /// draw() and castShadows(), and the next call with less works.
  void setShadowMemory(uint64_t maxBytes);
  /// The tier of the device that runs the lists: vulkan::Runtime::tier(), gl::Runtime::tier().
  /// Below Tier::kWide the vertex stage has no storage buffers: draws of hair then transform all
  /// vertices first, which takes 48 bytes a vertex of the hair in view. Tier::kWide until it is
  /// called; counts from the next draw on.
  void setTier(Tier tier);
  /// Whether dispatches of lists are sorted into levels, so that objects do not wait for each other
  /// (HazardTracker::setLevels()); true until it is called. Off is for debugging, and for the times
  /// of single passes: bits are the same. Counts from the next finish() on.
  void setLevels(bool on);
  /// Words of the shadow maps of the last draw or castShadows(), for pixel kernels of your own
  /// (SHADOW_WORDS of kernels/shading/strand_shadow.hlsli); kInvalid before the first one.
  BufferId shadowWords() const;
  /// Data of each map for those kernels: kMaxStrandShadows elements of StrandShadowView, one
  /// written for each map; kInvalid before the maps exist.
  BufferId shadowViews() const;
  /// Words for readTransparencyCounters(), of the view that was drawn last; kInvalid before the
  /// first draw with linked lists or tiles.
  BufferId transparencyCounters() const;
  /// Tiles of the view that was drawn last, to read in a view of your own behind it. Buffers are
  /// kInvalid before the first draw, after trim(), without hair in view, and for methods other than
  /// kWindowed and kTiles.
  TransparencyTiles transparencyTiles() const;
  /// Adds the passes and the draw that show a collider as its field has it, for debugging: the
  /// surface where the distance is the look's level. Draws nothing before the first simulation.
  /// Errors: a grid that is too large for it; a view or light as draw() refuses it.
  Result<void> drawCollider(ColliderId id, const View& view, const Light& light,
                            const ColliderLook& look, PassList& list);
  /// Whether the last drawCollider() that ran drew all of it. Error: the surface is larger than its
  /// buffers, and incomplete.
  /// \param counts  the contents of SdfColliderBuffers::isoCounts, read back.
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
  /// which the lists run; lists of your own that touch the scene's buffers included. A list that
  /// has run stays refused until it is cleared.
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
  /// also with dt = 0, draw(), drawDepth(), castShadows() or drawContacts() has run.
  ///
  /// \param shift [m], -16,777,216..16,777,216 (2^24) along each axis, of any fraction. After whole
  ///   metres the solvers' states have the same bits as without it.
  ///
  /// Errors: a component is not finite or out of range. Nothing has changed then.
  /// Cost: a pass over the guides' positions in the next list; with collisions, hair contact or
  /// stored follow hairs one more for each of them. docs/scene.md says what floats hold.
  /// Source: PxScene::shiftOrigin() of NVIDIA PhysX.
  Result<void> shiftOrigin(Float3 shift);

  /// Moves an object rigidly to another place, with all that it is in the middle of: shape,
  /// velocities, contacts, sleep. What was at p is at M p + t from now on, and the next frame goes
  /// on as if the object had always been there. HairObject::reset() instead forgets it.
  ///
  ///     scene.teleport(hair, motion);
  ///     scene.hair(hair).setBones(bonesThere);           // or those of its skeleton
  ///     scene.hair(hair).setColliders(capsulesThere);
  ///     scene.simulate(seconds, list);
  ///
  /// The object's own bones and capsules move along, and need not be set again if they do not move
  /// otherwise. Yours to move before the next simulation are the skeleton that it follows, mesh
  /// colliders (SdfCollider::reset() them, else they sweep through the hair), and, where the motion
  /// rotates, gravity, wind and the forces of setForces(). Positions and tangents of HairBuffers
  /// are moved when the next list of simulate(), also with dt = 0, draw(), castShadows() or
  /// drawContacts() has run.
  ///
  /// \param motion a rotation (to 1e-3) and a translation [m] of at most 16,777,216 (2^24) along
  ///   each axis; in world space.
  ///
  /// Errors: the id names no hair object of this scene; the motion scales, shears, mirrors, is not
  /// finite or goes too far. Nothing has changed then.
  /// Cost: passes over the state, contacts and tangents of the object in the next list.
  Result<void> teleport(HairId id, const AffineTransform& motion);

  /// Reads the state of all hair back, to go on from where the device is lost. \param read  as
  /// HeadlessDevice::read(), or from copies of your own. Errors: a frame has not run yet; `read` is
  /// empty; those of `read`. Cost: all buffers of hair that are not shared cross the bus; take one
  /// every few seconds, or before what may lose the device.
  Result<SceneSnapshot> takeSnapshot(const BufferReader& read) const;
  /// Takes note that the device is lost, or another one takes over: nothing that was recorded
  /// counts, and the next update() of a new runtime makes all buffers anew. Objects, settings, ids,
  /// bones and colliders stay. Hair goes on from the snapshot, with its time, where the object has
  /// the buffers that it had then; other hair is reset, and fields of meshes are built anew. The
  /// bytes of the snapshot stay in the table of buffers. Your own buffers of setForces() are yours
  /// to fill.
  ///
  ///     if (drawn.error().code == ErrorCode::kDeviceLost) {
  ///       device.reset();
  ///       device = makeDevice();
  ///       kept = scene.recover(snapshot);
  ///     }
  ///
  /// \return number of objects that go on. Error: a snapshot of another scene; nothing has changed.
  Result<uint32_t> recover(const SceneSnapshot& snapshot = {});

  /// Seconds simulated so far; the phase of the wind. Without frames that were abandoned.
  double time() const;

  static constexpr uint32_t kMaxSubSteps = 4;

 private:
  std::shared_ptr<detail::SceneParts> parts_;  ///< shared with nobody; frames ask for it
};

}  // namespace pelage
