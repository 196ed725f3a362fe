#include "scenes/scene_errors.h"

#include <algorithm>
#include <cmath>
#include <cstring>

#include "scenes/collider_depths.h"
#include "simulation/measure.h"

namespace bench {

using pelage::CapsuleCollider;
using pelage::Float3;
using pelage::Float4;
using pelage::Result;

namespace {

constexpr std::ptrdiff_t kKinematicVertices = 2;
// Roots are on the surface, to the accuracy of skinning and of its triangles [m].
constexpr double kRootDepth = 1e-3;
constexpr double kTopShare = 0.999;

bool isFinite(const Float4& p) {
  return std::isfinite(p.x) && std::isfinite(p.y) && std::isfinite(p.z);
}

// Adds the edges of all strands; strands that are no numbers are counted instead.
void judgeStretch(const pelage::HairAsset& asset, const std::vector<Float4>& positions,
                  SceneErrors& errors) {
  const size_t n = asset.verticesPerStrand;
  for (size_t first = 0; first + n <= positions.size(); first += n) {
    const auto strand = positions.begin() + static_cast<std::ptrdiff_t>(first);
    if (!std::all_of(strand, strand + static_cast<std::ptrdiff_t>(n), isFinite)) {
      ++errors.brokenStrands;
      continue;
    }
    for (size_t i = first + 1; i + 1 < first + n; ++i) {
      const double rest = static_cast<double>(asset.restLengths[i]);
      if (rest < kShortestEdge) continue;
      const double size = length(toVector(positions[i + 1]) - toVector(positions[i]));
      errors.stretchMax = std::max(errors.stretchMax, std::abs(size / rest - 1));
    }
  }
}

// Vertices of every stride-th strand; strands that are no numbers are left out.
void addStrands(const pelage::HairAsset& asset, const std::vector<Float4>& positions, size_t stride,
                std::vector<Float3>& points) {
  const size_t n = asset.verticesPerStrand;
  for (size_t first = 0; first + n <= positions.size(); first += stride * n) {
    const auto strand = positions.begin() + static_cast<std::ptrdiff_t>(first);
    if (!std::all_of(strand, strand + static_cast<std::ptrdiff_t>(n), isFinite)) continue;
    for (size_t i = first; i < first + n; ++i)
      points.push_back({positions[i].x, positions[i].y, positions[i].z});
  }
}

// How deep each point is in the collider that it is deepest in, 0 outside of all.
std::vector<double> depthsOf(const std::vector<Float3>& points, const ColliderPose& colliders) {
  std::vector<double> depths(points.size());
  for (size_t i = 0; i < points.size(); ++i)
    for (const CapsuleCollider& capsule : colliders.capsules)
      depths[i] = std::max(depths[i], -capsuleDistance(capsule, points[i]));
  for (const pelage::reference::TriangleMesh& mesh : colliders.meshes) {
    const std::vector<double> inMesh = depthsInMesh(mesh, points);
    for (size_t i = 0; i < points.size(); ++i) depths[i] = std::max(depths[i], inMesh[i]);
  }
  return depths;
}

// Adds the depths of the free vertices. A strand that grows out of the inside of a collider cannot
// be outside: it is counted instead.
void judgeDepths(const pelage::HairAsset& asset, const std::vector<Float4>& positions,
                 size_t stride, const ColliderPose& colliders, std::vector<double>& depths,
                 SceneErrors& errors) {
  std::vector<Float3> points;
  addStrands(asset, positions, stride, points);
  const std::vector<double> all = depthsOf(points, colliders);
  const auto n = static_cast<std::ptrdiff_t>(asset.verticesPerStrand);
  const auto held = std::min(kKinematicVertices, n);
  for (auto strand = all.begin(); strand != all.end(); strand += n) {
    if (*std::max_element(strand, strand + held) > kRootDepth)
      ++errors.strandsRootedInside;
    else
      depths.insert(depths.end(), strand + held, strand + n);
  }
}

}  // namespace

Result<void> ErrorSamples::take(Workbench& workbench, const SceneRun& run) {
  Sample sample;
  for (const RunHair& hair : run.hairs()) {
    const uint64_t vertices = uint64_t{hair.asset->strandCount} * hair.asset->verticesPerStrand;
    const auto raw = workbench.device.read(hair.buffers.positions, 0, vertices * sizeof(Float4));
    if (!raw) return raw.error();
    HairSample taken = {hair.asset, std::vector<Float4>(vertices)};
    std::memcpy(taken.positions.data(), raw->data(), raw->size());
    sample.hairs.push_back(std::move(taken));
  }
  sample.colliders = run.colliders();
  samples_.push_back(std::move(sample));
  return {};
}

SceneErrors ErrorSamples::judge(uint64_t judged) const {
  SceneErrors errors;
  std::vector<double> depths;
  for (const Sample& sample : samples_) {
    uint64_t vertices = 0;
    for (const HairSample& hair : sample.hairs) {
      judgeStretch(*hair.asset, hair.positions, errors);
      vertices += hair.positions.size();
    }
    if (sample.colliders.capsules.empty() && sample.colliders.meshes.empty()) continue;
    const uint64_t stride = (vertices + judged - 1) / judged;
    for (const HairSample& hair : sample.hairs)
      judgeDepths(*hair.asset, hair.positions, stride, sample.colliders, depths, errors);
  }
  errors.judgedVertices = depths.size();
  if (depths.empty()) return errors;
  std::sort(depths.begin(), depths.end());
  errors.penetrationMax = depths.back();
  errors.penetrationTop =
      depths[static_cast<size_t>(kTopShare * static_cast<double>(depths.size() - 1))];
  return errors;
}

}  // namespace bench
