#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <span>
#include <utility>
#include <vector>

#include "pelage/constants.h"
#include "pelage/ray_tracing.h"
#include "ray_tracing/bindings.h"
#include "ray_tracing/code.h"
#include "ray_tracing/constants.h"
#include "ray_tracing/kernels.h"

namespace pelage {
namespace {

using namespace ray_tracing::ray_strands;

Error invalidRays(std::string what) {
  return {ErrorCode::kInvalidArgument, "RayGeometry: " + std::move(what)};
}

uint64_t storedStrands(const ResourceTable& resources, const HairObject& hair) {
  return resources.whole(hair.buffers().positions).size / sizeof(Float4) / hair.verticesPerStrand();
}

std::vector<uint32_t> triangleIndices(uint64_t segments) {
  std::vector<uint32_t> indices;
  for (uint64_t quad = 0; quad < 2 * segments; ++quad)
    for (const uint32_t corner : {0u, 1u, 2u, 2u, 1u, 3u})
      indices.push_back(static_cast<uint32_t>(4 * quad) + corner);
  return indices;
}

std::vector<uint32_t> segmentIndices(uint64_t strands, uint32_t segments) {
  std::vector<uint32_t> indices;
  for (uint64_t strand = 0; strand < strands; ++strand)
    for (uint32_t segment = 0; segment < segments; ++segment) {
      const auto vertex = static_cast<uint32_t>(strand * (segments + 1) + segment);
      indices.insert(indices.end(), {vertex, vertex + 1});
    }
  return indices;
}

}  // namespace

Result<RayGeometry> RayGeometry::create(ResourceTable& resources, const HairObject& hair,
                                        const RayGeometryDef& def) {
  if (!(def.strandShare > 0 && def.strandShare <= 1))
    return invalidRays(fmt::format("strandShare is {}; it must be above 0, to 1", def.strandShare));
  if (!(def.radiusScale > 0 && def.radiusScale <= 1000))
    return invalidRays(
        fmt::format("radiusScale is {}; it must be above 0, to 1000", def.radiusScale));
  const uint32_t mostSegments = hair.verticesPerStrand() - 1;
  if (def.segments > mostSegments)
    return invalidRays(fmt::format("{} segments of strands with {} vertices", def.segments,
                                   hair.verticesPerStrand()));
  const uint64_t stored = storedStrands(resources, hair);
  if (stored == 0) return invalidRays("the table is not that of the object's scene");
  RayGeometry geometry;
  geometry.kind_ = def.kind;
  geometry.source_ = hair.buffers().positions;
  geometry.radiusScale_ = def.radiusScale;
  geometry.segments_ = def.segments > 0 ? def.segments : mostSegments;
  const auto strands =
      static_cast<uint64_t>(std::ceil(static_cast<double>(stored) * double{def.strandShare}));
  const uint64_t segments = strands * geometry.segments_;
  const bool triangles = geometry.isTriangles();
  const uint64_t vertices = triangles ? segments * kRayTriangleVertices : segments + strands;
  const uint64_t indices = segments * (triangles ? kRayTriangleIndices : 2);
  constexpr uint64_t kMostBytes = (uint64_t{1} << 32) - 1;
  if (vertices * 3 * sizeof(float) > kMostBytes || indices * sizeof(uint32_t) > kMostBytes)
    return invalidRays(fmt::format("{} segments need buffers of 4 GB or more", segments));
  geometry.strandCount_ = static_cast<uint32_t>(strands);
  geometry.vertexCount_ = static_cast<uint32_t>(vertices);
  geometry.indexCount_ = static_cast<uint32_t>(indices);
  const auto add = [&](const char* what, uint64_t count) {
    return resources.add({.name = def.name + "/" + what,
                          .size = count * sizeof(float),
                          .stride = sizeof(float),
                          .usage = BufferUsage::kStorage | BufferUsage::kVertex});
  };
  geometry.positions_ = add("positions", vertices * 3);
  if (!triangles) geometry.radii_ = add("radii", vertices);
  const std::vector<uint32_t> words =
      triangles ? triangleIndices(segments) : segmentIndices(strands, geometry.segments_);
  geometry.indices_ =
      resources.add(def.name + "/indices", words, BufferUsage::kStorage | BufferUsage::kIndex);
  return geometry;
}

void RayGeometry::remove(ResourceTable& resources) {
  for (BufferId* buffer : {&positions_, &radii_, &indices_}) {
    if (*buffer != BufferId::kInvalid) resources.remove(*buffer);
    *buffer = BufferId::kInvalid;
  }
}

Result<void> RayGeometry::addPass(const HairObject& hair, PassList& list) const {
  const HairBuffers& buffers = hair.buffers();
  if (positions_ == BufferId::kInvalid || buffers.positions != source_)
    return invalidRays("the object is not that of create(), or the buffers were removed");
  const uint32_t vertices = hair.verticesPerStrand();
  ray_tracing::RayStrandsConstants constants = {};
  constants.rayElements = strandCount_ * (isTriangles() ? segments_ : segments_ + 1);
  constants.rayVertices = vertices;
  constants.raySegments = segments_;
  constants.rayRadius = hair.material.fiberRadius * radiusScale_;
  constants.rayTipChange = hair.material.tipRadiusRatio - 1;
  constants.rayVertexShare = 1 / static_cast<float>(vertices - 1);
  const uint64_t points = uint64_t{strandCount_} * vertices;
  const bool thick = buffers.strandThickness != BufferId::kInvalid;
  ray_tracing::RayStrandsBindings bindings{
      .rayStrandsConstants = constants,
      .rayStrands = {source_, points * sizeof(Float4)},
      .rayPositions = {positions_, uint64_t{vertexCount_} * 3 * sizeof(float)}};
  if (thick) bindings.rayThickness = {buffers.strandThickness, strandCount_ * sizeof(float)};
  if (!isTriangles()) bindings.rayRadii = {radii_, vertexCount_ * sizeof(float)};
  const KernelVariant& variant = isTriangles()
                                     ? ray_tracing::writeRayTrianglesVariant({.thickness = thick})
                                     : ray_tracing::writeRaySpheresVariant({.thickness = thick});
  PassBuilder builder(list);
  const uint32_t row = dispatch::kRowThreads, threads = constants.rayElements;
  builder.dispatch(variant, std::min(threads, row), (threads - 1) / row + 1);
  return builder.bytes(points * sizeof(Float4) + bindings.rayPositions.size).finish(bindings);
}

KernelCodeList rayTracingCode() { return ray_tracing::allCode(); }

}  // namespace pelage
