// One hair object in one frame, as its rooms see it.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "assets/groom.h"
#include "base/bounds.h"
#include "base/local_origin.h"
#include "passes/buffer_factory.h"
#include "pelage/collider.h"
#include "pelage/force_field.h"
#include "pelage/gpu_structs.h"
#include "pelage/hair_buffers.h"
#include "pelage/ids.h"
#include "pelage/pass_list.h"
#include "pelage/simulation_settings.h"
#include "skinning/bone_bounds.h"

namespace pelage::detail {

/// The step that the artist's 0..1 values are defined at, and the longest one [s].
inline constexpr double kReferenceStep = 1.0 / 60.0;
/// Most steps of a frame; solvers divide them further.
inline constexpr uint32_t kMaxFrameSteps = 4;

inline bool isZero(Float3 v) { return v.x == 0 && v.y == 0 && v.z == 0; }

/// The work of a list on a hair object.
enum class FrameMode : uint8_t {
  kSimulate = 1,  ///< a solver moves it
  kSkin = 2,      ///< bones move it, or given positions
  kPose = 4,      ///< it is shown in its bind pose, and its state stays as it was
  kMove = 8,      ///< it goes where a teleport or a shift of the world brings it
  kBetween = 16,  ///< it is drawn between its last two states
};

/// Guides that are where data says, and no solver: HairObject::setPositions().
struct GivenShape {
  HostArray<Float4> positions;  ///< [guide][vertex] in world space; empty: the solver's
  uint64_t version = 0;         ///< of the positions
  Ball ball;                    ///< around them
  bool isOn() const { return !positions.empty(); }
};

/// Values that an application sets of a hair object. Frames read them and change none.
struct HairInputs {
  RestPose rest;
  HostArray<AffineTransform> bones;
  HostArray<BoneBounds> bounds;
  float deviation = 0;  ///< of roots from where `bones` put `bounds` [m]
  /// Mesh colliders that the hair collides with, ascending; nothing: all.
  std::optional<HostArray<ColliderId>> meshColliders;
  HostArray<CapsuleCollider> colliders;
  ForceField field;
  GivenShape given;
};

/// The wind at a time [m/s].
struct AirMotion {
  Float3 velocity;  ///< gusts included
  Float3 gust0;     ///< the part of the gusts in it
  Float3 gust1;     ///< the same a quarter of their period later
};

/// Contacts of a frame, as solvers read them.
struct ContactInputs {
  bool any = false;           ///< they are found in this frame
  bool replaced = false;      ///< the colliders are others than in the frame before
  uint32_t capsuleCount = 0;  ///< in reach
  BufferRange records;        ///< ContactRecord, and what finding goes on from
  uint64_t recordBytes = 0;   ///< of the records alone
  BufferRange words;
  // In these words:
  uint32_t firstHead = 0, headWords = 0;  ///< of sub-steps
  uint32_t list = 0, masks = 0, maskWords = 1;
  uint32_t rows = 0;  ///< groups in y of the pass over a list of tiles
};

/// Strands in the order of the solver.
struct ContactStrands {
  std::vector<ContactStrand> strands;
  uint32_t stateStride = 0;  ///< ExactConstants::stateStride; 0: the solver needs no scratch
};

/// A sub-step that contacts are found for.
struct ContactPart {
  uint32_t step = 0, steps = 1;
  uint32_t strands = 0;  ///< that are simulated
  bool again = false;    ///< only for the strands that the solver has listed
};

struct HairFrame {
  const std::string& name;
  const Groom& groom;
  const HairInputs& inputs;
  const SimulationSettings& settings;
  HairBuffers& buffers;
  BufferFactory factory;
  PassList& list;
  FrameMode mode;
  uint32_t guideCount, followCount, vertexCount, boneCount;
  // Members of HairObject:
  float simulatedShare;
  bool usesMeshColliders, tracksMotion, interpolates;
  float length;  ///< [s]
  uint32_t steps;
  AirMotion air;
  float loadShare;  ///< of gravity, wind and forces that acts, 0..1; `air` has it already
  bool reset;
  LocalOrigin stateOrigin;  ///< of the state that the frame begins with
  LocalOrigin origin;       ///< of the object
  Float3 rebase;            ///< from the one to the other

  // Rooms set these for rooms after them.
  BufferRange roots = {};    ///< simulation: root transforms
  bool otherSolver = false;  ///< simulation: than in the frame before
  bool otherRest = false;    ///< simulation: the rest pose is another than in the frame before
  bool sleeps = false;       ///< simulation: tiles of strands may sleep
  /// Contact: there are more sub-steps than the object's settings say, as colliders are fast.
  bool hasFastColliders = false;
  ContactInputs contacts = {};
  BufferId forces = BufferId::kInvalid;  ///< that the solver reads, from all who add some

  /// Returns the gravity that acts [m/s2].
  Float3 gravity() const {
    const Float3 g = settings.gravity;
    return {g.x * loadShare, g.y * loadShare, g.z * loadShare};
  }
  uint64_t guideVertices() const { return uint64_t{guideCount} * vertexCount; }
  /// Vertices of guides and of stored follow hairs.
  uint64_t storedVertices() const {
    const uint64_t follows = groom.storesFollowHairs ? followCount : 0;
    return guideVertices() + follows * vertexCount;
  }
};

}  // namespace pelage::detail
