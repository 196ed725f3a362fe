// Hair grown on a surface: where its roots are, and the paths of its strands.
#pragma once

#include <cstdint>
#include <vector>

#include "pelage/collision_mesh.h"
#include "pelage/demo/groom.h"
#include "pelage/random.h"
#include "surface_net.h"

namespace pelage::detail {

/// How far outside its ground every vertex but the root stays [m].
inline constexpr double kHairClearance = 0.0006;

/// The surface on which hair grows and is combed. Distances as those of Solid.
class HairGround {
 public:
  virtual ~HairGround() = default;
  virtual double surface(const Vector& p) const = 0;
  virtual Vector normal(const Vector& p) const = 0;
  /// The same together with parts that hair only glides over, like ears, smoothed.
  virtual double combedSurface(const Vector& p) const { return surface(p); }
  virtual Vector combedNormal(const Vector& p) const { return normal(p); }
  /// Away from the ground without what hair does not grow on.
  virtual Vector rootNormal(const Vector& p) const { return normal(p); }
  /// Whether hair grows at a point of the surface.
  virtual bool grows(const Vector& p) const = 0;
  /// Where hair at a point is combed to: a unit vector along the surface.
  virtual Vector combDirection(const Vector& p, const Vector& normal) const = 0;
  /// 1 where hair is lifted and lies over that of the rest, 0 where it lies under it.
  virtual double height(const Vector& root) const = 0;
  /// Factor on the length of a strand, by its root, > 0.
  virtual double lengthShare(const Vector& /*root*/) const { return 1; }
  /// How far inside the edge of the hair a root is [m].
  virtual double insideEdge(const Vector& /*root*/) const { return 1; }
};

struct HairRoot {
  Vector position;
  Vector normal;
};

struct HairRoots {
  std::vector<HairRoot> roots;  ///< in random order; empty where nothing grows
  double spacing = 0;           ///< no two are closer than this [m]
};

/// Roots on a mesh of the ground: a Poisson-disc sample that covers it.
HairRoots sampleRoots(const CollisionMesh& mesh, const HairGround& ground, uint32_t count,
                      Random& random);

using Path = std::vector<Vector>;

/// The locks that strands gather in.
struct Clumps {
  std::vector<uint32_t> of;        ///< [strand] central strand of its lock
  std::vector<double> fromCenter;  ///< [strand] from the center of the lock, 0, to its edge, 1
  std::vector<uint32_t> centers;   ///< the central strands
  std::vector<uint32_t> curlOf;    ///< [central strand] its number in `centers`
};

/// The strands of a definition that is valid, at roots as many as it has strands. Of the
/// definition, `style`, `hairline` and `stripWidth` are the ground's.
class HairGrower {
 public:
  HairGrower(const GroomDef& def, const HairGround& ground, const std::vector<HairRoot>& roots);

  /// The vertices of a strand; none but the root is closer to the ground than kHairClearance.
  Path strand(uint32_t index) const;
  /// Factor on the radius of a strand, 1 - GroomDef::thicknessVariation to 1.
  float thickness(uint32_t index) const;

 private:
  double edgeShare(const Vector& root) const;
  double clumpShare(uint32_t strand) const;

  const GroomDef& def_;
  const HairGround& ground_;
  std::vector<double> lengths_;
  std::vector<double> thickness_;  // [strand]
  std::vector<Path> paths_;
  Clumps clumps_;
  std::vector<Path> curls_;  // [Clumps::curlOf]
};

}  // namespace pelage::detail
