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
#include "pelage/hair_asset.h"
#include "pelage/ids.h"
#include "pelage/pass_list.h"
#include "pelage/simulation_settings.h"
#include "pelage/types.h"
#include "pelage/view.h"

namespace pelage {

namespace detail {
struct HairInternals;
}

/// How the bones of a root are blended.
enum class SkinningMethod : uint8_t {
  kMatrices,         ///< weighted sum of matrices, then the closest rotation
  kDualQuaternions,  ///< dual quaternion blending (Kavan et al. 2008); bones without scale
};

/// Which strands of an object collide.
enum class CollidingHair : uint8_t {
  kGuides,            ///< follow hairs go where their guides take them
  kGuidesAndFollows,  ///< follow hairs are moved out, too: docs/colliders.md says how
};

/// Factors on the parameters of one strand, >= 0.
struct StrandFactors {
  float stiffness = 1;        ///< against bending and twist
  float globalStiffness = 1;  ///< of the spring to the bind pose
  float damping = 1;          ///< of the air drag
};

/// A picture that colours strands by the place of their roots; it repeats beyond 0..1.
struct ColorTexture {
  uint32_t width = 0, height = 0;       ///< texels, 0..16384
  std::span<const Float4> texels = {};  ///< [y][x] linear RGBA, 0..1; A scales the opacity
};

/// What a hair object is made with; what cannot change later.
struct HairDef {
  std::string name = "hair";
  SimulationSettings settings = {};
  StrandMaterial material = {};
  SkinningMethod skinning = SkinningMethod::kMatrices;
  /// Bones and weights of the roots, one entry a guide, from mapBones(); empty binds every root to
  /// bone 0.
  std::span<const BoneInfluences> influences = {};
  /// Number of transforms that setBones() takes, >= 1; influences refer to 0..boneCount - 1.
  uint32_t boneCount = 1;
  /// Bones that other objects follow, too, in place of setBones(). boneCount is that of the
  /// skeleton then, or left at 1.
  SkeletonId skeleton = SkeletonId::kInvalid;
  /// Factors of every guide; empty for 1.
  std::span<const StrandFactors> strandFactors = {};
  /// Exact: lets HairObject::simulatedShare be below 1. Costs a table of one uint32 a guide.
  bool levelOfDetail = false;
  /// Follow strands, from generateFollowHairs(); empty for none.
  std::span<const FollowHair> followHairs = {};
  /// Texture of the base colour, at the roots' HairAsset::strandUv; without texels there is none.
  ColorTexture baseTexture = {};
  /// True when something but the drawing, like a collision field or a pass of your own, reads the
  /// follow hairs from HairBuffers::positions and tangents. Otherwise they are never stored, and
  /// the vertex kernel places them.
  bool storeFollowHairs = false;
  /// With follow hairs, kGuidesAndFollows stores them as storeFollowHairs does. It takes four
  /// passes and 96 bytes for each of their vertices, from the first frame in which something is in
  /// reach.
  CollidingHair collidingHair = CollidingHair::kGuides;
};

/// What the exact solver counted in a frame in which hair may sleep.
struct SimulationCounters {
  uint32_t awakeStrands = 0;
  uint32_t secondPasses =
      0;  ///< Newton passes beyond the first one, over all strands and sub-steps
};

/// Reads the counters from the first 32 bytes of HairBuffers::sleep. They are those of the last
/// frame that the GPU has finished: copy them when your engine reads back, and use them a frame
/// late.
SimulationCounters readCounters(std::span<const std::byte> sleepWords);

/// What contacts cost in a frame, over all sub-steps.
struct ContactCounters {
  uint32_t records = 0;  ///< vertices near a collider, once for each of (at most two) colliders
  uint32_t furtherPasses =
      0;  ///< exact: solver passes beyond the first one of strands with a record
  uint32_t tilesSolvedAgain = 0;  ///< exact: tiles of 32 strands whose contacts were found again,
                                  ///< because a vertex ended over 3 cm from where it was expected
};

/// Reads the counters from the first 16 bytes of HairBuffers::contactWords, as readCounters() does.
ContactCounters readContactCounters(std::span<const std::byte> words);

/// How Scene::drawContacts() shows contact records: one needle each, from the vertex along the
/// contact's normal. docs/contact.md has the colors.
struct ContactLook {
  float length = 0.004f;        ///< of a contact that does not slide [m], > 0; others have half
  float width = 4;              ///< at the vertex [pixels], > 0
  float deepestDepth = 0.001f;  ///< a vertex this deep is red [m], > 0
};

/// What contacts of follow hairs cost in a frame.
struct FollowContactCounters {
  uint32_t records = 0;  ///< vertices near a collider, once for each of (at most two) colliders
  uint32_t strandsWalkedAgain = 0;  ///< whose contacts were found a second time, because a vertex
                                    ///< ended over 1 mm from where they were found first
};

/// Reads the counters from the first 8 bytes of HairBuffers::followContactWords, as
/// readCounters() does.
FollowContactCounters readFollowContactCounters(std::span<const std::byte> words);

/// Buffers of a hair object; kInvalid marks one that this object does not need.
struct HairBuffers {
  BufferId positions = BufferId::kInvalid;     ///< [strand][vertex] Float4, guides first;
                                               ///< follow hairs only with storeFollowHairs
  BufferId tangents = BufferId::kInvalid;      ///< [strand][vertex] Float4, as many
  BufferId state = BufferId::kInvalid;         ///< of the solver: kernels/layouts say what is where
  BufferId rest = BufferId::kInvalid;          ///< of the solver
  BufferId strands = BufferId::kInvalid;       ///< exact: [guide] ExactStrand
  BufferId gains = BufferId::kInvalid;         ///< exact: scratch
  BufferId lengths = BufferId::kInvalid;       ///< classic: scratch
  BufferId sleep = BufferId::kInvalid;         ///< exact: uint32, see readCounters()
  BufferId lodParents = BufferId::kInvalid;    ///< exact, with level of detail: [guide] uint32
  BufferId forces = BufferId::kInvalid;        ///< [guide][vertex] Float4, see setForces()
  BufferId contactNodes = BufferId::kInvalid;  ///< hair contact: words of the grid's nodes
  BufferId contactVertices = BufferId::kInvalid;  ///< [guide][vertex] Float4
  BufferId contactRest = BufferId::kInvalid;      ///< [guide][vertex] float, rest density
  BufferId contactForces = BufferId::kInvalid;    ///< [guide][vertex] Float4, with those of forces
  BufferId contacts = BufferId::kInvalid;  ///< [guide][vertex][2] ContactRecord, of vertices whose
                                           ///< bit is set in contactWords; from the first frame
                                           ///< on in which a collider is in reach
  BufferId contactWords = BufferId::kInvalid;    ///< counters and masks, see readContactCounters()
                                                 ///< and kernels/layouts/contact_records.hlsli
  BufferId colliders = BufferId::kInvalid;       ///< Collider
  BufferId fields = BufferId::kInvalid;          ///< SdfField, of colliders within reach
  BufferId bindRoots = BufferId::kInvalid;       ///< [guide] Float4, bind position of vertex 0
  BufferId rootTransforms = BufferId::kInvalid;  ///< [2][guide] RootTransform
  BufferId rootBindings = BufferId::kInvalid;    ///< [guide] RootBinding
  BufferId boneTransforms =
      BufferId::kInvalid;  ///< 3 (matrices) or 2 (dual quaternions) Float4 each; the skeleton's,
                           ///< where the object follows one
  BufferId followStrands = BufferId::kInvalid;  ///< [follow] FollowStrand
  BufferId followBefore = BufferId::kInvalid;   ///< [2][follow][vertex] Float4, where follow hairs
                                                ///< collide: as drawn, and as placed before
  BufferId followContactWords = BufferId::kInvalid;  ///< see readFollowContactCounters()
  BufferId strandThickness = BufferId::kInvalid;     ///< [strand] float
  BufferId indices = BufferId::kInvalid;             ///< one strand's ribbon, uint32
  BufferId vertexColors = BufferId::kInvalid;  ///< [guide][vertex] linear rgba, 4 unorms of 16 bits
  BufferId strandUv = BufferId::kInvalid;      ///< [guide] Float2, with baseTexture
  BufferId baseTexture = BufferId::kInvalid;   ///< [y][x] as vertexColors
};

class HairObject {
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

