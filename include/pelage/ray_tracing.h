// Strands as inputs of acceleration structures, for engines that trace rays: triangles, or
// positions with radii. A library of its own, pelage::ray_tracing; docs/ray_tracing.md.
#pragma once

#include <cstdint>
#include <string>

#include "pelage/binding.h"
#include "pelage/hair_object.h"
#include "pelage/kernel_code.h"
#include "pelage/pass_list.h"
#include "pelage/result.h"

namespace pelage {

enum class RayGeometryKind : uint8_t {
  /// A position and a radius a vertex, 2 indices a segment, for
  /// VK_GEOMETRY_TYPE_LINEAR_SWEPT_SPHERES_NV with VK_RAY_TRACING_LSS_INDEXING_MODE_LIST_NV, or for
  /// curves that an engine makes of them.
  kSpheres,
  /// Disjoint orthogonal triangle strips: two quads at right angles a segment, 8 vertices and 12
  /// indices, for VK_GEOMETRY_TYPE_TRIANGLES_KHR. An application for a patent covers them
  /// (docs/ray_tracing.md), so they are not the default.
  kTriangles,
};

struct RayGeometryDef {
  RayGeometryKind kind = RayGeometryKind::kSpheres;
  /// Share of the strands, > 0..1: the first ones, rounded up.
  float strandShare = 1;
  /// Segments of a strand, below its number of vertices: evenly chosen vertices, with both ends. 0:
  /// one between any two vertices.
  uint32_t segments = 0;
  /// Factor of all radii, > 0..1000: fewer strands cover as much if they are wider.
  float radiusScale = 1;
  std::string name = "rays";  ///< of the buffers, for debuggers
};

/// Buffers with the strands of one hair object, and the pass that fills them. Strands are those in
/// HairBuffers::positions: guides, and follow hairs with HairDef::storeFollowHairs. Numbers of
/// vertices and indices never change, so a structure can be updated in place.
///
/// Threads: as a standard container.
class RayGeometry {
 public:
  /// Adds the buffers to the scene's table; indices are in them from the beginning. Give the
  /// runtime buffers of your own for them if your API needs other usages (acceleration structures
  /// do: docs/ray_tracing.md). Errors: a def out of range, buffers of 4 GB or more.
  static Result<RayGeometry> create(ResourceTable& resources, const HairObject& hair,
                                    const RayGeometryDef& def);
  /// Removes the buffers.
  void remove(ResourceTable& resources);

  /// Adds the pass that writes positions (and radii) from the strands as they are behind the passes
  /// before it: call it with Frame::addList(). Radii are those of the object's material and
  /// thickness. Errors: another object than that of create().
  Result<void> addPass(const HairObject& hair, PassList& list) const;

  /// [vertex] three floats, stride 12: VK_FORMAT_R32G32B32_SFLOAT [m], world space.
  BufferId positions() const { return positions_; }
  /// [vertex] float, stride 4 [m]; kInvalid for triangles.
  BufferId radii() const { return radii_; }
  /// uint32.
  BufferId indices() const { return indices_; }
  uint32_t vertexCount() const { return vertexCount_; }
  uint32_t indexCount() const { return indexCount_; }
  uint32_t strandCount() const { return strandCount_; }
  uint32_t segmentsPerStrand() const { return segments_; }
  /// Primitives of a geometry: triangles or segments.
  uint32_t primitiveCount() const { return indexCount_ / (isTriangles() ? 3 : 2); }

 private:
  bool isTriangles() const { return kind_ == RayGeometryKind::kTriangles; }

  RayGeometryKind kind_ = RayGeometryKind::kSpheres;
  BufferId source_ = BufferId::kInvalid;  ///< HairBuffers::positions
  BufferId positions_ = BufferId::kInvalid, radii_ = BufferId::kInvalid;
  BufferId indices_ = BufferId::kInvalid;
  float radiusScale_ = 1;
  uint32_t strandCount_ = 0, segments_ = 0, vertexCount_ = 0, indexCount_ = 0;
};

/// The code of this library's kernels, for RuntimeDef::code or Runtime::addCode().
KernelCodeList rayTracingCode();

}  // namespace pelage
