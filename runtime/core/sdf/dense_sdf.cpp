#include "sdf/dense_sdf.h"

#include <algorithm>
#include <cmath>

#include "passes/dispatch_rows.h"
#include "pelage/bindings.h"
#include "pelage/constants.h"
#include "pelage/kernels.h"

namespace pelage::detail {

namespace {

// Nodes within this distance have the distances that are finest [cells].
constexpr float kBand = 4;
constexpr uint64_t kMaxDenseNodes = uint64_t{1} << 28;

// No distance in a grid is larger [cells].
float farRangeOf(const SdfGrid& grid) {
  const auto [x, y, z] = grid.nodes;
  return std::hypot(static_cast<float>(x), static_cast<float>(y), static_cast<float>(z));
}

}  // namespace

uint64_t nodeCountOf(const SdfGrid& grid) {
  return uint64_t{grid.nodes[0]} * grid.nodes[1] * grid.nodes[2];
}

std::string faultOf(const DenseSdf& sdf, const ResourceTable& resources) {
  const SdfGrid& grid = sdf.grid;
  if (!isFinite(grid.origin)) return "the origin of its grid is not finite";
  if (!(grid.cellSize > 0) || !std::isfinite(grid.cellSize)) {
    return "the cells of its grid have " + std::to_string(grid.cellSize) +
           " m, but their size must be finite and above 0";
  }
  const auto [x, y, z] = grid.nodes;
  const std::string size =
      std::to_string(x) + " x " + std::to_string(y) + " x " + std::to_string(z) + " nodes";
  if (std::min({x, y, z}) < 2)
    return "its grid has " + size + ", but takes 2 or more along an axis";
  if (std::max({x, y, z}) > kMaxDenseNodes || uint64_t{x} * y > kMaxDenseNodes ||
      nodeCountOf(grid) > kMaxDenseNodes)
    return "its grid has " + size + ", but takes 2^28 in all";
  const BufferDesc* buffer = resources.find(sdf.distances);
  const uint64_t bytes = (sdf.first + nodeCountOf(grid)) * sizeof(float);
  if (buffer != nullptr && buffer->size >= bytes) return {};
  return "its buffer of distances " +
         (buffer == nullptr ? "does not exist" : "has " + std::to_string(buffer->size) + " bytes") +
         "; " + size + " take " + std::to_string(bytes);
}

Box boxOf(const SdfGrid& grid) {
  const auto end = [&](float origin, uint32_t nodes) {
    return origin + static_cast<float>(nodes - 1) * grid.cellSize;
  };
  return {grid.origin,
          {end(grid.origin.x, grid.nodes[0]), end(grid.origin.y, grid.nodes[1]),
           end(grid.origin.z, grid.nodes[2])}};
}

Sdf sdfOf(const DenseSdf& dense, uint32_t firstKey, const LocalOrigin& origin) {
  const SdfGrid& grid = dense.grid;
  const Float3 node = origin.relative(grid.origin);
  Sdf sdf = {};
  sdf.origin = {node.x, node.y, node.z, grid.cellSize};
  sdf.nodes = {grid.nodes[0], grid.nodes[1], grid.nodes[2], firstKey};
  sdf.triangleBits = import_sdf::kImportTriangleBits;
  sdf.surfaceStride = sdf::kSdfStillRecord;
  sdf.band = kBand;
  sdf.farRange = farRangeOf(grid);
  return sdf;
}

Result<void> addImport(const DenseSdf& dense, uint32_t firstKey, BufferId keys,
                       const ResourceTable& resources, PassList& list) {
  const auto count = static_cast<uint32_t>(nodeCountOf(dense.grid));
  ImportSdfConstants constants = {};
  constants.importNodeCount = count;
  constants.importFirst = dense.first;
  constants.importFirstKey = firstKey;
  constants.importCellsAMeter = 1 / dense.grid.cellSize;
  constants.importBand = kBand;
  constants.importFarRange = farRangeOf(dense.grid);
  PassBuilder builder(list);
  dispatchRows(builder, importSdfVariant(), count).bytes(uint64_t{2} * count * sizeof(float));
  return builder.finish(ImportSDFBindings{
      .importSdfConstants = constants,
      .importDistances = resources.whole(dense.distances),
      .importKeys = resources.whole(keys),
  });
}

}  // namespace pelage::detail
