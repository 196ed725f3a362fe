// The mesh colliders of a scene: their buffers, and the passes that build their fields.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "base/bone_moves.h"
#include "base/bounds.h"
#include "base/local_origin.h"
#include "passes/buffer_factory.h"
#include "pelage/camera.h"
#include "pelage/collision_mesh.h"
#include "pelage/gpu_structs.h"
#include "pelage/ids.h"
#include "pelage/light.h"
#include "pelage/pass_list.h"
#include "pelage/result.h"
#include "pelage/sdf_collider.h"
#include "sdf/sdf_collider.h"

namespace pelage::detail {

/// Where hair can be in a frame, and which colliders it meets there.
struct HairReach {
  Ball ball;
  const HostArray<ColliderId>* only = nullptr;  ///< ascending; nullptr: all
};

/// Bones that a collider follows, of its own or of a skeleton.
struct ColliderBones {
  SkeletonInternals* skeleton = nullptr;
  uint32_t count = 1;
};

class SdfRoom {
 public:
  /// Errors: as of Scene::addCollider(), but for those of skeletons.
  Result<ColliderId> add(const CollisionMesh& mesh, const SdfColliderDef& def,
                         const ColliderBones& bones, const Vector3<double>& shifted,
                         const BufferFactory& factory);
  Result<ColliderId> add(const SdfData& data, const SdfColliderDef& def,
                         const Vector3<double>& shifted, const BufferFactory& factory);
  ColliderId add(const DenseSdf& sdf, const SdfColliderDef& def, const Vector3<double>& shifted,
                 const BufferFactory& factory);
  void remove(ColliderId id, const BufferFactory& factory);
  /// Sizes of a collider's own buffers, and of its part of keys and surface.
  struct Bytes {
    uint64_t own = 0, shared = 0;
  };
  Bytes bytesOf(ColliderId id, const BufferFactory& factory);
  /// Removes what only drawing a collider has made.
  void trim(const BufferFactory& factory);

  /// Errors: settings out of range, the vertex buffer of an engine, a grid over the memory cap.
  Result<void> check(std::span<const HairReach> hair, const BufferFactory& factory);
  /// Takes the grids of check(), and makes the buffers that are too small for them anew.
  void plan(const BufferFactory& factory);
  /// Adds the passes that build the fields that hair can reach and that have moved.
  Result<void> record(std::span<const HairReach> hair, const BufferFactory& factory,
                      PassList& list);
  struct InReach {
    std::vector<Sdf> sdfs;
    bool rebuilt = false;  ///< one of them, in this frame
    bool dense = false;    ///< one of them is an engine's
  };
  /// The fields of the frame that hair can reach, relative to an origin. They stay until the next
  /// call. \param hair  nullptr: none
  const InReach& inReach(const HairReach* hair, const LocalOrigin& origin);
  /// The way of the fastest field in reach in this frame, in its cells.
  /// \param enough  the same: ways up to this one need not be the least of the hair's moves
  double wayInCells(const HairReach& hair, const BoneMoves& moves, double enough) const;

  Result<SdfData> copy(ColliderId id, std::span<const std::byte> keys,
                       std::span<const std::byte> surface) const;
  Result<void> draw(ColliderId id, const View& view, const Light& light, const ColliderLook& look,
                    const BufferFactory& factory, PassList& list);
  Result<void> checkDraw(ColliderId id, std::span<const std::byte> counts) const;

  Slots<ColliderId, SdfCollider> colliders;
  /// Keys and records of all fields; kInvalid without any.
  BufferId keys = BufferId::kInvalid, surface = BufferId::kInvalid;

 private:
  static std::vector<BufferId*> buffersOf(SdfColliderBuffers& buffers, bool hasSkeleton);
  static void addTables(SdfCollider& collider, const BufferFactory& factory);
  static void addSkinningBuffers(SdfCollider& collider, const CollisionMesh& mesh,
                                 const BufferFactory& factory);
  static bool planCollider(SdfCollider& collider, const SdfGridPlan& plan,
                           const BufferFactory& factory);
  static void removeIsoSurface(SdfCollider& collider, const BufferFactory& factory);
  void layOut(const BufferFactory& factory);
  bool isInRange(size_t slot, std::span<const HairReach> hair) const;
  Result<void> build(SdfCollider& collider, const BufferFactory& factory, PassList& list);
  Result<void> import(SdfColliderInternals& collider, const BufferFactory& factory,
                      PassList& list) const;

  InReach inReach_;
  /// [collider] the grid that one needs in a frame; nothing where it has one that does.
  std::vector<std::optional<SdfGridPlan>> plans_;
};

}  // namespace pelage::detail
