// Triangle meshes of known shape, and the defects that meshes of artists have. The same call gives
// the same mesh every time.
#pragma once

#include <cstdint>
#include <vector>

#include "pelage/types.h"

namespace pelage::reference {

struct TriangleMesh {
  std::vector<Float3> positions;
  std::vector<uint32_t> indices;  ///< three a triangle, counter-clockwise seen from outside

  uint32_t triangleCount() const { return static_cast<uint32_t>(indices.size() / 3); }
  bool operator==(const TriangleMesh&) const = default;
};

/// Rings of quads between two poles. \param rings >= 2  \param segments >= 3
TriangleMesh sphere(float radius, uint32_t rings, uint32_t segments, Float3 centre = {});

/// Around the z axis. \param around,across segments, >= 3
TriangleMesh torus(float majorRadius, float minorRadius, uint32_t around, uint32_t across);

/// 12 triangles.
TriangleMesh box(Float3 lowest, Float3 highest);
TriangleMesh cube(float edge);

/// A box of width x width x thickness, its large sides of `cells` x `cells` quads, turned about a
/// skew axis by `angle` [rad].
TriangleMesh plate(float width, float thickness, uint32_t cells, float angle = 0);

/// A sphere without every `period`-th triangle.
TriangleMesh sphereWithHoles(float radius, uint32_t rings, uint32_t segments, uint32_t period);

/// Two spheres whose centres are `distance` apart along x, the second not cut from the first.
TriangleMesh overlappingSpheres(float radius, float distance, uint32_t rings, uint32_t segments);

/// An ellipsoid with waves, about 2 x 1.4 x 1 units large: a smooth shape without symmetry.
TriangleMesh blob(uint32_t rings, uint32_t segments);

/// Both, side by side in one mesh.
TriangleMesh joined(const TriangleMesh& a, const TriangleMesh& b);

TriangleMesh moved(TriangleMesh mesh, Float3 offset);
TriangleMesh scaled(TriangleMesh mesh, float factor);
TriangleMesh rotated(TriangleMesh mesh, Float3 axis, float angle);
TriangleMesh mirroredMesh(TriangleMesh mesh);

/// Every triangle with vertices of its own, as after an export with hard edges.
TriangleMesh unwelded(const TriangleMesh& mesh);

/// Every `period`-th triangle again at the end, with its corners rotated.
TriangleMesh withDuplicates(TriangleMesh mesh, uint32_t period);

/// With triangles without area: at every `period`-th triangle one that is a point, one that is an
/// edge there and back, and one whose corners lie on a line.
TriangleMesh withZeroArea(TriangleMesh mesh, uint32_t period);

/// One more triangle at the end, with a corner that is NaN and one that is infinite.
TriangleMesh withNaN(TriangleMesh mesh);

}  // namespace pelage::reference
