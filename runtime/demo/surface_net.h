// Closed meshes of implicit surfaces.
#pragma once

#include <cstdint>
#include <vector>

#include "base/vector3.h"
#include "pelage/types.h"

namespace pelage::detail {

using Vector = Vector3<double>;

/// A body by its surface.
class Solid {
 public:
  virtual ~Solid() = default;
  /// Signed distance [m], negative inside; exact at the surface, and within some cells of it at
  /// most twice too large.
  virtual double distance(const Vector& p) const = 0;
  /// Unit vector along which distance() grows.
  virtual Vector normal(const Vector& p) const = 0;
};

/// A box that holds a solid with some cells to spare.
struct SolidBox {
  Vector low, high;
};

struct SurfaceMesh {
  std::vector<Vector> vertices;   ///< on the surface, as nearly as cells allow
  std::vector<uint32_t> indices;  ///< three a triangle, counter-clockwise seen from outside
};

/// Meshes a solid; one that is alike on both sides of the middle of its box gets a mesh that is,
/// too. Each edge joins two triangles. Memory goes with the number of cells in the box.
SurfaceMesh meshSolid(const Solid& solid, const SolidBox& box, double cellSize);

}  // namespace pelage::detail
