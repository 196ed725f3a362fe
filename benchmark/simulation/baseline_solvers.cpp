// The baselines: their buffers and their passes.
#include <algorithm>
#include <array>
#include <cmath>

#include "baseline/gpu_structs.h"
#include "baseline/kernels.h"
#include "strand_solver.h"

namespace bench {

using pelage::BufferId;
using pelage::Error;
using pelage::ErrorCode;
using pelage::Float4;
using pelage::HairAsset;
using pelage::PassBuilder;
using pelage::PassList;
using pelage::Result;
using pelage::rod::RootPose;

namespace {

constexpr uint64_t kVector = sizeof(Float4);

Float4 toFloat4(const pelage::rod::Quaterniond& q) {
  return {static_cast<float>(q.x), static_cast<float>(q.y), static_cast<float>(q.z),
          static_cast<float>(q.w)};
}
Float4 toFloat4(const pelage::rod::Vector3d& v, float w = 0) {
  return {static_cast<float>(v.x), static_cast<float>(v.y), static_cast<float>(v.z), w};
}
Float4 toFloat4(const pelage::Quaternion& q) { return {q.x, q.y, q.z, q.w}; }

/// The base of both baselines: removes its buffers in the end, and knows the roots' last poses.
class BaselineSolver : public StrandSolver {
 public:
  ~BaselineSolver() override {
    for (const BufferId buffer : owned_) workbench_.scene.resources().remove(buffer);
  }
  BufferId positions() const override { return slots_; }

 protected:
  BaselineSolver(Workbench& workbench, const HairAsset& asset)
      : workbench_(workbench),
        strands_(asset.strandCount),
        vertices_(asset.verticesPerStrand),
        slots_(add("places", std::vector<Float4>(total()))),
        directions_(add("directions", std::vector<Float4>(total()))) {}

  BufferId add(const char* name, const std::vector<Float4>& values) {
    owned_.push_back(workbench_.add(name, values));
    return owned_.back();
  }
  uint64_t total() const { return uint64_t{strands_} * vertices_; }
  template <class Constants>
  void moveTo(const RootPose& pose, Constants& constants) {
    constants.restart = frame_ == 0 ? 1 : 0;
    if (frame_ == 0) poses_ = {pose, pose, pose};
    poses_ = {pose, poses_[0], poses_[1]};
    ++frame_;
    constants.rotation = toFloat4(poses_[0].rotation);
    constants.shift = toFloat4(poses_[0].translation);
    constants.rotationBefore = toFloat4(poses_[1].rotation);
    constants.shiftBefore = toFloat4(poses_[1].translation);
  }

  Workbench& workbench_;
  std::vector<BufferId> owned_;
  uint32_t strands_, vertices_;
  BufferId slots_, directions_;
  std::array<RootPose, 3> poses_;  // of this frame and the two before

 private:
  uint64_t frame_ = 0;
};

class SweepsSolver : public BaselineSolver {
 public:
  SweepsSolver(Workbench& workbench, const BenchScene& scene, uint32_t sweeps)
      : BaselineSolver(workbench, scene.asset),
        slotsBefore_(add("slotsBefore", std::vector<Float4>(total()))),
        bind_(add("bind", scene.asset.positions)),
        edges_(add("edges", edgesOf(scene.asset))) {
    const float h = static_cast<float>(kFrameSeconds);
    constants_.fall = {0, -static_cast<float>(scene.gravity) * h * h, 0, 0};
    constants_.strandCount = strands_;
    constants_.vertexCount = vertices_;
    constants_.lengthSweeps = sweeps;
    constants_.shapeSweeps = 2;
    constants_.damping = static_cast<float>(1 - std::exp(-scene.airDrag * kFrameSeconds));
    constants_.localStiffness = scene.localStiffness;
    constants_.carryShare = static_cast<float>(scene.carry);
    constants_.carryThreshold = 1e9f;
  }

  Result<void> advance(const RootPose& pose, PassList& list) override {
    moveTo(pose, constants_);
    constants_.rotationEarlier = toFloat4(poses_[2].rotation);
    constants_.shiftEarlier = toFloat4(poses_[2].translation);
    list.clear();
    const auto threads = static_cast<uint32_t>(total());
    const bool carries = constants_.carryShare > 0, keepsShape = constants_.localStiffness > 0;
    // Accesses of the state a vertex: what each kernel's head lists.
    Result<void> done = pass(list, baseline::verletStrandsVariant({}), threads, 5);
    if (done && carries) done = pass(list, baseline::carryStrandsVariant({}), threads, 5);
    if (done && keepsShape) done = pass(list, baseline::sweepShapeVariant({}), strands_, 3);
    if (done) done = pass(list, baseline::sweepLengthsVariant({}), threads, 5);
    if (done) workbench_.scene.finish(list);
    return done;
  }
  BufferId positionsBefore() const override { return slotsBefore_; }

