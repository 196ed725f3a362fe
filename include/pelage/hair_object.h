// A groom in a scene: its buffers, its settings and its bones. Made by Scene::addHair().
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "pelage/bone_weights.h"
#include "pelage/collider.h"
#include "pelage/export.h"
#include "pelage/force_field.h"
#include "pelage/hair_asset.h"
#include "pelage/hair_buffers.h"
#include "pelage/ids.h"
#include "pelage/pass_list.h"
#include "pelage/result.h"
#include "pelage/simulation_settings.h"
#include "pelage/strand_texture.h"
#include "pelage/types.h"
#include "pelage/view.h"

namespace pelage {

namespace detail {
class HairStore;
struct HairInternals;
}  // namespace detail

/// The strands of an object that collide.
enum class CollidingHair : uint8_t {
  kGuides,            ///< only guides collide; follow hairs follow them
  kGuidesAndFollows,  ///< follow hairs are moved out, too: docs/contact.md
};

/// A texture that colors strands by the UV of their roots; it repeats beyond 0..1.
struct ColorTexture {
  uint32_t width = 0, height = 0;       ///< texels, 0..16384
  std::span<const Float4> texels = {};  ///< [y][x] linear RGBA, 0..1; A multiplies the opacity
};

/// The definition of a hair object. These values cannot change later, except `settings` and
/// `material`.
struct HairDef {
  std::string name = "hair";
  SimulationSettings settings = {};
  StrandMaterial material = {};
  SkinningMethod skinning = SkinningMethod::kMatrices;
  /// Bones and weights of the roots, one entry per guide, from mapBones(); if empty, every root is
  /// bound to bone 0.
  std::span<const BoneInfluences> influences = {};
  /// Number of transforms that setBones() takes, >= 1; influences refer to 0..boneCount - 1.
  uint32_t boneCount = 1;
  /// A skeleton to follow instead of setBones(); several objects can share it. boneCount is then
  /// that of the skeleton, or left at 1.
  SkeletonId skeleton = SkeletonId::kInvalid;
  /// Factors of every guide; if empty, all are 1.
  std::span<const StrandFactors> strandFactors = {};
  /// Exact: allows HairObject::simulatedShare below 1. Costs a table of one uint32 per guide.
  bool levelOfDetail = false;
  /// Follow hairs, from generateFollowHairs(), or your own in spreadOrder(); empty for none.
  std::span<const FollowHair> followHairs = {};
  /// Texture of the base color, sampled at HairAsset::strandUv of the roots; without texels there
  /// is none.
  ColorTexture baseTexture = {};
  /// Puts HairAsset::strandUv on the GPU (HairBuffers::strandUvs): for HairObject::strandTexture,
  /// for the lights of an engine, and for shaders of your own. Costs 16 bytes a guide.
  bool strandUvs = false;
  /// Set this if anything besides drawing, such as your own pass, reads the follow hairs from
  /// HairBuffers::positions and tangents. Otherwise they are not stored, and the vertex kernel
  /// computes them.
  bool storeFollowHairs = false;
  /// kGuidesAndFollows stores the follow hairs, as storeFollowHairs does. It costs four passes and
  /// 96 bytes per follow vertex, from the first frame in which a collider is in range.
  CollidingHair collidingHair = CollidingHair::kGuides;
};

/// Hair of a scene. Threads: the one that uses its scene.
class PELAGE_API HairObject {
 public:
  ~HairObject();
  const std::string& name() const { return name_; }
  uint32_t guideCount() const { return guideCount_; }
  uint32_t followCount() const { return followCount_; }
  uint32_t strandCount() const { return guideCount_ + followCount_; }
  uint32_t verticesPerStrand() const { return vertexCount_; }
  uint32_t boneCount() const { return boneCount_; }
  SkinningMethod skinning() const;
  const HairBuffers& buffers() const { return buffers_; }
  /// Guides that are too limp for SimulationSettings::sagCompensation, as it was in the last frame:
  /// they sag, by less than without it. reachableSagCompensation() names them.
  uint32_t limpGuideCount() const;
  /// [2][guide] RootTransform: the roots in this frame and the last one, a part of
  /// HairBuffers::state.
  BufferRange rootTransforms() const;

  /// May be changed at any time; Scene::simulate() checks it.
  SimulationSettings settings;
  /// May be changed at any time.
  StrandMaterial material;
  /// A texture of your engine that colors the strands, in place of HairDef::baseTexture. It needs
  /// HairDef::strandUvs. May be changed at any time; draws check it. Each guide takes one color a
  /// view, and follow hairs that of their first guide: docs/shading.md says from which mip level.
  /// Cost: a pass of one thread a guide in each view that the object is in, and 16 bytes a guide;
  /// without a texture there is neither.
  StrandTexture strandTexture;
  /// Exact, with HairDef::levelOfDetail: fraction of the guides that is simulated, 0..1; at least
  /// one is. Each other guide takes the shape of a simulated one near it. Changes take effect over
  /// a quarter of a second; guides fade from one shape to the other.
  float simulatedShare = 1;
  /// If false, the hair is moved rigidly with its bones: it has its bind shape, and neither a
  /// solver nor contacts have a pass. For characters far away and cut scenes. It takes effect at
  /// the next frame; level of detail then applies to drawing alone. Once it is true again, the hair
  /// continues from its bind shape with the velocity of its roots.
  bool simulated = true;
  /// Time in which gravity, wind and forces rise to their full strength after `simulated` has
  /// become true again [s], finite, >= 0. With 0 they act at once.
  float blendTime = 0.5f;
  /// If true, the hair collides with mesh colliders of the scene: with those of setMeshColliders(),
  /// or all.
  bool usesMeshColliders = true;
  /// A hidden object is simulated, but not drawn.
  bool visible = true;
  /// Number of strands that are drawn, from the first: 0..strandCount(). Decreasing it removes
  /// follow hairs first.
  uint32_t drawnStrands = 0;
  /// Level of detail: fraction of `drawnStrands` that is drawn, 0..1. The remaining strands are
  /// wider, so that the hair covers the same area; the last eighth fades, so that nothing pops. See
  /// shareForView().
  float drawnShare = 1;
  /// Keeps where the strands were before each simulation, for HairDepthColor::kMotion and for
  /// shaders of your own (HairBuffers::previousPositions). Costs a pass that copies the positions,
  /// and a buffer of their size; false has neither. It may change at any time: motion is right from
  /// the first frame on that has it.
  bool tracksMotion = false;
  /// Keeps the state before each simulation, so that Frame::interpolate() can draw the hair between
  /// two fixed steps. Costs a pass that copies the positions, and 48 bytes a vertex that is stored;
  /// false has neither. It may change at any time; until the next simulation the object is drawn in
  /// its last state. With tracksMotion, motion is that between the frames of interpolate().
  bool interpolates = false;

