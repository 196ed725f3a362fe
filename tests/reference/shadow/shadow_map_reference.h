// Shadow maps of strands, and their transmittance at receivers, in double precision.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "reference/shadow/strand_shadow_reference.h"

namespace pelage::reference {

/// From the world to a map of one face: with w = w . (p, 1), texel = xy . (p, 1) / w, and z . (p,
/// 1) is the distance behind the near plane.
struct ShadowProjection {
  Eigen::Vector4d x, y, z, w;
  uint32_t width = 0, height = 0;
  double texelSize = 0;                  ///< where w is 1 [m]
  std::optional<Eigen::Vector3d> light;  ///< position of a light that is not parallel
};

/// How receivers read it.
struct ShadowReading {
  uint32_t layers = 0;
  double layerRange = 0, bias = 0, extinction = 0;
};

class ShadowMapReference {
 public:
  ShadowMapReference(const ShadowProjection& projection, std::span<const ShadowFiber> fibers);
  /// Share of the light that arrives at a point, 0..1; layers are those of docs/shadow.md.
  double light(const Eigen::Vector3d& point, const ShadowReading& reading) const;

 private:
  struct Texel {
    double nearest;
    std::vector<std::pair<double, double>> parts;  ///< depth and optical depth
  };
  void add(const ShadowFiber& fiber);
  double depthAt(int x, int y, double depth, const ShadowReading& reading) const;

  ShadowProjection projection_;
  std::vector<Texel> texels_;
};

}  // namespace pelage::reference
