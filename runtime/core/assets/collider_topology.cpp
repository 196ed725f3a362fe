#include "assets/collider_topology.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <numeric>
#include <tuple>
#include <utility>

#include "base/bounds.h"
#include "base/errors.h"
#include "base/guard.h"
#include "base/vector3.h"

namespace pelage {
namespace detail {
namespace {

using Vector = Vector3<double>;

// A triangle below this value of twice the area over the square of the longest edge has no area: it
// is the rounding of three collinear points in float.
constexpr double kNoArea = 1e-9;

class Builder {
 public:
  Builder(std::span<const uint32_t> indices, uint32_t vertexCount,
          std::span<const Float3> positions)
      : indices_(indices), positions_(positions) {
    out_.report.vertexCount = vertexCount;
    out_.report.triangleCount = static_cast<uint32_t>(indices.size() / 3);
  }

  ColliderTopology build() {
    weld();
    takeTriangles();
    linkEdges();
    measureVolume();
    listCorners();
    return std::move(out_);
  }

 private:
  // Vertices with equal positions become one point, numbered by their first vertex. Vertices that
  // are not finite are not merged.
  void weld() {
    MeshReport& report = out_.report;
    std::vector<uint32_t> order(report.vertexCount);
    std::iota(order.begin(), order.end(), 0u);
    std::vector<uint32_t> first = order;  // [vertex] the first one of its point
    if (!positions_.empty()) {
      // + 0 makes both zeros equal.
      const auto key = [&](uint32_t v) {
        const Float3& p = positions_[v];
        return std::tuple(std::bit_cast<uint32_t>(p.x + 0.0f), std::bit_cast<uint32_t>(p.y + 0.0f),
                          std::bit_cast<uint32_t>(p.z + 0.0f));
      };
      std::sort(order.begin(), order.end(), [&](uint32_t a, uint32_t b) {
        return std::pair(key(a), a) < std::pair(key(b), b);
      });
      for (size_t i = 0; i < order.size(); ++i) {
        const uint32_t v = order[i];
        if (!isFinite(positions_[v]))
          ++report.nonFiniteVertices;
        else if (i > 0 && key(order[i - 1]) == key(v))
          first[v] = first[order[i - 1]];
      }
    }
    out_.weldedVertices.resize(report.vertexCount);
    for (uint32_t v = 0; v < report.vertexCount; ++v) {
      if (first[v] == v) {
        out_.weldedVertices[v] = out_.pointCount();
        out_.pointVertices.push_back(v);
      } else {
        out_.weldedVertices[v] = out_.weldedVertices[first[v]];
      }
    }
    report.weldedVertexCount = out_.pointCount();
  }

  std::array<uint32_t, 3> positionsOf(uint32_t sourceTriangle) const {
    std::array<uint32_t, 3> points{};
    for (size_t k = 0; k < 3; ++k)
      points[k] = out_.weldedVertices[indices_[size_t{sourceTriangle} * 3 + k]];
    return points;
  }

  bool hasArea(uint32_t sourceTriangle) const {
    Vector v[3];
    for (size_t k = 0; k < 3; ++k)
      v[k] = toVector(positions_[indices_[size_t{sourceTriangle} * 3 + k]]);
    const Vector a = v[1] - v[0], b = v[2] - v[0], c = v[2] - v[1];
    const double longest = std::max({dot(a, a), dot(b, b), dot(c, c)});
    return length(cross(a, b)) > kNoArea * longest;
  }

  void takeTriangles() {
    MeshReport& report = out_.report;
    // The first of several equal triangles stays; their corners may be rotated.
    std::vector<std::pair<std::array<uint32_t, 3>, uint32_t>> triples;
    std::vector<bool> taken(report.triangleCount);
    for (uint32_t t = 0; t < report.triangleCount; ++t) {
      std::array<uint32_t, 3> points = positionsOf(t);
      if (points[0] == points[1] || points[1] == points[2] || points[2] == points[0]) {
        ++report.degenerateTriangles;
        continue;
      }
      taken[t] = true;
      std::rotate(points.begin(), std::min_element(points.begin(), points.end()), points.end());
      triples.emplace_back(points, t);
    }
    std::sort(triples.begin(), triples.end());
    for (size_t i = 1; i < triples.size(); ++i)
      if (triples[i].first == triples[i - 1].first) {
        taken[triples[i].second] = false;
        ++report.duplicateTriangles;
      }
    for (uint32_t t = 0; t < report.triangleCount; ++t) {
      if (!taken[t]) continue;
      const auto corners = indices_.subspan(size_t{t} * 3, 3);
      out_.indices.insert(out_.indices.end(), corners.begin(), corners.end());
      out_.sourceTriangles.push_back(t);
      if (positions_.empty()) continue;
      if (!std::all_of(corners.begin(), corners.end(),
                       [&](uint32_t v) { return isFinite(positions_[v]); }))
        ++report.nonFiniteTriangles;
      else if (!hasArea(t))
        ++report.degenerateTriangles;
    }
    report.usedTriangleCount = out_.triangleCount();
  }

