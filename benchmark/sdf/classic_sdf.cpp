// The classic baseline of distance fields: its buffers and its passes.
#include <algorithm>
#include <cmath>
#include <cstring>
#include <span>

#include "baseline/gpu_structs.h"
#include "baseline/kernels.h"
#include "sdf/build_bench.h"

namespace bench {

using pelage::BufferId;
using pelage::Float3;
using pelage::Float4;
using pelage::KernelVariant;
using pelage::PassBuilder;
using pelage::PassList;
using pelage::Result;

namespace {

// Its grid is larger than the mesh by this share of the extent along x, on every side: that gives
// the 343 k, 2.78 M and 22.4 M nodes that are known of the original for the body.
constexpr float kPadding = 0.8f;
constexpr uint32_t kRow = 1 << 20;  // threads, as in field_layout.hlsli

std::vector<Float4> paddedOf(std::span<const Float3> positions) {
  std::vector<Float4> corners;
  for (const Float3& p : positions) corners.push_back({p.x, p.y, p.z, 1});
  return corners;
}

class ClassicSdf : public SdfBuild {
 public:
  ClassicSdf(Workbench& workbench, const SdfShape& shape, const NodeGrid& compared, bool ownGrid)
      : workbench_(workbench), compared_(compared), grid_(compared) {
    if (ownGrid) pad(shape);
    constants_.fieldOrigin = {grid_.origin.x, grid_.origin.y, grid_.origin.z, grid_.cellSize};
    constants_.fieldNodes = {grid_.nodes[0], grid_.nodes[1], grid_.nodes[2],
                             static_cast<uint32_t>(grid_.count())};
    constants_.triangleCount = shape.mesh.triangleCount();
    corners_ = add("corners", paddedOf(shape.mesh.positions),
                   pelage::BufferUsage::kStorage | pelage::BufferUsage::kUpload);
    triangles_ = add("triangles", shape.mesh.indices);
    keys_ = add("contactSdfKeys", std::vector<uint32_t>(grid_.count()));
  }
  ~ClassicSdf() override {
    for (const BufferId buffer : owned_) workbench_.scene.resources().remove(buffer);
  }

  Result<void> moveMesh(PassList& list, std::span<const Float3> positions) override {
    const std::vector<Float4> corners = paddedOf(positions);
    pelage::addUpload(list, corners_, std::as_bytes(std::span(corners)));
    return {};
  }

  Result<void> addBuild(PassList& list) override {
    Result<void> done = pass(list, baseline::clearFieldVariant({}), grid_.count(), {});
    if (done) done = pass(list, baseline::scatterFieldVariant({}), constants_.triangleCount, {});
    if (done) done = pass(list, baseline::finishFieldVariant({}), grid_.count(), {});
    return done;
  }

  std::vector<Response> responses() const override { return {Response::kClassic}; }
  Result<void> addCollision(PassList& list, const CollidingVertices& hair, Response) override {
    constants_.pointCount = hair.count;
    return pass(list, baseline::pushPointsVariant({}), hair.count, hair);
  }

  Result<std::vector<NodeValue>> nodes() override {
    const auto raw = workbench_.device.read(keys_);
    if (!raw) return raw.error();
    std::vector<NodeValue> values;
    values.reserve(compared_.count());
    for (uint32_t z = 0; z < compared_.nodes[2]; ++z)
      for (uint32_t y = 0; y < compared_.nodes[1]; ++y)
        for (uint32_t x = 0; x < compared_.nodes[0]; ++x) {
          const uint64_t node =
              (x + offset_[0]) +
              uint64_t{grid_.nodes[0]} *
                  ((y + offset_[1]) + uint64_t{grid_.nodes[1]} * (z + offset_[2]));
          float distance = 0;
          std::memcpy(&distance, raw->data() + node * sizeof distance, sizeof distance);
          if (distance >= 1e9f)
            values.emplace_back();
          else
            values.push_back({NodeState::kNear, distance / grid_.cellSize});
        }
    return values;
  }
  uint64_t nodeCount() const override { return grid_.count(); }
  uint64_t sdfBytes() const override { return bytes(); }
  uint64_t bytes() const override { return grid_.count() * sizeof(uint32_t); }

 private:
  // By whole cells, so that its nodes are those that are compared, and more. The mesh has three
  // cells on each side there.
  void pad(const SdfShape& shape) {
    Float3 low = shape.mesh.positions.front(), high = low;
    for (const Float3& p : shape.mesh.positions) {
      low = {std::min(low.x, p.x), std::min(low.y, p.y), std::min(low.z, p.z)};
      high = {std::max(high.x, p.x), std::max(high.y, p.y), std::max(high.z, p.z)};
    }
    const float cell = grid_.cellSize;
    const auto cells = [&](float length) {
      return static_cast<uint32_t>(std::ceil(length / cell));
    };
    const uint32_t padding = cells(kPadding * (high.x - low.x));
    const float extents[3] = {high.x - low.x, high.y - low.y, high.z - low.z};
    for (size_t i = 0; i < 3; ++i) {
      const uint32_t around =
          (compared_.nodes[i] - std::min(compared_.nodes[i], cells(extents[i]))) / 2;
      offset_[i] = padding - std::min(padding, around);
      grid_.nodes[i] = std::max(cells(extents[i]) + 2 * padding, compared_.nodes[i] + offset_[i]);
    }
    grid_.origin = {grid_.origin.x - cell * static_cast<float>(offset_[0]),
                    grid_.origin.y - cell * static_cast<float>(offset_[1]),
                    grid_.origin.z - cell * static_cast<float>(offset_[2])};
  }

  template <class T>
  BufferId add(const char* name, const std::vector<T>& values,
               pelage::BufferUsage usage = pelage::BufferUsage::kStorage |
                                           pelage::BufferUsage::kReadback) {
    owned_.push_back(workbench_.add(name, values, usage));
    return owned_.back();
  }

  Result<void> pass(PassList& list, const KernelVariant& variant, uint64_t threads,
                    const CollidingVertices& hair) {
    PassBuilder builder(list);
    builder.dispatch(variant, static_cast<uint32_t>(std::min<uint64_t>(threads, kRow)),
                     static_cast<uint32_t>((threads + kRow - 1) / kRow));
    const std::pair<const char*, BufferId> buffers[] = {{"g_fieldKeys", keys_},
                                                        {"g_corners", corners_},
                                                        {"g_triangles", triangles_},
                                                        {"g_points", hair.positions},
                                                        {"g_pointsBefore", hair.before}};
    for (const auto& [name, buffer] : buffers)
      if (const pelage::BufferDesc* desc = workbench_.scene.resources().find(buffer))
        builder.bind(name, buffer, desc->size);
    return builder.constants("FieldConstants", constants_).finish();
  }

  Workbench& workbench_;
  NodeGrid compared_, grid_;
  uint32_t offset_[3] = {};  // of the compared grid's first node in this one
  std::vector<BufferId> owned_;
  BufferId corners_, triangles_, keys_;
  baseline::FieldConstants constants_ = {};
};

}  // namespace

Result<void> SdfBuild::moveMesh(PassList&, std::span<const Float3>) {
  return pelage::Error{pelage::ErrorCode::kUnsupported, "the mesh of this build does not move"};
}

std::unique_ptr<SdfBuild> makeClassicSdf(Workbench& workbench, const SdfShape& shape,
                                         const NodeGrid& compared, bool ownGrid) {
  return std::make_unique<ClassicSdf>(workbench, shape, compared, ownGrid);
}

}  // namespace bench
