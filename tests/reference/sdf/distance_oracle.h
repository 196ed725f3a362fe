// The signed distance to a triangle mesh in double precision: closest point by a tree of boxes,
// sign by the generalised winding number. It says what the fields of the kernels are held to.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <span>
#include <vector>

#include "pelage/types.h"
#include "reference/sdf/mesh_shapes.h"

namespace pelage::reference {

using Eigen::Vector3d;

inline Vector3d toDouble(const Float3& p) { return {p.x, p.y, p.z}; }

/// The part of a triangle that a point is closest to.
enum class TriangleFeature { kFace, kEdge01, kEdge12, kEdge20, kVertex0, kVertex1, kVertex2 };

struct ClosestPoint {
  double distance;    ///< >= 0; infinite when the mesh has nothing as near as was asked for
  Vector3d point;     ///< on the triangle
  uint32_t triangle;  ///< of the mesh as it was given; the lowest of those equally far
  TriangleFeature feature;
};

/// The closest point of one triangle.
ClosestPoint closestOnTriangle(const Vector3d& p, const Vector3d& a, const Vector3d& b,
                               const Vector3d& c);

/// Triangles with a corner that is not finite and triangles without area are left out, as the
/// kernels do.
class DistanceOracle {
 public:
  DistanceOracle(std::span<const Float3> positions, std::span<const uint32_t> indices);
  explicit DistanceOracle(const TriangleMesh& mesh)
      : DistanceOracle(mesh.positions, mesh.indices) {}

  /// \param reach  nothing further away is looked for
  ClosestPoint closest(const Vector3d& p, double range = 1e300) const;

  /// How often the surface goes round p [Jacobson et al. 2013, equation 5], as a plain sum.
  double windingNumber(const Vector3d& p) const;
  /// The same, far groups of triangles as dipoles [Barill et al. 2018]: off by less than 0.1.
  double fastWindingNumber(const Vector3d& p) const;
  /// Winding number above 1/2. The fast sum decides where it can.
  bool isInside(const Vector3d& p) const;

  /// Negative inside.
  double signedDistance(const Vector3d& p) const;

  /// Fast when points that follow each other are close in space.
  /// Where nothing is within `range`, the result is +-range.
  std::vector<double> signedDistances(std::span<const Vector3d> points, double range = 1e300) const;

  /// At the nodes of a grid, x fastest.
  std::vector<double> gridDistances(const Vector3d& origin, double cell, const uint32_t (&nodes)[3],
                                    double range = 1e300) const;

  /// Whether every edge has as many triangles on the one side as on the other: then the winding
  /// number is whole and changes at the surface alone.
  bool isClosed() const { return closed_; }
  uint32_t triangleCount() const { return static_cast<uint32_t>(triangles_.size()); }

 private:
  struct Triangle {
    Vector3d a, b, c;
    uint32_t index;
  };
  // A node is followed by its first child.
  struct Node {
    Vector3d low, high;
    Vector3d dipole, centre;  // sum of area normals; their mean position
    double radius;            // from the centre, of all corners
    uint32_t begin, end;      // triangles
    uint32_t second;          // child; 0 at a leaf
  };

  uint32_t addNode(uint32_t begin, uint32_t end);
  double distanceAndSide(const Vector3d& p, double range, const Vector3d* last,
                         double lastDistance) const;

  std::vector<Triangle> triangles_;
  std::vector<Node> nodes_;
  bool closed_ = false;
};

}  // namespace pelage::reference
