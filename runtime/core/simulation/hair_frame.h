// One hair object in one frame, as the rooms that simulate it see it.
#pragma once

#include <cstdint>
#include <string>

#include "assets/groom.h"
#include "base/local_origin.h"
#include "contact/hair_contacts.h"
#include "passes/room_buffers.h"
#include "pelage/gpu_structs.h"
#include "pelage/hair_object.h"
#include "pelage/pass_list.h"
#include "simulation/exact_solver.h"

namespace pelage::detail {

/// The step that the artist's 0..1 values are defined at, and the longest one [s].
inline constexpr double kReferenceStep = 1.0 / 60.0;
/// Root frames a guide in g_rootTransforms.
inline constexpr uint64_t kRootTransformSets = simulation::kRootSets;

inline bool isZero(Float3 v) { return v.x == 0 && v.y == 0 && v.z == 0; }

struct HairFrame {
  const std::string& name;
  const Groom& groom;
  const SimulationSettings& settings;
  HairBuffers& buffers;
  RoomBuffers room;
  PassList& list;
  BufferRange roots;  ///< simulation: root transforms
  uint32_t guideCount, followCount, vertexCount, boneCount;
  float simulatedShare;  ///< HairObject::simulatedShare
  float length;          ///< [s]
  uint32_t steps;
  AirMotion air;
  float loadShare;  ///< of gravity, wind and forces that acts, 0..1; `air` has it already
  bool reset;
  LocalOrigin stateOrigin;  ///< of the state that the frame begins with
  LocalOrigin origin;       ///< of the object
  Float3 rebase;            ///< from the one to the other

  // What rooms find out for those after them.
  HairContacts& contacts;                ///< contact: the records that the solver reads
  bool hasContacts = false;              ///< they are found in this frame
  BufferId forces = BufferId::kInvalid;  ///< contact: that the solver reads; kInvalid: none
  ColliderBuffers colliders = {};        ///< sdf and contact: in reach
  bool collidersReplaced = false;        ///< others than in the frame before
  bool sleeps = false;                   ///< simulation: tiles of strands may sleep

  /// That acts [m/s2].
  Float3 gravity() const {
    const Float3 g = settings.gravity;
    return {g.x * loadShare, g.y * loadShare, g.z * loadShare};
  }
  uint64_t guideVertices() const { return uint64_t{guideCount} * vertexCount; }
  /// What every kernel of the group "simulation" takes.
  SimulationConstants constants() const;
};

}  // namespace pelage::detail
