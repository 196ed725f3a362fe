// The buffers of a hair object, and the counters that kernels keep in them.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "pelage/binding.h"
#include "pelage/export.h"

namespace pelage {

/// Counters of the exact solver in a frame in which hair may sleep.
struct SimulationCounters {
  uint32_t awakeStrands = 0;
  uint32_t secondPasses =
      0;  ///< Newton passes beyond the first one, over all strands and sub-steps
};

/// Reads the counters from the first 32 bytes of HairBuffers::sleep. They belong to the last frame
/// that the GPU has finished: copy them when your engine reads back, and use them one frame later.
PELAGE_API SimulationCounters readCounters(std::span<const std::byte> sleepWords);

/// Counters of contacts in a frame, over all sub-steps.
struct ContactCounters {
  uint32_t records = 0;  ///< pairs of a vertex and a collider near it (at most two per vertex)
  /// exact: strands that were solved a second time, with contacts found anew
  uint32_t strandsSolvedAgain = 0;
};

/// Reads the counters from the first 16 bytes of HairBuffers::contactWords, as readCounters() does.
PELAGE_API ContactCounters readContactCounters(std::span<const std::byte> words);

/// Counters of contacts of follow hairs in a frame.
struct FollowContactCounters {
  uint32_t records = 0;  ///< pairs of a vertex and a collider near it (at most two per vertex)
  uint32_t strandsWalkedAgain = 0;  ///< strands whose contacts were found a second time, because a
                                    ///< vertex ended over 1 mm from where they were found first
};

/// Reads the counters from the first 8 bytes of HairBuffers::followContactWords, as
/// readCounters() does.
PELAGE_API FollowContactCounters readFollowContactCounters(std::span<const std::byte> words);

/// Buffers of a hair object that the library makes; kInvalid marks one that this object does not
/// need.
struct HairOutputs {
  BufferId positions = BufferId::kInvalid;      ///< [strand][vertex] Float4, guides first;
                                                ///< follow hairs only with storeFollowHairs
  BufferId tangents = BufferId::kInvalid;       ///< [strand][vertex] Float4, of the same size
  BufferId state = BufferId::kInvalid;          ///< state of the solver; layout: kernels/simulation
  BufferId rest = BufferId::kInvalid;           ///< rest shape for the solver; exact: then [guide]
                                                ///< ExactStrand
  BufferId sleep = BufferId::kInvalid;          ///< exact: uint32, see readCounters()
  BufferId lodParents = BufferId::kInvalid;     ///< exact, with level of detail: [guide] uint32
  BufferId contactForces = BufferId::kInvalid;  ///< hair-hair contact: [guide][vertex] Float4, sum
                                                ///< with `forces`
  BufferId contacts = BufferId::kInvalid;  ///< [guide][vertex][2] ContactRecord, of vertices whose
                                           ///< bit is set in contactWords; from the first frame
                                           ///< in which a collider is in range
  BufferId contactWords =
      BufferId::kInvalid;                   ///< counters and masks: readContactCounters()
                                            ///< and kernels/contact/layouts/contact_records.hlsli
  BufferId colliders = BufferId::kInvalid;  ///< Collider
  BufferId sdfs = BufferId::kInvalid;       ///< Sdf, of colliders in range
  BufferId bindRoots = BufferId::kInvalid;  ///< [guide] Float4, bind position of vertex 0
  BufferId rootBindings = BufferId::kInvalid;    ///< [guide] RootBinding
  BufferId boneTransforms = BufferId::kInvalid;  ///< 3 (matrices) or 2 (dual quaternions) Float4
                                                 ///< each; the skeleton's if the object follows one
  BufferId followHairRecords = BufferId::kInvalid;  ///< [follow] FollowHairRecord
  BufferId followBefore = BufferId::kInvalid;       ///< [2][follow][vertex] Float4, if follow hairs
                                                    ///< collide: as drawn, and as posed before
  BufferId followContactWords = BufferId::kInvalid;  ///< see readFollowContactCounters()
  BufferId strandThickness = BufferId::kInvalid;     ///< [strand] float
  BufferId indices = BufferId::kInvalid;             ///< one strand's ribbon, uint32
  BufferId vertexColors = BufferId::kInvalid;  ///< [guide][vertex] linear rgba, 4 unorms of 16 bits
  BufferId previousPositions =
      BufferId::kInvalid;  ///< HairObject::tracksMotion: `positions` from before the last
                           ///< simulation with dt > 0; in the frame of a reset those from after it.
                           ///< With HairObject::interpolates: `drawnPositions` of the frame of
                           ///< interpolate() before the last one
  BufferId baseTexture = BufferId::kInvalid;  ///< [y][x] as vertexColors, then [guide] Float2: UV
  BufferId strandUvs = BufferId::kInvalid;  ///< HairDef::strandUvs: [guide] Float4, xy = UV of the
                                            ///< root, z = distance between neighboring roots [m],
                                            ///< w = change of the UV along the surface [1/m]
  BufferId drawnPositions = BufferId::kInvalid;  ///< HairObject::interpolates: `positions` as
                                                 ///< Frame::interpolate() has placed them last
  BufferId drawnTangents = BufferId::kInvalid;   ///< likewise
  BufferId drawnRoots = BufferId::kInvalid;  ///< likewise of rootTransforms(): now and before; only
                                             ///< with follow hairs that are not stored
};

/// All buffers of a hair object.
struct HairBuffers : HairOutputs {
  BufferId forces = BufferId::kInvalid;  ///< [guide][vertex] Float4, yours: see setForces()
};

}  // namespace pelage
