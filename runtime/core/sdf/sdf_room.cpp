#include "sdf/sdf_room.h"

#include <algorithm>
#include <cmath>
#include <memory>
#include <string>
#include <utility>

#include "assets/groom.h"
#include "assets/prepared_collider.h"
#include "base/finite.h"
#include "passes/dispatch_rows.h"
#include "pelage/assert.h"
#include "pelage/bindings.h"
#include "pelage/constants.h"
#include "pelage/kernels.h"
#include "sdf/dense_sdf.h"
#include "sdf/iso_surface.h"

namespace pelage::detail {

namespace {

constexpr uint64_t kSurfaceBytes = sizeof(Uint4);

// The first element at or behind `element` where the range of a build may begin.
uint64_t nextRange(uint64_t element, uint64_t stride) {
  const uint64_t elements = kSdfRangeAlignment / stride;
  return (element + elements - 1) / elements * elements;
}
// A build of the moved part costs about twice as much per node as a full build.
constexpr float kMostMovedShare = 0.5f;

uint32_t recordElements(const SdfColliderInternals& c) {
  return c.data ? sdf::kSdfStillRecord : sdf::kSdfMovingRecord;
}

uint64_t surfaceElements(const SdfColliderInternals& c) {
  if (c.dense) return 0;
  const uint32_t triangles = c.data ? c.data->triangleCount : c.topology.triangleCount();
  return uint64_t{triangles} * recordElements(c);
}

uint64_t keyCount(const SdfColliderInternals& c) {
  if (c.dense) return nodeCountOf(c.dense->grid);
  return c.data ? c.data->keys.size() : c.plan.nodeCount();
}

bool ownsVertices(const SdfColliderInternals& c) {
  return c.hasMesh() && c.def.vertices == BufferId::kInvalid;
}

template <class T>
BufferId addTable(const BufferFactory& factory, const std::string& name,
                  const std::vector<T>& values) {
  if (values.empty()) return BufferId::kInvalid;
  return factory.add(name, values.size(), sizeof(T), bytesOf(values));
}

// Describes the error in the vertex buffer of an engine; empty if there is none.
std::string faultOfVertices(const ResourceTable& resources, const SdfColliderDef& def,
                            uint64_t count) {
  if (def.vertices == BufferId::kInvalid) return {};
  const BufferDesc* vertices = resources.find(def.vertices);
  const uint64_t floats =
      count == 0 ? 0 : def.vertexOffset + uint64_t{def.vertexStride} * (count - 1) + 3;
  const uint64_t bytes = floats * sizeof(float);
  if (vertices != nullptr && vertices->size >= bytes) return {};
  return "its vertex buffer " +
         (vertices == nullptr ? "does not exist"
                              : "has " + std::to_string(vertices->size) + " bytes") +
         "; " + std::to_string(count) + " vertices take " + std::to_string(bytes);
}

// Describes the error in triangles, vertices and bone weights; empty if there is none.
std::string faultOfMesh(const CollisionMesh& mesh, uint32_t boneCount) {
  if (mesh.indices.empty()) return "has no triangles";
  for (size_t v = 0; v < mesh.positions.size(); ++v)
    if (!isFinite(mesh.positions[v])) return "vertex " + std::to_string(v) + " is not finite";
  if (!mesh.influences.empty() && mesh.influences.size() != mesh.positions.size()) {
    return "has " + std::to_string(mesh.positions.size()) + " vertices, but bone weights for " +
           std::to_string(mesh.influences.size());
  }
  for (size_t v = 0; v < mesh.influences.size(); ++v) {
    for (const uint32_t bone : mesh.influences[v].bones) {
      if (bone >= boneCount) {
        return "vertex " + std::to_string(v) + " refers to bone " + std::to_string(bone) +
               ", but boneCount is " + std::to_string(boneCount);
      }
    }
  }
  return {};
}

// A fiftieth of the longest side of a box.
float defaultCellSize(const Box& box) {
  const float longest =
      std::max({box.high.x - box.low.x, box.high.y - box.low.y, box.high.z - box.low.z});
  return longest > 0 ? longest / 50 : 1;
}

bool meets(const HairReach& hair, ColliderId id) {
  return hair.only == nullptr || std::binary_search(hair.only->begin(), hair.only->end(), id);
}

Result<void> addSkinningPass(SdfColliderInternals& c, const SdfColliderBuffers& b,
                             const ResourceTable& resources, PassList& list) {
  const SkinningMethod method = c.def.skinning;
  if (c.skeleton != nullptr) {
    if (Result<void> sent = sendBones(*c.skeleton, method, resources, list); !sent) return sent;
  } else {
    sendBones(c.bones, c.origin, method, b.bones, list);
  }
  BoneSkinningConstants constants = {};
  constants.skinnedCount = c.vertexCount;
  constants.skinningCount = boneCountOf(c);
  constants.skinningReset = c.builtBones.empty() ? 1 : 0;
  constants.dualQuaternions = method == SkinningMethod::kDualQuaternions ? 1 : 0;
  constants.bindStride = constants.skinnedStride = constants.beforeStride = 3;
  const uint64_t bytes = uint64_t{3} * c.vertexCount * sizeof(float);
  PassBuilder builder(list);
  dispatchRows(builder, skinVerticesVariant(), c.vertexCount)
      .bytes(4 * bytes + c.vertexCount * sizeof(VertexBinding));
  return builder.finish(BoneSkinningBindings{
      .boneSkinningConstants = constants,
      .bindVertices = {b.bindVertices, bytes},
      .vertexBindings = {b.bindings, c.vertexCount * sizeof(VertexBinding)},
      .skinningBones = {b.bones, rowsOf(method) * boneCountOf(c) * kVector},
      .skinned = {b.vertices, bytes},
      .skinnedBefore = {b.verticesBefore, bytes},
  });
}

}  // namespace

Result<ColliderId> SdfRoom::add(const CollisionMesh& mesh, const SdfColliderDef& def,
                                const ColliderBones& bones, const Vector3<double>& shifted,
                                const BufferFactory& factory) {
  const auto refuse = [&](const std::string& what) {
    return Error{ErrorCode::kInvalidArgument, "collider '" + def.name + "': " + what};
  };
  if (const std::string fault = faultOfMesh(mesh, bones.count); !fault.empty())
    return refuse(fault);
  Result<ColliderTopology> topology = topologyOf(mesh);
  if (!topology) return refuse(topology.error().message);
  if (const std::string fault = faultOfVertices(factory.resources, def, mesh.positions.size());
      !fault.empty())
    return refuse(fault);

  auto collider = std::unique_ptr<SdfCollider>(new SdfCollider);
  collider->name_ = def.name;
  SdfColliderInternals& c = *collider->internals_;
  c.def = def;
  c.origin.shifted = shifted;
  c.topology = std::move(*topology);
  c.vertexCount = static_cast<uint32_t>(mesh.positions.size());
  const bool onGpu = bones.skeleton != nullptr && bones.skeleton->isOnGpu();
  c.boneBoxes = onGpu ? boxOfAll(mesh) : boneBoxesOf(mesh);
  c.bones.resize(bones.count);
  c.skeleton = bones.skeleton;
  if (c.skeleton != nullptr) c.bones = c.skeleton->bones;
  for (const Float3& p : mesh.positions) c.vertexBounds = include(c.vertexBounds, p);
  if (!(c.def.cellSize > 0)) c.def.cellSize = defaultCellSize(c.vertexBounds);
  if (c.skeleton != nullptr && !c.boneBoxes.empty()) {
    const BoneBox& first = c.boneBoxes.front();
    moveOrigin(*c.skeleton, {first.bone, middleOf(first.box)});
  }
  Result<std::optional<SdfGridPlan>> plan = planGrid(c);
  if (!plan) return plan.error();

  // Static buffers; those of the grid come with a plan.
  addTables(*collider, factory);
  if (ownsVertices(c) && c.vertexCount > 0) addSkinningBuffers(*collider, mesh, factory);
  const ColliderId id = colliders.add(std::move(collider));
  if (*plan) planCollider(*colliders.find(id), **plan, factory);
  layOut(factory);
  return id;
}

void SdfRoom::addSkinningBuffers(SdfCollider& collider, const CollisionMesh& mesh,
                                 const BufferFactory& factory) {
  SdfColliderInternals& c = *collider.internals_;
  SdfColliderBuffers& buffers = collider.buffers_;
  std::vector<VertexBinding> bindings(c.vertexCount);
  for (size_t v = 0; v < bindings.size(); ++v) {
    bindings[v].weights = {1, 0, 0, 0};
    if (mesh.influences.empty()) continue;
    const BoneInfluences& from = mesh.influences[v];
    bindings[v].bones = {from.bones[0], from.bones[1], from.bones[2], from.bones[3]};
    bindings[v].weights = {from.weights[0], from.weights[1], from.weights[2], from.weights[3]};
  }
  buffers.bindVertices = addTable(factory, c.def.name + "/bindVertices", mesh.positions);
  buffers.bindings = addTable(factory, c.def.name + "/bindings", bindings);
  const auto space = [&](const char* what, uint64_t count, uint32_t stride, BufferUsage usage) {
    return factory.add(c.def.name + "/" + what, count, stride, {}, usage);
  };
  buffers.vertices =
      space("vertices", uint64_t{3} * c.vertexCount, sizeof(float), BufferUsage::kStorage);
  buffers.verticesBefore =
      space("verticesBefore", uint64_t{3} * c.vertexCount, sizeof(float), BufferUsage::kStorage);
  buffers.bones = c.skeleton != nullptr
                      ? bonesFor(*c.skeleton, c.def.skinning, factory)
                      : space("bones", rowsOf(c.def.skinning) * c.bones.size(), kVector,
                              BufferUsage::kStorage | BufferUsage::kUpload);
}

// Replaces the tables of triangles that the build reads.
void SdfRoom::addTables(SdfCollider& collider, const BufferFactory& factory) {
  const SdfColliderInternals& c = *collider.internals_;
  SdfColliderBuffers& buffers = collider.buffers_;
  SdfTables tables = makeSdfTables(c.topology);
  if (c.mirrored) flipWinding(tables);
  const auto replace = [&](BufferId& buffer, const char* what, const auto& values) {
    factory.remove(buffer);
    buffer = addTable(factory, c.def.name + "/" + what, values);
  };
  replace(buffers.pointVertices, "pointVertices", tables.pointVertices);
  replace(buffers.indices, "indices", tables.indices);
  replace(buffers.neighbors, "neighbors", tables.neighbors);
  replace(buffers.fanStarts, "fanStarts", tables.fanStarts);
  replace(buffers.fans, "fans", tables.fans);
}

Result<ColliderId> SdfRoom::add(const SdfData& data, const SdfColliderDef& def,
                                const Vector3<double>& shifted, const BufferFactory& factory) {
  auto collider = std::unique_ptr<SdfCollider>(new SdfCollider);
  collider->name_ = def.name;
  SdfColliderInternals& c = *collider->internals_;
  c.def = def;
  c.data = data;
  c.grid = data.grid;
  c.origin = LocalOrigin{{}, shifted}.near({});
  c.dataNode = toVector(data.grid.origin) - (c.origin.metres - c.origin.shifted);
  const auto end = [&](float origin, uint32_t nodes) {
    return origin + static_cast<float>(nodes - 1) * data.grid.cellSize;
  };
  c.vertexBounds = {
      data.grid.origin,
      {end(data.grid.origin.x, data.grid.nodes[0]), end(data.grid.origin.y, data.grid.nodes[1]),
       end(data.grid.origin.z, data.grid.nodes[2])}};
  c.topology.report.triangleCount = c.topology.report.usedTriangleCount = data.triangleCount;
  const ColliderId id = colliders.add(std::move(collider));
  layOut(factory);
  return id;
}

ColliderId SdfRoom::add(const DenseSdf& sdf, const SdfColliderDef& def,
                        const Vector3<double>& shifted, const BufferFactory& factory) {
  auto collider = std::unique_ptr<SdfCollider>(new SdfCollider);
  collider->name_ = def.name;
  SdfColliderInternals& c = *collider->internals_;
  c.def = def;
  c.def.vertices = BufferId::kInvalid;
  c.dense = sdf;
  c.denseNodes = sdf.grid.nodes;
  c.grid = sdf.grid;
  c.vertexBounds = boxOf(sdf.grid);
  c.origin = LocalOrigin{{}, shifted}.near({});
  const ColliderId id = colliders.add(std::move(collider));
  layOut(factory);
  return id;
}

// All but the surface of draw(), and bones of a skeleton.
std::vector<BufferId*> SdfRoom::buffersOf(SdfColliderBuffers& b, bool hasSkeleton) {
  std::vector<BufferId*> all = {&b.bindVertices,   &b.bindings,      &b.bones,   &b.vertices,
                                &b.verticesBefore, &b.pointVertices, &b.indices, &b.neighbors,
                                &b.fanStarts,      &b.fans,          &b.counts,  &b.points,
                                &b.work,           &b.marks,         &b.votes};
  if (hasSkeleton) std::erase(all, &b.bones);
  return all;
}

SdfRoom::Bytes SdfRoom::bytesOf(ColliderId id, const BufferFactory& factory) {
  SdfCollider& collider = *colliders.find(id);
  const SdfColliderInternals& c = *collider.internals_;
  Bytes bytes;
  for (const BufferId* buffer : buffersOf(collider.buffers_, c.skeleton != nullptr))
    bytes.own += factory.bytesOf(*buffer);
  if (c.isoSurface) {
    for (const BufferId buffer : c.isoSurface->buffers()) bytes.own += factory.bytesOf(buffer);
  }
  if (keys != BufferId::kInvalid)
    bytes.shared = nextRange(c.keyCapacity, sizeof(uint32_t)) * sizeof(uint32_t) +
                   nextRange(surfaceElements(c), kSurfaceBytes) * kSurfaceBytes;
  return bytes;
}

void SdfRoom::remove(ColliderId id, const BufferFactory& factory) {
  SdfCollider& removed = *colliders.find(id);
  removeIsoSurface(removed, factory);
  for (BufferId* buffer : buffersOf(removed.buffers_, removed.internals_->skeleton != nullptr))
    factory.remove(*buffer);
  colliders.remove(id);
  layOut(factory);
}

void SdfRoom::trim(const BufferFactory& factory) {
  for (const auto& held : colliders)
    if (held != nullptr) removeIsoSurface(*held, factory);
}

// Gives every field its place in the shared buffers, which are new: all fields are built again.
void SdfRoom::layOut(const BufferFactory& factory) {
  factory.remove(keys);
  factory.remove(surface);
  uint64_t keyTotal = 0, elements = 0;
  for (const auto& held : colliders) {
    if (held == nullptr) continue;
    SdfColliderInternals& c = *held->internals_;
    c.keyOffset = static_cast<uint32_t>(keyTotal);
    c.surfaceOffset = static_cast<uint32_t>(elements);
    c.keyCapacity = static_cast<uint32_t>(std::max<uint64_t>(c.keyCapacity, keyCount(c)));
    c.buildPending = true;
    // The ranges of two builds do not overlap.
    keyTotal = nextRange(keyTotal + c.keyCapacity, sizeof(uint32_t));
    elements = nextRange(elements + surfaceElements(c), kSurfaceBytes);
  }
  if (keyTotal == 0) return;
  HostArray<std::byte> keyBytes(keyTotal * sizeof(uint32_t));
  const uint64_t records = std::max<uint64_t>(elements, 1) * kSurfaceBytes;
  HostArray<std::byte> recordBytes(records);
  for (const auto& held : colliders) {
    if (held == nullptr || !held->internals_->data) continue;
    const SdfColliderInternals& c = *held->internals_;
    const auto from = std::as_bytes(std::span(c.data->keys));
    std::copy(from.begin(), from.end(), keyBytes.begin() + int64_t{c.keyOffset} * 4);
    const auto fromSurface = std::as_bytes(std::span(c.data->surface));
    std::copy(fromSurface.begin(), fromSurface.end(),
              recordBytes.begin() + int64_t{c.surfaceOffset} * 16);
  }
  constexpr BufferUsage kUsage = BufferUsage::kStorage | BufferUsage::kReadback;
  keys = factory.add("sdf/keys", keyTotal, sizeof(uint32_t), std::move(keyBytes), kUsage);
  surface = factory.add("sdf/surface", records / kSurfaceBytes, kSurfaceBytes,
                        std::move(recordBytes), kUsage);
}

// Takes a new grid, and makes the buffers that are too small for it anew.
// True when the shared buffers are too small for it.
bool SdfRoom::planCollider(SdfCollider& collider, const SdfGridPlan& plan,
                           const BufferFactory& factory) {
  SdfColliderInternals& c = *collider.internals_;
  // The state is relative to the old origin; both are whole metres.
  const LocalOrigin origin = originFor(c);
  const Float3 moved = between(c.origin, origin);
  c.state.origin = {c.state.origin.x + moved.x, c.state.origin.y + moved.y,
                    c.state.origin.z + moved.z};
  c.origin = origin;
  c.plan = plan;
  c.grid = gridOf(c);
  c.buildPending = true;
  const SdfBuildDef def = buildDefOf(c);
  const SdfBufferSizes sizes = sdfBufferSizes(def);
  const auto ensure = [&](BufferId& buffer, const char* what, uint64_t size, uint32_t stride,
                          BufferUsage usage = BufferUsage::kStorage) {
    const BufferDesc* desc = factory.resources.find(buffer);
    if (size == 0 || (desc != nullptr && desc->size >= size)) return;
    factory.remove(buffer);
    buffer = factory.resources.add(
        {.name = c.def.name + "/" + what, .size = size, .stride = stride, .usage = usage});
  };
  SdfColliderBuffers& b = collider.buffers_;
  ensure(b.counts, "counts", sizes.counts, sizeof(uint32_t));
  ensure(b.points, "points", sizes.points, kVector);
  ensure(b.marks, "marks", sizes.marks, sizeof(uint32_t));
  ensure(b.votes, "votes", sizes.votes, sizeof(uint32_t));
  ensure(b.work, "work", sizes.work, sizeof(uint32_t),
         BufferUsage::kStorage | BufferUsage::kIndirect | BufferUsage::kUpload |
             BufferUsage::kReadback);
  const bool grown = plan.nodeCount() > c.keyCapacity;
  // With room from the second time on.
  if (grown && c.keyCapacity > 0)
    c.keyCapacity = static_cast<uint32_t>(plan.nodeCount() + plan.nodeCount() / 4);
  return grown;
}

void SdfRoom::plan(const BufferFactory& factory) {
  bool grown = false;
  BufferFactory own = factory;
  for (size_t i = 0; i < colliders.size(); ++i) {
    if (!plans_[i]) continue;
    own.owner = colliders[i];
    if (planCollider(*colliders[i], *plans_[i], own)) grown = true;
  }
  if (grown) layOut(factory);
}

bool SdfRoom::isInRange(size_t slot, std::span<const HairReach> hair) const {
  const SdfCollider& collider = *colliders[slot];
  if (!collider.enabled) return false;
  const ColliderId id = colliders.idOf(slot);
  const SdfColliderInternals& c = *collider.internals_;
  const Box box = boundsOf(c);
  return std::any_of(hair.begin(), hair.end(), [&](const HairReach& reach) {
    if (!meets(reach, id)) return false;
    Ball ball = reach.ball;
    ball.radius += std::max(collider.margin, 0.0f);
    return reaches(box, ball);
  });
}

// The grids that colliders need in this frame where they have none that does, [collider].
Result<void> SdfRoom::check(std::span<const HairReach> hair, const BufferFactory& factory) {
  plans_.assign(colliders.size(), std::nullopt);
  for (size_t i = 0; i < colliders.size(); ++i) {
    const SdfCollider* collider = colliders[i];
    if (collider == nullptr) continue;
    const auto check = [&](const char* what, float value) {
      if (std::isfinite(value) && value >= 0) return std::string();
      return "collider '" + collider->name_ + "': " + what + " is " + std::to_string(value) +
             ", but must be finite and at least 0";
    };
    for (const std::string& fault :
         {check("margin", collider->margin), check("friction", collider->friction)})
      if (!fault.empty()) return Error{ErrorCode::kInvalidArgument, fault};
    const SdfColliderInternals& c = *collider->internals_;
    if (c.dense) {
      std::string fault = faultOf(*c.dense, factory.resources);
      if (c.dense->grid.nodes != c.denseNodes)
        fault = "its grid has another number of nodes than when it was added: add a collider";
      if (!fault.empty() && isInRange(i, hair))
        return Error{ErrorCode::kInvalidArgument, "collider '" + collider->name_ + "': " + fault};
      continue;
    }
    if (c.data || !isInRange(i, hair)) continue;
    if (const std::string fault = faultOfVertices(factory.resources, c.def, c.vertexCount);
        !fault.empty())
      return Error{ErrorCode::kInvalidArgument, "collider '" + collider->name_ + "': " + fault};
    Result<std::optional<SdfGridPlan>> plan = planGrid(c);
    if (!plan) return plan.error();
    plans_[i] = *plan;
  }
  return {};
}

Result<void> SdfRoom::record(std::span<const HairReach> hair, const BufferFactory& factory,
                             PassList& list) {
  BufferFactory own = factory;
  for (size_t i = 0; i < colliders.size(); ++i) {
    if (colliders[i] == nullptr) continue;
    SdfColliderInternals& c = *colliders[i]->internals_;
    c.wasActive = c.active;
    c.active = isInRange(i, hair);
    c.builtNow = c.moves = false;
    own.owner = colliders[i];
    if (Result<void> done = build(*colliders[i], own, list); !done) return done;
  }
  return {};
}

Result<void> SdfRoom::build(SdfCollider& collider, const BufferFactory& factory, PassList& list) {
  SdfColliderInternals& c = *collider.internals_;
  if (c.dense) return import(c, factory, list);
  if (!c.active || c.data || c.plan.nodeCount() == 0) return {};
  if (const bool mirrored = isMirrored(c); mirrored != c.mirrored) {
    c.mirrored = mirrored;
    c.buildPending = true;
    addTables(collider, factory);
  }
  const float tolerance = c.def.motionTolerance * c.plan.cellSize;
  const bool own = ownsVertices(c);
  const bool changed = own ? motionSinceBuild(c) > tolerance : c.verticesChanged;
  if (!c.buildPending && !changed) return {};

  // Its vertices would be relative to another origin than its grid.
  if (c.skeleton != nullptr && !c.origin.isAt(c.skeleton->origin)) return {};
  const bool whole = c.buildPending || (own && movedShare(c, tolerance) > kMostMovedShare);
  if (own && c.vertexCount > 0) {
    if (Result<void> added = addSkinningPass(c, collider.buffers(), factory.resources, list);
        !added)
      return added;
  }
  // Then the build has no positions from before.
  if (c.resetPending) c.state.cellSize = 0;
  const SdfColliderBuffers& b = collider.buffers_;
  const SdfBuildBuffers buffers = {.vertices = own ? b.vertices : c.def.vertices,
                                   .pointVertices = b.pointVertices,
                                   .indices = b.indices,
                                   .neighbors = b.neighbors,
                                   .fanStarts = b.fanStarts,
                                   .fans = b.fans,
                                   .keys = keys,
                                   .surface = surface,
                                   .counts = b.counts,
                                   .points = b.points,
                                   .work = b.work,
                                   .marks = b.marks,
                                   .votes = b.votes};
  // Motion is from one frame to the next; after a pause it is not known.
  c.moves = c.wasActive && !c.resetPending && !c.builtBones.empty();
  const Result<void> built =
      addSdfBuild(list, factory.resources, buffers, buildDefOf(c),
                  whole ? SdfBuildMode::kFull : SdfBuildMode::kIncremental, c.state);
  if (!built) return built;
  c.builtNow = true;
  c.buildPending = c.resetPending = c.verticesChanged = false;
  c.bonesBefore.swap(c.builtBones);
  c.builtBones = c.bones;
  c.builtVersion = c.skeleton != nullptr ? c.skeleton->version : 0;
  return {};
}

// The keys of an engine's field.
Result<void> SdfRoom::import(SdfColliderInternals& c, const BufferFactory& factory,
                             PassList& list) const {
  const bool changed = c.buildPending || c.resetPending || c.builtVersion != c.denseVersion;
  if (!c.active || !changed) return {};
  const Result<void> added = addImport(*c.dense, c.keyOffset, keys, factory.resources, list);
  if (!added) return added;
  c.builtNow = true;
  c.buildPending = c.resetPending = false;
  c.builtVersion = c.denseVersion;
  return {};
}

double SdfRoom::wayInCells(const HairReach& hair, const BoneMoves& moves, double enough) const {
  double most = 0;
  for (size_t slot = 0; slot < colliders.size(); ++slot) {
    const SdfCollider* held = colliders[slot];
    if (held == nullptr || !held->internals_->active || !meets(hair, colliders.idOf(slot)))
      continue;
    Ball ball = hair.ball;
    ball.radius += held->margin;
    if (reaches(boundsOf(*held->internals_), ball))
      most = std::max(most, detail::wayInCells(*held->internals_, moves, enough));
  }
  return most;
}

const SdfRoom::InReach& SdfRoom::inReach(const HairReach* hair, const LocalOrigin& origin) {
  InReach& found = inReach_;
  found.sdfs.clear();
  found.rebuilt = found.dense = false;
  if (hair == nullptr) return found;
  for (size_t slot = 0; slot < colliders.size(); ++slot) {
    const SdfCollider* held = colliders[slot];
    if (held == nullptr || !held->internals_->active) continue;
    if (!meets(*hair, colliders.idOf(slot))) continue;
    const SdfColliderInternals& c = *held->internals_;
    Ball ball = hair->ball;
    ball.radius += held->margin;
    if (!reaches(boundsOf(c), ball)) continue;
    Sdf sdf = sdfOf(c, origin);
    sdf.margin = held->margin;
    sdf.friction = held->friction;
    found.sdfs.push_back(sdf);
    found.rebuilt = found.rebuilt || c.builtNow;
    found.dense = found.dense || c.dense.has_value();
  }
  return found;
}

Result<SdfData> SdfRoom::copy(ColliderId id, std::span<const std::byte> keyBytesRead,
                              std::span<const std::byte> surfaceBytes) const {
  const SdfColliderInternals& c = *colliders.find(id)->internals_;
  if (c.dense) {
    return Error{ErrorCode::kInvalidArgument,
                 "collider '" + c.def.name + "': its SDF is the engine's, which has it already"};
  }
  if (c.data) {
    SdfData data = *c.data;
    data.grid = c.grid;
    return data;
  }
  const auto refuse = [&](const char* what) {
    return Error{ErrorCode::kInvalidArgument, "collider '" + c.def.name + "': " + what};
  };
  if (c.buildPending) return refuse("is yet to be built; simulate a frame with hair near it");
  SdfData data;
  data.grid = c.grid;
  data.band = c.plan.band;
  data.farRange = c.plan.farRange;
  data.triangleBits = c.plan.triangleBits;
  data.triangleCount = c.topology.triangleCount();
  const uint64_t firstKey = uint64_t{c.keyOffset} * sizeof(uint32_t);
  const uint64_t keyBytes = keyCount(c) * sizeof(uint32_t);
  const uint64_t firstRecord = c.surfaceOffset * kSurfaceBytes;
  const uint64_t recordBytes = surfaceElements(c) * kSurfaceBytes;
  if (keyBytesRead.size() < firstKey + keyBytes || surfaceBytes.size() < firstRecord + recordBytes)
    return refuse("the bytes are fewer than sdfKeys() and sdfSurface() have");
  data.keys.resize(keyCount(c));
  std::copy_n(keyBytesRead.begin() + static_cast<int64_t>(firstKey), keyBytes,
              std::as_writable_bytes(std::span(data.keys)).begin());
  const std::span<const std::byte> records = surfaceBytes.subspan(firstRecord, recordBytes);
  const uint64_t kept = sdf::kSdfStillRecord * kSurfaceBytes;
  data.surface.resize(uint64_t{data.triangleCount} * kept / sizeof(uint32_t));
  const auto to = std::as_writable_bytes(std::span(data.surface));
  for (uint64_t t = 0; t < data.triangleCount; ++t) {
    std::copy_n(records.begin() + static_cast<int64_t>(t * sdf::kSdfMovingRecord * kSurfaceBytes),
                kept, to.begin() + static_cast<int64_t>(t * kept));
  }
  return data;
}

}  // namespace pelage::detail
