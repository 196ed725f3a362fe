#include "cut_caps.h"

#include <algorithm>

namespace pelage::detail {
namespace {

struct Balance {
  std::array<uint32_t, 2> edge;  // ascending vertices
  int balance;                   // runs from the lower to the higher one, less those back
};

// Edges that are not closed, ascending.
std::vector<Balance> openEdges(std::span<const uint32_t> indices) {
  std::vector<Balance> runs;
  runs.reserve(indices.size());
  for (size_t i = 0; i < indices.size(); ++i) {
    const uint32_t from = indices[i], to = indices[i % 3 == 2 ? i - 2 : i + 1];
    if (from != to) runs.push_back({{std::min(from, to), std::max(from, to)}, from < to ? 1 : -1});
  }
  std::sort(runs.begin(), runs.end(),
            [](const Balance& a, const Balance& b) { return a.edge < b.edge; });
  std::vector<Balance> open;
  for (size_t begin = 0, end = 0; begin < runs.size(); begin = end) {
    Balance sum = {runs[begin].edge, 0};
    while (end < runs.size() && runs[end].edge == sum.edge) sum.balance += runs[end++].balance;
    if (sum.balance != 0) open.push_back(sum);
  }
  return open;
}

}  // namespace

EdgeBalance::EdgeBalance(std::span<const uint32_t> indices) {
  for (const Balance& edge : openEdges(indices)) open_.push_back(edge.edge);
}

bool EdgeBalance::isClosed(uint32_t from, uint32_t to) const {
  return !std::binary_search(open_.begin(), open_.end(),
                             std::array{std::min(from, to), std::max(from, to)});
}

std::vector<std::vector<uint32_t>> cutRims(std::span<const uint32_t> indices,
                                           const EdgeBalance& whole) {
  // A closing edge runs the other way.
  std::vector<std::array<uint32_t, 2>> edges;  // from, to
  for (const Balance& edge : openEdges(indices)) {
    if (!whole.isClosed(edge.edge[0], edge.edge[1])) continue;
    const std::array<uint32_t, 2> back =
        edge.balance > 0 ? std::array{edge.edge[1], edge.edge[0]} : edge.edge;
    edges.insert(edges.end(), static_cast<size_t>(std::abs(edge.balance)), back);
  }
  std::sort(edges.begin(), edges.end());

  // A vertex is known by the first of the edges that leave it. Of each: how many of them were
  // followed, and where it is on the path.
  constexpr size_t kNone = ~size_t{0};
  std::vector<size_t> followed(edges.size(), 0), point(edges.size(), kNone);
  const auto firstEdge = [&](uint32_t vertex) {
    const auto edge = std::lower_bound(edges.begin(), edges.end(), std::array{vertex, 0u});
    const bool leaves = edge != edges.end() && (*edge)[0] == vertex;
    return leaves ? static_cast<size_t>(edge - edges.begin()) : kNone;
  };
  std::vector<size_t> path;
  const auto cutTo = [&](size_t size) {
    for (; path.size() > size; path.pop_back()) point[path.back()] = kNone;
  };
  std::vector<std::vector<uint32_t>> rims;
  for (size_t start = 0; start < edges.size(); ++start) {
    size_t at = firstEdge(edges[start][0]);
    if (start < at + followed[at]) continue;
    // A path that ends without coming back was never a ring: its edges stay open.
    while (at != kNone) {
      if (point[at] == kNone) {
        point[at] = path.size();
        path.push_back(at);
      } else {
        std::vector<uint32_t>& rim = rims.emplace_back();
        for (size_t i = point[at]; i < path.size(); ++i) rim.push_back(edges[path[i]][0]);
        cutTo(point[at] + 1);
      }
      const size_t edge = at + followed[at];
      if (edge == edges.size() || edges[edge][0] != edges[at][0]) break;
      ++followed[at];
      at = firstEdge(edges[edge][1]);
    }
    cutTo(0);
  }
  return rims;
}

}  // namespace pelage::detail
