#include "skinning/gpu_bones.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <string>
#include <vector>

#include "assets/groom.h"
#include "base/triangle_frame.h"
#include "passes/dispatch_rows.h"
#include "pelage/assert.h"
#include "pelage/bindings.h"
#include "pelage/constants.h"
#include "pelage/gpu_structs.h"
#include "pelage/kernels.h"
#include "pelage/skin_table.h"

namespace pelage::detail {
namespace {

uint32_t floatsOf(BoneLayout layout) {
  switch (layout) {
    case BoneLayout::kRows:
      return 12;
    case BoneLayout::kColumns:
      return 16;
    case BoneLayout::kDualQuaternions:
      return 8;
  }
  return 0;
}

uint32_t strideOf(const BoneBuffer& bones) {
  return bones.stride > 0 ? bones.stride : floatsOf(bones.layout);
}

// Describes the error in `count` elements of `floats` floats in a buffer; empty if there is none.
std::string faultOfRange(const ResourceTable& resources, BufferId id, const std::string& what,
                         uint64_t offset, uint64_t stride, uint64_t count, uint64_t floats) {
  const BufferDesc* buffer = resources.find(id);
  const uint64_t bytes = (offset + stride * (count - 1) + floats) * sizeof(float);
  if (buffer != nullptr && buffer->size >= bytes) return {};
  return "its buffer of " + what +
         (buffer == nullptr ? " does not exist"
                            : " has " + std::to_string(buffer->size) + " bytes") +
         "; " + std::to_string(count) + " of them take " + std::to_string(bytes);
}

std::string faultOfBones(const SkeletonInternals& skeleton, const ResourceTable& resources) {
  const BoneBuffer& bones = skeleton.boneBuffer;
  if (bones.buffer == BufferId::kInvalid)
    return "has no bones yet: call SkeletonPose::setBones() with a buffer first";
  const uint32_t floats = floatsOf(bones.layout);
  if (floats == 0) return "BoneBuffer::layout is no BoneLayout";
  if (strideOf(bones) < floats) {
    return "BoneBuffer::stride is " + std::to_string(bones.stride) + ", but a bone has " +
           std::to_string(floats) + " floats";
  }
  return faultOfRange(resources, bones.buffer, "bones", bones.offset, strideOf(bones),
                      skeleton.boneCount, floats);
}

std::string faultOfVertices(const SkeletonInternals& skeleton, const ResourceTable& resources) {
  if (skeleton.vertices.empty())
    return "has no vertices yet: call SkeletonPose::setVertices() first";
  for (size_t i = 0; i < skeleton.parts.size(); ++i) {
    const SurfacePart& part = skeleton.parts[i];
    if (part.count == 0) continue;
    const VertexBuffer& vertices = skeleton.vertices[i];
    const std::string what = "vertices of part " + std::to_string(i);
    if (vertices.stride < 3) {
      return "the stride of its " + what + " is " + std::to_string(vertices.stride) +
             ", but a position has 3 floats";
    }
    const std::string fault = faultOfRange(resources, vertices.buffer, what, vertices.offset,
                                           vertices.stride, part.vertexCount, 3);
    if (!fault.empty()) return fault;
  }
  return {};
}

Float4 toFloat4(const Vector3<double>& v, double w) {
  const Float3 p = toFloat3(v);
  return {p.x, p.y, p.z, static_cast<float>(w)};
}

// Data of a root for follow_surface.
SurfaceBone surfaceBoneOf(const SurfaceRoot& root, uint32_t strand) {
  const auto frame =
      triangleFrame(toVector(root.bind[0]), toVector(root.bind[1]), toVector(root.bind[2]));
  PELAGE_ASSERT(frame.has_value(), "validate() refuses triangles without area");
  const TriangleFrame bind = frame.value_or(TriangleFrame{});
  SurfaceBone bone = {};
  bone.corners = {root.corners[0], root.corners[1], root.corners[2], strand};
  bone.frameX = toFloat4(bind.x, bind.edge);
  bone.frameY = toFloat4(bind.y, bind.height);
  bone.root = toFloat4(toVector(bindPosition(root)), bind.shear);
  bone.offset = {root.offset.x, root.offset.y, root.offset.z, 0};
  bone.weights = {root.barycentric.y, root.barycentric.z, 0, 0};
  return bone;
}

// The origin as floats, and what they leave of it.
struct SplitOrigin {
  Float4 whole = {}, rest = {};
};

SplitOrigin split(const LocalOrigin& origin) {
  const Vector3<double> at = origin.metres - origin.shifted;
  const Float3 whole = toFloat3(at);
  return {toFloat4(at, 0), toFloat4(at - toVector(whole), 0)};
}

Result<void> addConversion(SkeletonInternals& skeleton, SkinningMethod method,
                           const ResourceTable& resources, PassList& list) {
  const BoneBuffer& bones = skeleton.boneBuffer;
  const SplitOrigin origin = split(skeleton.origin);
  BoneConversionConstants constants = {};
  constants.convertedCount = skeleton.boneCount;
  constants.engineBoneLayout = bones.layout == BoneLayout::kRows ? bone_conversion::kBoneRows
                               : bones.layout == BoneLayout::kColumns
                                   ? bone_conversion::kBoneColumns
                                   : bone_conversion::kBoneDualQuaternions;
  constants.engineBoneStride = strideOf(bones);
  constants.engineBoneOffset = bones.offset;
  constants.boneOrigin = origin.whole;
  constants.boneOriginRest = origin.rest;
  constants.convertToDual = method == SkinningMethod::kDualQuaternions ? 1 : 0;
  const uint64_t written = rowsOf(method) * skeleton.boneCount * sizeof(Float4);
  PassBuilder builder(list);
  dispatchRows(builder, convertBonesVariant(), skeleton.boneCount);
  builder.bytes(written + uint64_t{skeleton.boneCount} * floatsOf(bones.layout) * sizeof(float));
  return builder.finish(BoneConversionBindings{
      .boneConversionConstants = constants,
      .engineBones = resources.whole(bones.buffer),
      .convertedBones = {skeleton.copyFor(method).buffer, written},
  });
}

Result<void> addSurfacePasses(SkeletonInternals& skeleton, SkinningMethod method,
                              const ResourceTable& resources, PassList& list) {
  const SplitOrigin origin = split(skeleton.origin);
  SurfaceBonesConstants constants = {};
  constants.surfaceOrigin = origin.whole;
  constants.surfaceOriginRest = origin.rest;
  constants.surfaceToDual = method == SkinningMethod::kDualQuaternions ? 1 : 0;
  const uint64_t boneBytes = rowsOf(method) * sizeof(Float4);
  for (size_t i = 0; i < skeleton.parts.size(); ++i) {
    const SurfacePart& part = skeleton.parts[i];
    if (part.count == 0) continue;
    constants.surfaceFirst = part.first;
    constants.surfaceCount = part.count;
    constants.surfaceStride = skeleton.vertices[i].stride;
    constants.surfaceOffset = skeleton.vertices[i].offset;
    PassBuilder builder(list);
    dispatchRows(builder, followSurfaceVariant(), part.count);
    builder.bytes(part.count * (sizeof(SurfaceBone) + 9 * sizeof(float) + boneBytes));
    const Result<void> added = builder.finish(SurfaceBonesBindings{
        .surfaceBonesConstants = constants,
        .surfaceBones = resources.whole(skeleton.surfaceBones),
        .surfaceVertices = resources.whole(skeleton.vertices[i].buffer),
        .surfaceTransforms = {skeleton.copyFor(method).buffer, boneBytes * skeleton.boneCount},
    });
    if (!added) return added;
  }
  return {};
}

}  // namespace

std::string faultOf(const SkeletonDef& def) {
  if (def.boneCount == 0) return "boneCount must be at least 1";
  if (def.source > BoneSource::kSurface)
    return "SkeletonDef::source is " + std::to_string(static_cast<uint32_t>(def.source)) +
           ", which is no BoneSource; take one of its values";
  if (!(def.deviation >= 0 && std::isfinite(def.deviation)))
    return "deviation is " + std::to_string(def.deviation) +
           " m, but must be finite and at least 0";
  if ((def.source == BoneSource::kSurface) != (def.surface != nullptr))
    return "SkeletonDef::surface is for BoneSource::kSurface, which needs it";
  if (def.surface == nullptr) return {};
  if (Result<void> valid = validate(*def.surface); !valid) return valid.error().message;
  const size_t roots = def.surface->roots.size();
  if (def.boneCount != 1 && def.boneCount != roots)
    return "boneCount is " + std::to_string(def.boneCount) + ", but the skin table has " +
           std::to_string(roots) + " roots";
  return {};
}

void addSurface(SkeletonInternals& skeleton, const SkinTable& table, const BufferFactory& factory) {
  skeleton.boneCount = static_cast<uint32_t>(table.roots.size());
  skeleton.parts.assign(table.parts.size(), {});
  for (const SurfaceRoot& root : table.roots) {
    SurfacePart& part = skeleton.parts[root.part];
    ++part.count;
    for (const uint32_t corner : root.corners)
      part.vertexCount = std::max(part.vertexCount, corner + 1);
  }
  uint32_t first = 0;
  std::vector<uint32_t> next;
  for (SurfacePart& part : skeleton.parts) {
    part.first = first;
    next.push_back(first);
    first += part.count;
  }
  std::vector<SurfaceBone> bones(table.roots.size());
  for (uint32_t strand = 0; strand < bones.size(); ++strand) {
    const SurfaceRoot& root = table.roots[strand];
    bones[next[root.part]++] = surfaceBoneOf(root, strand);
  }
  skeleton.surfaceBones = factory.add(skeleton.name + "/surfaceBones", bones.size(),
                                      sizeof(SurfaceBone), bytesOf(bones));
}

std::string faultOfSource(const SkeletonInternals& skeleton, const ResourceTable& resources) {
  switch (skeleton.source) {
    case BoneSource::kHost:
      return {};
    case BoneSource::kBuffer:
      return faultOfBones(skeleton, resources);
    case BoneSource::kSurface:
      return faultOfVertices(skeleton, resources);
  }
  return {};
}

Result<void> addBonePasses(SkeletonInternals& skeleton, SkinningMethod method,
                           const ResourceTable& resources, PassList& list) {
  return skeleton.source == BoneSource::kBuffer
             ? addConversion(skeleton, method, resources, list)
             : addSurfacePasses(skeleton, method, resources, list);
}

}  // namespace pelage::detail
