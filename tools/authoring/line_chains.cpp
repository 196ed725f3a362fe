#include "line_chains.h"

#include <algorithm>
#include <array>
#include <cstddef>

namespace pelage::detail {
namespace {

constexpr uint32_t kNone = ~0u;

class ChainWalker {
 public:
  ChainWalker(const std::vector<std::pair<uint32_t, uint32_t>>& segments, uint32_t vertexCount)
      : segments_(segments), degrees_(vertexCount), meeting_(vertexCount, {kNone, kNone}) {
    for (size_t i = 0; i < segments.size(); ++i)
      for (const uint32_t vertex : {segments[i].first, segments[i].second}) {
        if (degrees_[vertex] < 2) meeting_[vertex][degrees_[vertex]] = static_cast<uint32_t>(i);
        if (degrees_[vertex] < 3) ++degrees_[vertex];
      }
    used_.resize(segments.size());
  }

  LineChains join() {
    LineChains out;
    std::vector<uint32_t> before, after;
    for (size_t i = 0; i < segments_.size(); ++i) {
      if (used_[i]) continue;
      used_[i] = true;
      agreement_ = 1;
      before.clear();
      after.clear();
      walk(static_cast<uint32_t>(i), segments_[i].second, true, after);
      walk(static_cast<uint32_t>(i), segments_[i].first, false, before);
      const size_t begin = out.vertices.size();
      out.vertices.insert(out.vertices.end(), before.rbegin(), before.rend());
      out.vertices.insert(out.vertices.end(), {segments_[i].first, segments_[i].second});
      out.vertices.insert(out.vertices.end(), after.begin(), after.end());
      if (agreement_ < 0)
        std::reverse(out.vertices.begin() + static_cast<std::ptrdiff_t>(begin), out.vertices.end());
      out.counts.push_back(static_cast<uint32_t>(out.vertices.size() - begin));
    }
    return out;
  }

 private:
  // Collects the vertices behind `vertex`, at which `segment` arrives, until the chain ends.
  void walk(uint32_t segment, uint32_t vertex, bool forward, std::vector<uint32_t>& vertices) {
    while (degrees_[vertex] == 2) {
      const auto& pair = meeting_[vertex];
      segment = pair[0] == segment ? pair[1] : pair[0];
      if (used_[segment]) return;
      used_[segment] = true;
      const bool along = (segments_[segment].first == vertex) == forward;
      agreement_ += along ? 1 : -1;
      vertex =
          segments_[segment].first == vertex ? segments_[segment].second : segments_[segment].first;
      vertices.push_back(vertex);
    }
  }

  const std::vector<std::pair<uint32_t, uint32_t>>& segments_;
  std::vector<uint8_t> degrees_;                  // [vertex] 3 stands for more
  std::vector<std::array<uint32_t, 2>> meeting_;  // [vertex] its first two segments
  std::vector<bool> used_;                        // [segment]
  int64_t agreement_ = 0;  // segments of the chain that run its way, less those that do not
};

}  // namespace

LineChains joinSegments(const std::vector<std::pair<uint32_t, uint32_t>>& segments,
                        uint32_t vertexCount) {
  return ChainWalker(segments, vertexCount).join();
}

}  // namespace pelage::detail