 private:
  static std::vector<Float4> edgesOf(const HairAsset& asset) {
    std::vector<Float4> edges;
    const size_t n = asset.verticesPerStrand;
    for (size_t i = 0; i < asset.positions.size(); ++i) {
      const pelage::Float3& v = asset.restVectors[i];
      const bool last = i % n == n - 1;
      edges.push_back(last ? toFloat4(asset.restFrames[i + 1 - n])
                           : Float4{v.x, v.y, v.z, asset.restLengths[i]});
    }
    return edges;
  }

  Result<void> pass(PassList& list, const pelage::KernelVariant& variant, uint32_t threads,
                    uint64_t accesses) {
    PassBuilder builder(list);
    builder.dispatch(variant, threads);
    const std::pair<const char*, BufferId> buffers[] = {{"g_places", slots_},
                                                        {"g_placesBefore", slotsBefore_},
                                                        {"g_directions", directions_},
                                                        {"g_bind", bind_},
                                                        {"g_edges", edges_}};
    for (const auto& [name, buffer] : buffers) builder.bind(name, buffer, total() * kVector);
    builder.constants("SweepConstants", constants_).bytes(accesses * total() * kVector);
    return builder.finish();
  }

  BufferId slotsBefore_, bind_, edges_;
  baseline::SweepConstants constants_ = {};
};

class CosseratSolver : public BaselineSolver {
 public:
  CosseratSolver(Workbench& workbench, const BenchScene& scene, uint32_t subSteps, float inertia)
      : BaselineSolver(workbench, scene.asset) {
    pack(scene.asset);
    constants_.gravity = {0, -static_cast<float>(scene.gravity), 0, 0};
    constants_.strandCount = strands_;
    constants_.vertexCount = vertices_;
    constants_.subSteps = subSteps;
    constants_.subStep = static_cast<float>(kFrameSeconds / subSteps);
    constants_.drag = static_cast<float>(scene.airDrag);
    constants_.bend = static_cast<float>(scene.bend);
    constants_.twist = static_cast<float>(scene.twist);
    constants_.inertia = inertia;
  }

  Result<void> advance(const RootPose& pose, PassList& list) override {
    moveTo(pose, constants_);
    list.clear();
    PassBuilder builder(list);
    builder.dispatch(baseline::simulateCosseratVariant({}), strands_)
        .bind("g_rods", rods_, 4 * total() * kVector)
        .bind("g_rodRest", rest_, 2 * total() * kVector)
        .bind("g_places", slots_, total() * kVector)
        .bind("g_directions", directions_, total() * kVector)
        .constants("CosseratConstants", constants_)
        // A sub-step reads the state and the rest data and writes the state; the outputs once.
        .bytes((uint64_t{10} * constants_.subSteps + 2) * total() * kVector);
    Result<void> done = builder.finish();
    if (done) workbench_.scene.finish(list);
    return done;
  }

 private:
  void pack(const HairAsset& asset) {
    std::vector<Float4> rods(4 * total()), rest(2 * total());
    for (uint32_t s = 0; s < strands_; ++s) {
      std::vector<pelage::rod::Vector3d> points;
      for (uint32_t v = 0; v < vertices_; ++v)
        points.push_back(toVector(asset.positions[uint64_t{s} * vertices_ + v]));
      const pelage::rod::RestStrand strand(std::move(points));
      for (uint32_t v = 0; v < vertices_; ++v) {
        const uint64_t at = uint64_t{v} * strands_ + s;
        const bool tip = v + 1 == vertices_;
        rods[at].w = static_cast<float>(strand.voronoiLengths[v]);
        rods[2 * total() + at] = {0, 0, 0, 1};
        rest[at] = tip ? Float4{0, 0, 0, 1} : toFloat4(strand.relative[v]);
        rest[total() + at] =
            toFloat4(strand.positions[v], tip ? 0 : static_cast<float>(strand.lengths[v]));
      }
    }
    rods_ = add("rods", rods);
    rest_ = add("rodRest", rest);
  }

  BufferId rods_ = BufferId::kInvalid, rest_ = BufferId::kInvalid;
  baseline::CosseratConstants constants_ = {};
};

}  // namespace

Result<std::unique_ptr<StrandSolver>> makeSweepsSolver(Workbench& workbench,
                                                       const BenchScene& scene, uint32_t sweeps) {
  const uint32_t n = scene.asset.verticesPerStrand;
  if (n < 4 || 64 % n != 0)
    return Error{ErrorCode::kUnsupported, "the classic baseline has no code for strands of " +
                                              std::to_string(n) +
                                              " vertices, only of 4, 8, 16, 32 and 64"};
  return std::unique_ptr<StrandSolver>(new SweepsSolver(workbench, scene, sweeps));
}

Result<std::unique_ptr<StrandSolver>> makeCosseratSolver(Workbench& workbench,
                                                         const BenchScene& scene, uint32_t subSteps,
                                                         float inertia) {
  return std::unique_ptr<StrandSolver>(new CosseratSolver(workbench, scene, subSteps, inertia));
}

}  // namespace bench
