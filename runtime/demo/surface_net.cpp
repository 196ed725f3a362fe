#include "surface_net.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>
#include <vector>

namespace pelage::detail {

namespace {

// Distances of a solid at the nodes of a grid.
class SolidNodes {
 public:
  SolidNodes(const Solid& solid, const SolidBox& box, double cellSize)
      : solid_(solid), cell_(cellSize) {
    const Vector size = box.high - box.low;
    for (size_t axis = 0; axis < 3; ++axis) {
      const double extent = axis == 0 ? size.x : axis == 1 ? size.y : size.z;
      // The middle plane x = 0 is half-way between nodes, so that both halves are alike.
      count_[axis] = 2 * static_cast<size_t>(std::ceil(extent / (2 * cell_))) + 2;
    }
    origin_ = (box.low + box.high) * 0.5 -
              Vector{node(count_[0] - 1), node(count_[1] - 1), node(count_[2] - 1)} * 0.5;
    sample();
    resolveAmbiguousFaces();
  }

  size_t size() const { return values_.size(); }
  size_t count(size_t axis) const { return count_[axis]; }
  size_t at(size_t i, size_t j, size_t k) const { return (k * count_[1] + j) * count_[0] + i; }
  double value(size_t i, size_t j, size_t k) const { return values_[at(i, j, k)]; }
  Vector point(size_t i, size_t j, size_t k) const {
    return origin_ + Vector{node(i), node(j), node(k)};
  }

 private:
  static constexpr size_t kBlock = 4;  // nodes an edge

  double node(size_t i) const { return static_cast<double>(i) * cell_; }

  // Blocks of nodes that the surface cannot reach take the distance of their middle, of which only
  // the sign is used.
  void sample() {
    values_.resize(count_[0] * count_[1] * count_[2]);
    for (size_t k = 0; k < count_[2]; k += kBlock)
      for (size_t j = 0; j < count_[1]; j += kBlock)
        for (size_t i = 0; i < count_[0]; i += kBlock) sampleBlock(i, j, k);
  }

  void sampleBlock(size_t i0, size_t j0, size_t k0) {
    const double half = 0.5 * static_cast<double>(kBlock - 1) * cell_;
    const double middle = solid_.distance(point(i0, j0, k0) + Vector{half, half, half});
    // Half the diagonal and a cell, and as much again for distances that are too large.
    const bool isFar = std::abs(middle) > 2 * (1.7320508 * half + cell_);
    for (size_t k = k0; k < std::min(k0 + kBlock, count_[2]); ++k)
      for (size_t j = j0; j < std::min(j0 + kBlock, count_[1]); ++j)
        for (size_t i = i0; i < std::min(i0 + kBlock, count_[0]); ++i)
          values_[at(i, j, k)] = isFar ? middle : solid_.distance(point(i, j, k));
  }

  // Where the signs at a face's corners alternate, four quads would meet in one edge. The outer
  // corner nearest to the surface goes inside, until there is no such face.
  void resolveAmbiguousFaces() {
    const size_t strides[3] = {1, count_[0], count_[0] * count_[1]};
    bool changed = true;
    while (changed) {
      changed = false;
      for (size_t k = 0; k + 1 < count_[2]; ++k)
        for (size_t j = 0; j + 1 < count_[1]; ++j)
          for (size_t i = 0; i + 1 < count_[0]; ++i)
            for (size_t axis = 0; axis < 3; ++axis)
              changed |= resolveFace(at(i, j, k), strides[axis], strides[(axis + 1) % 3]);
    }
  }

  bool resolveFace(size_t corner, size_t u, size_t v) {
    const size_t corners[4] = {corner, corner + u, corner + u + v, corner + v};
    for (size_t c = 0; c < 4; ++c)
      if ((values_[corners[c]] < 0) == (values_[corners[(c + 1) % 4]] < 0)) return false;
    // Always from outside to inside, so that this ends.
    const size_t first = values_[corners[0]] < 0 ? 1 : 0;
    const bool second = values_[corners[first + 2]] < values_[corners[first]];
    values_[corners[first + (second ? 2 : 0)]] = -1e-6 * cell_;
    return true;
  }