  /// May be changed at any time; checked by Scene::simulate().
  SimulationSettings settings;
  /// May be changed at any time.
  StrandMaterial material;
  /// Exact, with HairDef::levelOfDetail: share of the guides that are simulated, 0..1; at least one
  /// is. The others take the shape of one near them. Changes take effect over a quarter of a
  /// second, and guides fade from one to the other.
  float simulatedShare = 1;
  /// Collides with the scene's mesh colliders: with those of setMeshColliders(), or all.
  bool usesMeshColliders = true;
  /// A hidden object is simulated, but not drawn.
  bool visible = true;
  /// Strands drawn, from the first: 0..strandCount(). Follow hairs go first when it falls.
  uint32_t drawnStrands = 0;
  /// Level of detail: share of `drawnStrands` that is drawn, 0..1. Those that are left are wider,
  /// so that the hair covers as much; the last eighth fades, so that nothing pops. See
  /// shareForView().
  float drawnShare = 1;

  /// Sets the skinning transforms (bind space to world) of all bones for the next frames. Asserts
  /// that there are boneCount() of them, and that the object follows no skeleton. Non-finite ones
  /// leave their roots where they were.
  void setBones(std::span<const AffineTransform> bones);
  /// Sets what the hair collides with in the next frames; empty for nothing. A collider that is not
  /// finite or has a negative radius is left out, and so is one that no strand can reach. Colliders
  /// keep their place in the list from frame to frame, for their motion.
  void setColliders(std::span<const CapsuleCollider> colliders);
  /// Sets which of the scene's mesh colliders the hair collides with in the next frames; empty for
  /// none of them. Ids of colliders that are not there, or no longer, are ignored.
  void setMeshColliders(std::span<const ColliderId> colliders);
  /// Lets it collide with all of them, also those that are added later: the default.
  void useAllMeshColliders();
  /// Lets the solver take forces from a buffer that a pass of yours writes before each
  /// simulation: [guide][vertex] Float4 in the order of HairBuffers::positions, xyz = acceleration
  /// a [m/s2], w = drag k [1/s], >= 0. The equation of motion gets a - k v; a wind u of your own is
  /// a = k u. kInvalid takes none. Forces keep the hair awake.
  void setForces(BufferId forces) { buffers_.forces = forces; }
  /// Puts the hair into its bind shape at the next frame and forgets all velocities: for
  /// teleports, cuts, and changes of animation. Sends bones, colliders and fields again.
  void reset();

 private:
  friend class Scene;
  HairObject();

  std::string name_;
  uint32_t guideCount_ = 0, followCount_ = 0, vertexCount_ = 0, boneCount_ = 0;
  HairBuffers buffers_;
  std::unique_ptr<detail::HairInternals> internals_;
};

}  // namespace pelage
