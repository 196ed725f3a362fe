#include "sdf/iso_surface.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <iterator>

#include "passes/dispatch_rows.h"
#include "pelage/bindings.h"
#include "pelage/constants.h"
#include "pelage/kernels.h"

namespace pelage::detail {
namespace {

using namespace marching_cubes;

// Bytes of a buffer that every device takes (Vulkan's least maxStorageBufferRange).
constexpr uint64_t kMaxBufferBytes = 1u << 27;

uint64_t countOf(const GridSize& nodes) { return uint64_t{nodes[0]} * nodes[1] * nodes[2]; }

Float4 unitVector(const Float3& v) {
  const float length = std::sqrt(v.x * v.x + v.y * v.y + v.z * v.z);
  if (!(length > 0) || !std::isfinite(length)) return {0, 1, 0, 0};
  return {v.x / length, v.y / length, v.z / length, 0};
}

}  // namespace

IsoSurfaceCapacity defaultIsoSurfaceCapacity(const GridSize& nodes) {
  // A sphere crosses the edges along an axis about pi/2 D^2 times, all axes 3/2 pi D^2, and has
  // twice as many triangles.
  const double x = nodes[0], y = nodes[1], z = nodes[2];
  constexpr uint64_t kMaxVertices = kMaxBufferBytes / sizeof(IsoVertex);
  const auto vertices = static_cast<uint32_t>(
      std::clamp(4 * (x * y + y * z + z * x), 1024.0, static_cast<double>(kMaxVertices)));
  return {vertices, 2 * vertices};
}

Result<IsoSurface> IsoSurface::create(ResourceTable& resources, const std::string& name,
                                      const GridSize& nodes, const IsoSurfaceCapacity& capacity) {
  const uint64_t count = countOf(nodes);
  if (count == 0 || nodes[0] > kMaxMarchingRow || std::max(nodes[1], nodes[2]) > kMaxMarchingAxis ||
      count > kMaxMarchingNodes) {
    return Error{ErrorCode::kInvalidArgument,
                 fmt::format("iso surface '{}': a grid of {} x {} x {} nodes is larger than "
                             "marching cubes takes; use larger cells",
                             name, nodes[0], nodes[1], nodes[2])};
  }
  const uint64_t vertexBytes = uint64_t{capacity.vertices} * sizeof(IsoVertex);
  const uint64_t indexBytes = uint64_t{capacity.triangles} * 3 * sizeof(uint32_t);
  if (capacity.vertices == 0 || capacity.triangles == 0 ||
      std::max(vertexBytes, indexBytes) > kMaxBufferBytes) {
    return Error{ErrorCode::kInvalidArgument,
                 fmt::format("iso surface '{}': room for {} vertices and {} triangles is not "
                             "within 1 and {} of each",
                             name, capacity.vertices, capacity.triangles,
                             kMaxBufferBytes / sizeof(IsoVertex))};
  }
  IsoSurface surface;
  surface.name_ = name;
  surface.capacity_ = capacity;
  surface.rowCapacity_ = nodes[1] * nodes[2];
  surface.nodeCapacity_ = static_cast<uint32_t>(count);
  const auto add = [&](Buffer buffer, const char* what, uint64_t elements, uint32_t stride,
                       BufferUsage more) {
    surface.buffers_[buffer] = resources.add({.name = name + "/" + what,
                                              .size = elements * stride,
                                              .stride = stride,
                                              .usage = BufferUsage::kStorage | more});
  };
  add(kField, "isoSdf", 1, sizeof(Sdf), BufferUsage::kUpload);
  add(kRows, "isoRows", surface.rowCapacity_, sizeof(Uint2), BufferUsage::kStorage);
  add(kNodes, "isoNodes", count, sizeof(uint32_t), BufferUsage::kStorage);
  add(kCounts, "isoCounts", 1, sizeof(MarchingCounts), BufferUsage::kReadback);
  add(kVertices, "isoVertices", capacity.vertices, sizeof(IsoVertex),
      BufferUsage::kVertex | BufferUsage::kReadback);
  add(kIndices, "isoIndices", uint64_t{capacity.triangles} * 3, sizeof(uint32_t),
      BufferUsage::kIndex | BufferUsage::kReadback);
  return surface;
}

bool IsoSurface::hasRoomFor(const GridSize& nodes) const {
  return nodes[0] <= kMaxMarchingRow && std::max(nodes[1], nodes[2]) <= kMaxMarchingAxis &&
         countOf(nodes) <= nodeCapacity_ && uint64_t{nodes[1]} * nodes[2] <= rowCapacity_;
}

Result<void> IsoSurface::addPasses(const Sdf& sdf, BufferId keys, uint32_t keyCount, float isoLevel,
                                   PassList& list) const {
  const GridSize nodes = {sdf.nodes.x, sdf.nodes.y, sdf.nodes.z};
  MarchingCubesConstants constants = {};
  constants.isoLevel = isoLevel;
  constants.vertexCapacity = capacity_.vertices;
  constants.triangleCapacity = capacity_.triangles;
  constants.rowCapacity = rowCapacity_;
  constants.nodeCapacity = nodeCapacity_;
  constants.sdfCapacity = 1;
  constants.keyCapacity = keyCount;
  const uint64_t count = countOf(nodes);
  const uint64_t vertexBytes = uint64_t{capacity_.vertices} * sizeof(IsoVertex);
  const uint64_t indexBytes = uint64_t{capacity_.triangles} * 3 * sizeof(uint32_t);
  const uint64_t rowBytes = uint64_t{rowCapacity_} * sizeof(Uint2);
  addUpload(list, buffers_[kField], std::as_bytes(std::span(&sdf, 1)));

  const auto finish = [&](PassBuilder& pass, uint64_t bytes) {
    return pass.bytes(bytes).finish(SDFMarchingCubesBindings{
        .marchingCubesConstants = constants,
        .marchingSdfs = {buffers_[kField], sizeof(Sdf)},
        .marchingKeys = {keys, uint64_t{keyCount} * sizeof(uint32_t)},
        .isoRows = {buffers_[kRows], rowBytes},
        .isoNodes = {buffers_[kNodes], uint64_t{nodeCapacity_} * sizeof(uint32_t)},
        .isoCounts = {buffers_[kCounts], sizeof(MarchingCounts)},
        .isoVertices = {buffers_[kVertices], vertexBytes},
        .isoIndices = {buffers_[kIndices], indexBytes},
    });
  };
  // The kernels detect by themselves that a larger grid does not fit.
  const bool marches = hasRoomFor(nodes) && count > 0;
  PassBuilder pass(list);
  if (marches) {
    pass.dispatch(marchingCubesCountVariant({}), kMarchingCubesCountGroupSize.x, nodes[1],
                  nodes[2]);
    if (Result<void> added = finish(pass, 2 * count * sizeof(uint32_t) + rowBytes); !added)
      return added;
  }
  pass.dispatch(marchingCubesOffsetsVariant({}), 1);
  if (Result<void> added = finish(pass, 3 * rowBytes); !added) return added;
  if (marches) {
    pass.dispatch(marchingCubesEmitVariant({}), nodes[0], nodes[1], nodes[2]);
    if (Result<void> added = finish(pass, 2 * count * sizeof(uint32_t)); !added) return added;
  }
  dispatchRows(pass, marchingCubesPadVariant({}), capacity_.triangles);
  return finish(pass, indexBytes);
}

Result<void> IsoSurface::addDraw(const View& view, const Light& light, const Look& look,
                                 PassList& list) const {
  RenderMeshConstants constants = {};
  std::copy(std::begin(view.worldToClip.rows), std::end(view.worldToClip.rows),
            std::begin(constants.meshToClip));
  std::copy(std::begin(look.sdfToWorld.rows), std::end(look.sdfToWorld.rows),
            std::begin(constants.sdfToWorld));
  constants.meshEye = {view.eye.x, view.eye.y, view.eye.z, 1};
  constants.meshLightDirection = unitVector(light.direction);
  constants.meshLightColor = {light.color.x, light.color.y, light.color.z, 0};
  constants.meshAmbientColor = {light.ambient.x, light.ambient.y, light.ambient.z, 0};
  constants.meshColor = {look.color.x, look.color.y, look.color.z, look.opacity};

  DrawState state;
  state.depthCompare = view.reversedDepth ? DepthCompare::kGreater : DepthCompare::kLess;
  state.depthWrite = look.opacity >= 1;
  state.blend = look.opacity >= 1 ? BlendMode::kOpaque : BlendMode::kPremultipliedAlpha;
  const uint64_t vertexBytes = uint64_t{capacity_.vertices} * sizeof(IsoVertex);
  PassBuilder pass(list);
  return pass
      .draw(isoSurfaceVertexVariant({}), isoSurfacePixelVariant({}), state, capacity_.triangles * 3,
            1, buffers_[kIndices])
      .vertices({buffers_[kVertices], vertexBytes})
      .bytes(uint64_t{capacity_.triangles} * 3 * sizeof(uint32_t))
      .finish(RenderMeshBindings{.renderMeshConstants = constants});
}

Result<IsoSurfaceCapacity> IsoSurface::checkCounts(std::span<const std::byte> counts) const {
  MarchingCounts read = {};
  PELAGE_ASSERT(counts.size() == sizeof(read), "checkCounts() takes what counts() holds");
  std::memcpy(&read, counts.data(), std::min(counts.size(), sizeof(read)));
  if ((read.overflow & (kTooManyVertices | kTooManyTriangles)) != 0) {
    return Error{
        ErrorCode::kOutOfMemory,
        fmt::format("iso surface '{}' has {} vertices and {} triangles, and room for {} "
                    "and {}: make it with a larger capacity or use larger cells",
                    name_, read.vertices, read.triangles, capacity_.vertices, capacity_.triangles)};
  }
  if (read.overflow != 0) {
    return Error{ErrorCode::kInvalidArgument,
                 fmt::format("iso surface '{}' was made for grids of {} nodes in {} rows, and its "
                             "SDF is larger: create it again",
                             name_, nodeCapacity_, rowCapacity_)};
  }
  return IsoSurfaceCapacity{read.vertices, read.triangles};
}

}  // namespace pelage::detail