  const Solid& solid_;
  double cell_;
  size_t count_[3] = {};
  Vector origin_;
  std::vector<double> values_;
};

// The vertex of a cell that the surface crosses.
std::optional<Vector> vertexOf(const Solid& solid, const SolidNodes& nodes, double cellSize,
                               size_t i, size_t j, size_t k) {
  Vector sum;
  int crossings = 0;
  for (size_t a = 0; a < 8; ++a) {
    for (size_t axis = 0; axis < 3; ++axis) {
      const size_t b = a | size_t{1} << axis;
      if (b == a) continue;
      const double va = nodes.value(i + (a & 1), j + (a >> 1 & 1), k + (a >> 2));
      const double vb = nodes.value(i + (b & 1), j + (b >> 1 & 1), k + (b >> 2));
      if ((va < 0) == (vb < 0)) continue;
      const Vector pa = nodes.point(i + (a & 1), j + (a >> 1 & 1), k + (a >> 2));
      const Vector pb = nodes.point(i + (b & 1), j + (b >> 1 & 1), k + (b >> 2));
      sum += lerp(pa, pb, va / (va - vb));
      ++crossings;
    }
  }
  if (crossings == 0) return std::nullopt;
  Vector p = sum * (1.0 / crossings);
  // The mean lies beside the surface where that is curved; walk to it, but not out of the cell.
  for (int step = 0; step < 4; ++step) {
    const double d = solid.distance(p);
    const double limit = 0.2 * cellSize;
    p -= solid.normal(p) * std::min(std::max(d, -limit), limit);
  }
  return p;
}

void addQuad(SurfaceMesh& mesh, std::array<uint32_t, 4> quad) {
  const double ac = length(mesh.vertices[quad[0]] - mesh.vertices[quad[2]]);
  const double bd = length(mesh.vertices[quad[1]] - mesh.vertices[quad[3]]);
  const size_t first = ac <= bd ? 0 : 1;  // cut along the shorter diagonal
  for (const size_t corner : {size_t{0}, size_t{1}, size_t{2}, size_t{0}, size_t{2}, size_t{3}})
    mesh.indices.push_back(quad[(first + corner) % 4]);
}

// A quad around each edge of the grid that the surface crosses.
// \param cellVertex  by the cell's lowest node
void addQuads(const SolidNodes& nodes, const std::vector<uint32_t>& cellVertex, SurfaceMesh& mesh) {
  const auto quad = [&](size_t a, size_t b, size_t c, size_t d, bool inside) {
    addQuad(mesh, inside ? std::array{cellVertex[a], cellVertex[b], cellVertex[c], cellVertex[d]}
                         : std::array{cellVertex[a], cellVertex[d], cellVertex[c], cellVertex[b]});
  };
  const auto at = [&](size_t i, size_t j, size_t k) { return nodes.at(i, j, k); };
  for (size_t k = 1; k + 1 < nodes.count(2); ++k)
    for (size_t j = 1; j + 1 < nodes.count(1); ++j)
      for (size_t i = 1; i + 1 < nodes.count(0); ++i) {
        const bool inside = nodes.value(i, j, k) < 0;
        // The four cells around the edge that leaves this node, in turn about the axis.
        if (inside != (nodes.value(i + 1, j, k) < 0))
          quad(at(i, j - 1, k - 1), at(i, j, k - 1), at(i, j, k), at(i, j - 1, k), inside);
        if (inside != (nodes.value(i, j + 1, k) < 0))
          quad(at(i - 1, j, k - 1), at(i - 1, j, k), at(i, j, k), at(i, j, k - 1), inside);
        if (inside != (nodes.value(i, j, k + 1) < 0))
          quad(at(i - 1, j - 1, k), at(i, j - 1, k), at(i, j, k), at(i - 1, j, k), inside);
      }
}

}  // namespace

// Naive surface nets (Gibson 1998, "Constrained Elastic Surface Nets"): a vertex in each cell that
// the surface crosses, a quad around each grid edge that it crosses.
SurfaceMesh meshSolid(const Solid& solid, const SolidBox& box, double cellSize) {
  const SolidNodes nodes(solid, box, cellSize);
  SurfaceMesh mesh;
  std::vector<uint32_t> cellVertex(nodes.size(), std::numeric_limits<uint32_t>::max());
  for (size_t k = 0; k + 1 < nodes.count(2); ++k)
    for (size_t j = 0; j + 1 < nodes.count(1); ++j)
      for (size_t i = 0; i + 1 < nodes.count(0); ++i) {
        const std::optional<Vector> vertex = vertexOf(solid, nodes, cellSize, i, j, k);
        if (!vertex) continue;
        cellVertex[nodes.at(i, j, k)] = static_cast<uint32_t>(mesh.vertices.size());
        mesh.vertices.push_back(*vertex);
      }
  addQuads(nodes, cellVertex, mesh);
  return mesh;
}

}  // namespace pelage::detail
