// Reference for motion in a plane: an inextensible chain in absolute angles, with a dense mass
// matrix and the classical Runge-Kutta method. It shares no formula with the exact solver.
#pragma once

#include <functional>
#include <vector>

#include "rest_strand.h"

namespace pelage::rod {

/// Chain in the x-y plane under gravity along -y. Vertex 0 and edge 0 are fixed; vertex i has the
/// mass of its region (unit linear density).
class PlanarChain {
 public:
  /// \param bend  B = E I / (rho A) [m4/s2]
  /// \param drag  air drag [1/s]
  /// \param gravity  magnitude [m/s2]
  PlanarChain(const RestStrand& rest, double bend, double drag, double gravity);

  /// One Runge-Kutta step of h seconds.
  void step(double h);
  std::vector<Vector3d> positions() const;
  /// Kinetic, potential and bending energy for unit linear density [m3/s2].
  double energy() const;

 private:
  std::vector<double> accelerations(const std::vector<double>& angles,
                                    const std::vector<double>& rates) const;
  double bendAngle(const std::vector<double>& angles, int vertex) const;

  int edges_;
  Vector3d root_;
  std::vector<double> lengths_, voronoiLengths_, restAngles_;
  std::vector<double> outerMass_;  // [edge] of the vertices beyond it
  double bend_, drag_, gravity_;
  std::vector<double> angles_, rates_;
};

}  // namespace pelage::rod