  void linkEdges() {
    struct Edge {
      uint32_t low, high;  // points
      uint32_t corner;     // where it starts
      bool rising;
    };
    std::vector<Edge> edges;
    edges.reserve(out_.indices.size());
    for (uint32_t c = 0; c < out_.indices.size(); ++c) {
      const uint32_t next = c % 3 == 2 ? c - 2 : c + 1;
      const uint32_t from = out_.weldedVertices[out_.indices[c]];
      const uint32_t to = out_.weldedVertices[out_.indices[next]];
      edges.push_back({std::min(from, to), std::max(from, to), c, from < to});
    }
    std::sort(edges.begin(), edges.end(), [](const Edge& a, const Edge& b) {
      return std::tie(a.low, a.high, a.corner) < std::tie(b.low, b.high, b.corner);
    });
    MeshReport& report = out_.report;
    bool even = true;
    out_.adjacency.assign(out_.indices.size(), ColliderTopology::kNone);
    for (size_t begin = 0, end = 0; begin < edges.size(); begin = end) {
      int balance = 0;
      while (end < edges.size() && edges[end].low == edges[begin].low &&
             edges[end].high == edges[begin].high)
        balance += edges[end++].rising ? 1 : -1;
      const size_t uses = end - begin;
      if (uses == 1) ++report.openEdges;
      if (uses > 2) ++report.nonManifoldEdges;
      if (std::abs(balance) > 1) ++report.misorientedEdges;
      even = even && uses % 2 == 0;
      if (uses != 2) continue;
      out_.adjacency[edges[begin].corner] = edges[begin + 1].corner / 3;
      out_.adjacency[edges[begin + 1].corner] = edges[begin].corner / 3;
    }
    report.closed = even && report.nonFiniteTriangles == 0 && !edges.empty();
    report.consistentlyOriented = report.misorientedEdges == 0;
  }

  void measureVolume() {
    if (positions_.empty()) return;
    MeshReport& report = out_.report;
    // Relative to a point of the mesh, so that a distant mesh keeps its digits.
    Vector anchor;
    bool anchored = false;
    double sum = 0;
    for (size_t i = 0; i < out_.indices.size(); i += 3) {
      Vector v[3];
      bool finite = true;
      for (size_t k = 0; k < 3; ++k) {
        const Float3& p = positions_[out_.indices[i + k]];
        finite = finite && isFinite(p);
        v[k] = toVector(p);
      }
      if (!finite) continue;
      if (!anchored) anchor = v[0];
      anchored = true;
      sum += dot(v[0] - anchor, cross(v[1] - anchor, v[2] - anchor));
    }
    report.volume = sum / 6;
    report.inverted = out_.isSolid() && report.volume < 0;
    if (!report.inverted) return;
    for (size_t i = 0; i < out_.indices.size(); i += 3) {
      std::swap(out_.indices[i + 1], out_.indices[i + 2]);
      std::swap(out_.adjacency[i], out_.adjacency[i + 2]);
    }
  }

  void listCorners() {
    out_.pointOffsets.assign(size_t{out_.pointCount()} + 1, 0);
    for (const uint32_t vertex : out_.indices)
      ++out_.pointOffsets[size_t{out_.weldedVertices[vertex]} + 1];
    std::partial_sum(out_.pointOffsets.begin(), out_.pointOffsets.end(), out_.pointOffsets.begin());
    out_.pointCorners.resize(out_.indices.size());
    std::vector<uint32_t> next(out_.pointOffsets.begin(), out_.pointOffsets.end() - 1);
    for (uint32_t c = 0; c < out_.indices.size(); ++c)
      out_.pointCorners[next[out_.weldedVertices[out_.indices[c]]]++] = c;
  }

  std::span<const uint32_t> indices_;
  std::span<const Float3> positions_;
  ColliderTopology out_;
};

}  // namespace

Result<ColliderTopology> makeColliderTopology(std::span<const uint32_t> indices,
                                              uint32_t vertexCount,
                                              std::span<const Float3> bindPositions) {
  return guarded([&]() -> Result<ColliderTopology> {
    if (indices.size() % 3 != 0)
      return invalid(
          fmt::format("collider: {} indices are no triangles; give three each", indices.size()));
    if (indices.size() / 3 >= (size_t{1} << 30))
      return invalid(fmt::format("collider: {} triangles; the maximum is 2^30 - 1: split the mesh",
                                 indices.size() / 3));
    if (!bindPositions.empty() && bindPositions.size() != vertexCount)
      return invalid(fmt::format("collider: {} bind positions for {} vertices",
                                 bindPositions.size(), vertexCount));
    for (size_t i = 0; i < indices.size(); ++i)
      if (indices[i] >= vertexCount)
        return invalid(fmt::format("collider: triangle {} refers to vertex {} of {}", i / 3,
                                   indices[i], vertexCount));
    return Builder(indices, vertexCount, bindPositions).build();
  });
}

}  // namespace detail

Result<MeshReport> inspectMesh(const CollisionMesh& mesh) {
  auto topology = detail::makeColliderTopology(
      mesh.indices, static_cast<uint32_t>(mesh.positions.size()), mesh.positions);
  if (!topology) return topology.error();
  return topology->report;
}

std::string describe(const MeshReport& report) {
  const char* surface = report.usedTriangleCount == 0 ? "empty"
                        : !report.closed              ? "open"
                        : report.consistentlyOriented ? "closed"
                                                      : "closed, inconsistently oriented";
  std::string text = fmt::format("{} triangles, {} vertices at {} points, {}", report.triangleCount,
                                 report.vertexCount, report.weldedVertexCount, surface);
  const auto add = [&](uint32_t count, const char* what) {
    if (count != 0) text += fmt::format("; {} {}", count, what);
  };
  if (report.inverted) text += "; inside out, so the SDF flips it";
  add(report.nonFiniteVertices, "vertices that are not finite");
  add(report.nonFiniteTriangles, "triangles that are not finite and left out");
  add(report.degenerateTriangles, "triangles without area");
  add(report.duplicateTriangles, "duplicate triangles, left out");
  add(report.openEdges, "open edges");
  add(report.nonManifoldEdges, "edges of more than two triangles");
  add(report.misorientedEdges, "edges between triangles of opposite orientation");
  if (report.usedTriangleCount != 0 && !(report.closed && report.consistentlyOriented))
    text += "; inside is decided by two of three axes";
  return text;
}

}  // namespace pelage
