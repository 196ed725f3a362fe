// How far one surface is from another, measured and not sampled.
#pragma once

#include <cstdint>
#include <span>

#include "pelage/types.h"
#include "triangle_tree.h"

namespace pelage::detail {

/// The true value is between the two [m].
struct DistanceBounds {
  double lower = 0, upper = 0;
};

/// Largest distance of any point of the triangles from the surface of `to` (the one-sided Hausdorff
/// distance). A triangle is split in four until its bound is within `tolerance` of the largest
/// distance found: all of a triangle is at most as far from another one as its corners are, because
/// the distance from a convex set is a convex function. Where two of the others meet, the triangle
/// is cut at their edge, and each side is held against its own.
/// \param tolerance  > 0 [m]; upper - lower stays below it unless ten million searches do not do
/// \param known      a distance below which nothing matters; the result is at least that [m]
/// \param stopAbove  gives up as soon as `lower` is above it [m]
DistanceBounds maxDistance(std::span<const Float3> positions, std::span<const uint32_t> indices,
                           const TriangleTree& to, double tolerance, double stopAbove,
                           double known = 0);

}  // namespace pelage::detail
