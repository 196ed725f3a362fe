// The iso surface of an SDF as a mesh on the GPU, by marching cubes, and its drawing:
// kernels/sdf/marching_cubes*, kernels/shading/iso_surface_*. For debugging.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>

#include "pelage/camera.h"
#include "pelage/gpu_structs.h"
#include "pelage/light.h"
#include "pelage/pass_list.h"
#include "pelage/result.h"
#include "pelage/types.h"

namespace pelage::detail {

/// Nodes along the axes, as Sdf::nodes.
using GridSize = std::array<uint32_t, 3>;

/// The capacity of the mesh.
struct IsoSurfaceCapacity {
  uint32_t vertices = 0;
  uint32_t triangles = 0;
};

/// Returns a capacity for most shapes in a grid of this size: twice the size of a sphere that fills
/// it.
IsoSurfaceCapacity defaultIsoSurfaceCapacity(const GridSize& nodes);

/// The mesh of one field, which stays on the GPU.
class IsoSurface {
 public:
  /// Adds the buffers to a table. Errors: a grid that is larger than the kernels can number (rows
  /// of 5460 nodes, 2^28 nodes), a capacity whose buffers no device has.
  static Result<IsoSurface> create(ResourceTable& resources, const std::string& name,
                                   const GridSize& nodes, const IsoSurfaceCapacity& capacity);
  /// Returns true if a grid of this size fits.
  bool hasRoomFor(const GridSize& nodes) const;
  /// Adds the passes that make the mesh of an SDF. A grid that does not fit gives no mesh, and an
  /// error of checkCounts().
  /// \param keys     [keyCount] of uint32, those of all fields
  /// \param isoLevel [cell], of magnitude below the field's band; else there is no surface.
  Result<void> addPasses(const Sdf& sdf, BufferId keys, uint32_t keyCount, float isoLevel,
                         PassList& list) const;

  struct Look {
    Float3 color = {0.10f, 0.20f, 0.32f};  ///< linear RGB
    float opacity = 1;                     ///< 0..1; below 1 it hides nothing behind it
    AffineTransform sdfToWorld;            ///< a rigid map
  };
  /// Adds the draw of the mesh from the last passes.
  Result<void> addDraw(const View& view, const Light& light, const Look& look,
                       PassList& list) const;

  /// Checks counts(), read back. Errors: the mesh was larger than the capacity and is not complete,
  /// or the grid was larger than create() was told; the message names the required size.
  Result<IsoSurfaceCapacity> checkCounts(std::span<const std::byte> counts) const;

  /// MarchingCounts, IsoVertex, and three indices per triangle; index 0 after the last triangle.
  BufferId counts() const { return buffers_[kCounts]; }
  BufferId vertices() const { return buffers_[kVertices]; }
  BufferId indices() const { return buffers_[kIndices]; }
  /// All buffers, for removing them from the table.
  const std::array<BufferId, 6>& buffers() const { return buffers_; }

 private:
  enum Buffer : size_t { kField, kRows, kNodes, kCounts, kVertices, kIndices };

  std::string name_;
  IsoSurfaceCapacity capacity_;
  uint32_t rowCapacity_ = 0, nodeCapacity_ = 0;
  std::array<BufferId, 6> buffers_ = {};
};

}  // namespace pelage::detail
