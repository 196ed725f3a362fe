#include "sdf/sdf_grid.h"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cmath>

#include "base/bounds.h"

namespace pelage::detail {
namespace {

constexpr uint64_t kMostNodes = uint64_t{1} << 30;
// Coordinates in the kernels are limited to 65,535 cells from node 0.
constexpr double kMostAxisNodes = 60000;
constexpr uint32_t kMostTriangles = 1u << 20;

struct Axis {
  double origin = 0;  // [cell]
  double nodes = 0;   // as a double, it may be too many for an integer
};

Axis planAxis(double lowest, double highest, double cell, double band) {
  Axis axis;
  if (!(lowest <= highest)) lowest = highest = 0;
  axis.origin = std::floor(lowest / cell - (band + 1));
  axis.nodes = std::ceil(highest / cell + (band + 1)) - axis.origin + 1;
  return axis;
}

struct Axes {
  Axis axes[3];
  double nodeCount() const { return axes[0].nodes * axes[1].nodes * axes[2].nodes; }
};

Axes planAxes(const SdfGridDef& def, double cell) {
  const double band = static_cast<double>(def.band);
  const auto axis = [&](float lowest, float highest) {
    return planAxis(static_cast<double>(lowest), static_cast<double>(highest), cell, band);
  };
  Axes plan = {{axis(def.lowest.x, def.highest.x), axis(def.lowest.y, def.highest.y),
                axis(def.lowest.z, def.highest.z)}};
  plan.axes[0].nodes = std::ceil(plan.axes[0].nodes / 4) * 4;
  return plan;
}

// Keys and crossings.
double bytesANode(const SdfGridDef& def) { return def.threeAxes ? 4 + 3 : 4 + 1; }

// Returns the limit that a grid exceeds, or nothing.
std::string excessOf(const SdfGridDef& def, const Axes& plan) {
  for (int i = 0; i < 3; ++i)
    if (plan.axes[i].nodes > kMostAxisNodes)
      return fmt::format("{:.4g} nodes on axis {}, of {} that are possible", plan.axes[i].nodes,
                         "xyz"[i], kMostAxisNodes);
  const double nodes = plan.nodeCount();
  if (nodes > static_cast<double>(kMostNodes))
    return fmt::format("{:.4g} nodes, of {} that are possible", nodes, kMostNodes);
  const double bytes = nodes * bytesANode(def);
  if (bytes > static_cast<double>(def.memoryCap))
    return fmt::format("{:.4g} bytes, the cap is {}", bytes, def.memoryCap);
  return {};
}

// Returns the minimum cell size, to 1 %, whose grid is within the limits; 0 if there is none.
double fittingCell(const SdfGridDef& def) {
  double cell = static_cast<double>(def.cellSize);
  for (int i = 0; i < 12000; ++i) {
    cell *= 1.01;
    if (excessOf(def, planAxes(def, cell)).empty()) return cell;
  }
  return 0;
}

}  // namespace

Result<SdfGridPlan> planSdfGrid(const SdfGridDef& def) {
  const auto error = [](std::string message) {
    return Error{ErrorCode::kInvalidArgument, "distance field: " + std::move(message)};
  };
  if (!isFinite(def.lowest) || !isFinite(def.highest))
    return error("the box of the mesh is not finite; leave out vertices that are not");
  if (!(def.cellSize > 0) || !std::isfinite(def.cellSize))
    return error(fmt::format("a cell of {} m; it has to be above 0", def.cellSize));
  if (!(def.band >= 1 && def.band <= 16))
    return error(fmt::format("a band of {} cells; it has to be 1 to 16", def.band));
  if (def.triangleCount >= kMostTriangles)
    return error(fmt::format("{} triangles, fewer than {} are possible; use a coarser mesh",
                             def.triangleCount, kMostTriangles));

  const double cell = static_cast<double>(def.cellSize);
  const Axes axes = planAxes(def, cell);
  if (const std::string excess = excessOf(def, axes); !excess.empty()) {
    const double fitting = fittingCell(def);
    return error(fmt::format("cells of {:.6g} m need {}; {}", def.cellSize, excess,
                             fitting > 0 ? fmt::format("a cell size of {:.6g} m fits", fitting)
                                         : std::string("no cell size fits, raise the cap")));
  }

  SdfGridPlan plan;
  plan.cellSize = def.cellSize;
  plan.band = def.band;
  plan.threeAxes = def.threeAxes;
  for (int i = 0; i < 3; ++i) plan.nodes[i] = static_cast<uint32_t>(axes.axes[i].nodes);
  plan.origin = {static_cast<float>(axes.axes[0].origin * cell),
                 static_cast<float>(axes.axes[1].origin * cell),
                 static_cast<float>(axes.axes[2].origin * cell)};
  plan.triangleBits = std::max(1, static_cast<int>(std::bit_width(def.triangleCount)));
  plan.bytes = static_cast<uint64_t>(static_cast<double>(plan.nodeCount()) * bytesANode(def));
  plan.farRange = static_cast<float>(std::min({plan.nodes[0], plan.nodes[1], plan.nodes[2]}));
  return plan;
}

}  // namespace pelage::detail