  /// Sets the skinning transforms (bind space to world) of all bones for the next frames. Asserts
  /// that the span has boneCount() elements, and that the object follows no skeleton. A root with a
  /// non-finite transform stays where it was.
  void setBones(std::span<const AffineTransform> bones);
  /// Sets the capsules that the hair collides with in the next frames; empty for none. A collider
  /// that is not finite or has a negative radius is ignored; one that no strand can touch costs
  /// nothing. Keep each collider at the same index from frame to frame: its motion is the
  /// difference to the last frame.
  void setColliders(std::span<const CapsuleCollider> colliders);
  /// Sets the mesh colliders of the scene that the hair collides with in the next frames; empty for
  /// none. Invalid ids, and ids of removed colliders, are ignored.
  void setMeshColliders(std::span<const ColliderId> colliders);
  /// Makes the hair collide with all mesh colliders, including those that are added later: the
  /// default.
  void useAllMeshColliders();
  /// Makes the solver read forces from a buffer that your own pass writes before each simulation:
  /// [guide][vertex] Float4 in the order of HairBuffers::positions, xyz = acceleration a [m/s2], w
  /// = drag k [1/s], >= 0. The equation of motion gets a - k v; for your own wind u, set a = k u.
  /// kInvalid removes the buffer. Forces keep the hair awake.
  void setForces(BufferId forces) { buffers_.forces = forces; }
  /// Makes a field act on the hair beside gravity, wind and setForces(), at where the vertices are
  /// at the beginning of each frame; not in the frame of a reset. Your own pass writes it before
  /// each simulation, in which it is read. A field without a buffer is none. Fields keep the hair
  /// awake. Scene::shiftOrigin() moves its origin. Cost: a pass of one thread a vertex of a guide
  /// in a frame, and 16 bytes a vertex.
  void setForceField(const ForceField& field);
  /// Changes the rest pose without a reset: the bind positions of the guides, and with them lengths
  /// and rest shape. State, velocities, contacts and sleep of everything else stay; from the next
  /// frame on the solver pulls the hair towards its new rest shape, as it would from any other
  /// shape. Lengths are the new ones from that frame on: beside its motion, a vertex jumps by at
  /// most the sum of the changes of the lengths before it (classic: of the strand's whole length).
  /// Roots and first edges, which the bones hold, go to where the new pose has them within the
  /// frame, as if the bones had moved them.
  /// \param positions  [guide][vertex] xyz [m] in bind space, guideCount() * verticesPerStrand() of
  ///   them; w is ignored, the inverse masses stay.
  /// Errors: another number of positions; one that is not finite or out of range, with its strand
  /// and vertex. Nothing has changed then.
  /// Cost: rest data are derived on the host, and a table of 16 to 64 bytes a vertex is sent; none
  /// where the positions are those that the object has.
  Result<void> setRestPose(std::span<const Float4> positions);
  /// Sets where the guides are from the next frame on, in place of a solver: for simulated hair
  /// from a file (CachePlayer) or another program. While positions are set, the hair is as with
  /// `simulated` = false; bones place the roots of follow hairs, and nothing else. Motion is that
  /// from the positions of the frame before: call reset() at cuts. Scene::shiftOrigin() and
  /// teleport() move the positions, too. Bounds for drawing and shadows are those of the positions.
  /// \param positions [guide][vertex] in world space [m], guideCount() * verticesPerStrand() of
  ///   them; empty: the object is simulated again, after a reset.
  /// Errors: another number of positions; one that is not finite or beyond kMaxCoordinate, with its
  /// guide and vertex. Nothing has changed then.
  /// Cost: a copy on the host, 16 bytes a vertex that are sent, and a pass of one thread a vertex.
  Result<void> setPositions(std::span<const Float3> positions);
  /// Puts the hair into its bind shape at the next frame and clears all velocities. Call it at
  /// cuts and changes of animation, and at teleports without Scene::teleport(). It uploads bones,
  /// colliders and SDF records again.
  void reset();

 private:
  friend class detail::HairStore;
  explicit HairObject(std::unique_ptr<detail::HairInternals> internals);

  std::string name_;
  uint32_t guideCount_ = 0, followCount_ = 0, vertexCount_ = 0, boneCount_ = 0;
  HairBuffers buffers_;
  std::unique_ptr<detail::HairInternals> internals_;
};

/// Computes it from HairObject::drawnStrands and drawnShare.
PELAGE_API DrawnStrands drawnStrandsOf(const HairObject& hair);

}  // namespace pelage
