#include "scenes/head_sdf.h"

#include <algorithm>
#include <cmath>

#include "sdf/build_bench.h"

namespace bench {

using pelage::Float3;
using pelage::PassList;
using pelage::Result;
using pelage::reference::TriangleMesh;

namespace {

constexpr float kCells = 50;  // along the longest side, as SdfColliderDef has them
constexpr uint32_t kMarginCells = 3;

// The tight grid, which the baseline pads.
NodeGrid gridAround(const TriangleMesh& mesh) {
  Float3 low = mesh.positions.front(), high = low;
  for (const Float3& p : mesh.positions) {
    low = {std::min(low.x, p.x), std::min(low.y, p.y), std::min(low.z, p.z)};
    high = {std::max(high.x, p.x), std::max(high.y, p.y), std::max(high.z, p.z)};
  }
  const float extents[3] = {high.x - low.x, high.y - low.y, high.z - low.z};
  NodeGrid grid;
  grid.cellSize = std::max({extents[0], extents[1], extents[2]}) / kCells;
  const float margin = kMarginCells * grid.cellSize;
  grid.origin = {low.x - margin, low.y - margin, low.z - margin};
  for (size_t i = 0; i < 3; ++i)
    grid.nodes[i] =
        static_cast<uint32_t>(std::ceil(extents[i] / grid.cellSize)) + 2 * kMarginCells + 1;
  return grid;
}

}  // namespace

HeadSdf::HeadSdf(Workbench& workbench, const TriangleMesh& mesh) {
  SdfShape shape;
  shape.name = "head";
  shape.mesh = mesh;
  field_ = makeClassicSdf(workbench, shape, gridAround(mesh), true);
}

HeadSdf::~HeadSdf() = default;

Result<void> HeadSdf::addPasses(PassList& list, const TriangleMesh& mesh,
                                const CollidingVertices& vertices) {
  Result<void> done = field_->moveMesh(list, mesh.positions);
  if (done) done = field_->addBuild(list);
  if (!done) return done;
  return field_->addCollision(list, vertices, Response::kClassic);
}

}  // namespace bench
