// The meshes that distance fields are measured with.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "pelage/result.h"
#include "pelage/types.h"
#include "reference/sdf/mesh_shapes.h"

namespace bench {

struct SdfShape {
  std::string name;
  pelage::reference::TriangleMesh mesh;
  std::vector<uint32_t> cells;  ///< along x that it is measured with
  bool hasHair = false;         ///< collisions are measured, too
};

/// The extent along x over a number of cells [m].
float cellSizeOf(const SdfShape& shape, uint32_t cells);

/// Sphere, torus, a plate of 1.2 and one of 0.3 cells at 50 cells, a cube of 12 triangles, a sphere
/// with holes, spheres that overlap.
std::vector<SdfShape> generatedShapes();

/// The body and the left hand in a data folder. Those that are not there are left out, and named on
/// the standard output.
pelage::Result<std::vector<SdfShape>> realShapes(const std::filesystem::path& data);

/// Hair that grows out of a shape along its normals: strands of 32 vertices, in the order of the
/// triangles they grow from, as many a triangle as its area has. w = 1.
/// \param count     vertices, a multiple of 32
/// \param from,to   of a strand's ends from the surface [m], negative inside
std::vector<pelage::Float4> hairVertices(const SdfShape& shape, uint32_t count, float from,
                                         float to);

}  // namespace bench
