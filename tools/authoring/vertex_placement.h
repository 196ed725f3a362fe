// Where on a curve the vertices of a strand go.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "pelage/authoring/hair_curves.h"
#include "polyline.h"

namespace pelage::detail {

/// A curve, ready for being sampled. Points may be repeated.
struct Curve {
  std::vector<Vector> points;
  std::vector<double> arc;  ///< arcLengths()
  double length() const { return arc.back(); }
};

/// Arc lengths of `count` (2..256) vertices, ascending from 0 to the curve's length. `curve` has
/// some length.
std::vector<double> pointVertices(const Curve& curve, uint32_t count, VertexPlacement placement);

}  // namespace pelage::detail
