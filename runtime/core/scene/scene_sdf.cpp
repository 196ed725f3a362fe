// Colliders of a scene: their buffers, and the passes that build their fields.
#include <algorithm>
#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include "assets/prepared_collider.h"
#include "base/ids.h"
#include "pelage/kernels.h"
#include "scene/scene_frame.h"
#include "sdf/sdf_collider.h"

namespace pelage {

using detail::bytesOf;
using detail::kVector;
using detail::SdfColliderInternals;

namespace {

constexpr uint64_t kRecordBytes = sizeof(Uint4);
constexpr uint32_t kStaticRecord = 4, kMovingRecord = 7;
// Threads of skin_vertices in x, as there.
constexpr uint32_t kSkinningRow = 1u << 20;
// A build of what moved costs about twice a whole one for what it touches.
constexpr float kMostMovedShare = 0.5f;

uint32_t recordElements(const SdfColliderInternals& c) {
  return c.data ? kStaticRecord : kMovingRecord;
}

uint64_t surfaceElements(const SdfColliderInternals& c) {
  const uint32_t triangles = c.data ? c.data->triangleCount : c.topology.triangleCount();
  return uint64_t{triangles} * recordElements(c);
}

uint64_t keyCount(const SdfColliderInternals& c) {
  return c.data ? c.data->keys.size() : c.plan.nodeCount();
}

bool ownsVertices(const SdfColliderInternals& c) {
  return !c.data && c.def.vertices == BufferId::kInvalid;
}

template <class T>
BufferId addTable(ResourceTable& resources, const std::string& name, const std::vector<T>& values) {
  if (values.empty()) return BufferId::kInvalid;
  return resources.add({.name = name,
                        .size = values.size() * sizeof(T),
                        .stride = sizeof(T),
                        .initial = bytesOf(values)});
}

// What is wrong with the vertex buffer of an engine, or nothing.
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

}  // namespace

Result<ColliderId> Scene::addCollider(const CollisionMesh& mesh, const SdfColliderDef& def) {
  const auto refuse = [&](const std::string& what) {
    return Error{ErrorCode::kInvalidArgument, "collider '" + def.name + "': " + what};
  };
  if (Result<void> valid = detail::checkSdfColliderDef(def); !valid)
    return refuse(valid.error().message);
  if (colliders_.isFull()) return refuse("the scene has as many colliders as ids");
  const Result<SkeletonPose*> skeleton = findSkeleton(def.skeleton, def.boneCount);
  if (!skeleton) return refuse(skeleton.error().message);
  if (*skeleton != nullptr && def.vertices != BufferId::kInvalid)
    return refuse("has a vertex buffer, which follows no skeleton");
  const uint32_t boneCount = *skeleton != nullptr ? (*skeleton)->boneCount() : def.boneCount;
  if (!mesh.influences.empty() && mesh.influences.size() != mesh.positions.size()) {
    return refuse("has " + std::to_string(mesh.positions.size()) +
                  " vertices, but bone weights for " + std::to_string(mesh.influences.size()));
  }
  for (size_t v = 0; v < mesh.influences.size(); ++v) {
    for (const uint32_t bone : mesh.influences[v].bones) {
      if (bone >= boneCount) {
        return refuse("vertex " + std::to_string(v) + " refers to bone " + std::to_string(bone) +
                      ", but boneCount is " + std::to_string(boneCount));
      }
    }
  }
  Result<detail::ColliderTopology> topology = detail::topologyOf(mesh);
  if (!topology) return refuse(topology.error().message);
  if (const std::string fault = faultOfVertices(resources_, def, mesh.positions.size());
      !fault.empty())
    return refuse(fault);

  auto collider = std::unique_ptr<SdfCollider>(new SdfCollider);
  collider->name_ = def.name;
  SdfColliderInternals& c = *collider->internals_;
  c.def = def;
  c.origin.shifted = shifted();
  c.topology = std::move(*topology);
  c.vertexCount = static_cast<uint32_t>(mesh.positions.size());
  c.boneBoxes = detail::boneBoxesOf(mesh);
  c.bones.resize(boneCount);
  if (*skeleton != nullptr) {
    c.skeleton = (*skeleton)->internals_.get();
    c.bones = c.skeleton->bones;
  }
  for (const Float3& p : mesh.positions)
    if (detail::isFinite({p, p})) c.vertexBounds = detail::include(c.vertexBounds, p);
  if (!(c.def.cellSize > 0)) {
    const detail::Box& box = c.vertexBounds;
    const float longest =
        box.isEmpty()
            ? 0
            : std::max({box.high.x - box.low.x, box.high.y - box.low.y, box.high.z - box.low.z});
    c.def.cellSize = longest > 0 ? longest / 50 : 1;
  }
  if (c.skeleton != nullptr && !c.boneBoxes.empty()) {
    const detail::BoneBox& first = c.boneBoxes.front();
    detail::moveOrigin(*c.skeleton, {first.bone, detail::middleOf(first.box)});
  }
  Result<std::optional<detail::SdfGridPlan>> plan = detail::planGrid(c);
  if (!plan) return plan.error();

  // Static buffers; those of the grid come with a plan.
  SdfColliderBuffers& buffers = collider->buffers_;
  addColliderTables(*collider);
  if (ownsVertices(c) && c.vertexCount > 0) {
    std::vector<VertexBinding> bindings(c.vertexCount);
    for (size_t v = 0; v < bindings.size(); ++v) {
      bindings[v].weights = {1, 0, 0, 0};
      if (mesh.influences.empty()) continue;
      const BoneInfluences& from = mesh.influences[v];
      bindings[v].bones = {from.bones[0], from.bones[1], from.bones[2], from.bones[3]};
      bindings[v].weights = {from.weights[0], from.weights[1], from.weights[2], from.weights[3]};
    }
    buffers.bindVertices = addTable(resources_, def.name + "/bindVertices", mesh.positions);
    buffers.bindings = addTable(resources_, def.name + "/bindings", bindings);
    const auto space = [&](const char* what, uint64_t count, uint32_t stride, BufferUsage usage) {
      return resources_.add({.name = def.name + "/" + what,
                             .size = count * stride,
                             .stride = stride,
                             .usage = usage});
    };
    buffers.vertices =
        space("vertices", uint64_t{3} * c.vertexCount, sizeof(float), BufferUsage::kStorage);
    buffers.verticesBefore =
        space("verticesBefore", uint64_t{3} * c.vertexCount, sizeof(float), BufferUsage::kStorage);
    buffers.bones = c.skeleton != nullptr
                        ? skeletonBuffer(*c.skeleton, def.skinning)
                        : space("bones", detail::rowsOf(def.skinning) * boneCount, kVector,
                                BufferUsage::kStorage | BufferUsage::kUpload);
  }
  const ColliderId id = colliders_.add(std::move(collider));
  if (*plan) planCollider(this->collider(id), **plan);
  layOutFields();
  return id;
}

// What the build knows of the triangles, in place of what there is.
void Scene::addColliderTables(SdfCollider& collider) {
  const SdfColliderInternals& c = *collider.internals_;
  SdfColliderBuffers& buffers = collider.buffers_;
  detail::SdfTables tables = detail::makeSdfTables(c.topology);
  if (c.mirrored) detail::turnRound(tables);
  const auto replace = [&](BufferId& buffer, const char* what, const auto& values) {
    removeBuffer(buffer);
    buffer = addTable(resources_, c.def.name + "/" + what, values);
  };
  replace(buffers.placeVertices, "placeVertices", tables.placeVertices);
  replace(buffers.indices, "indices", tables.indices);
  replace(buffers.neighbors, "neighbors", tables.neighbors);
  replace(buffers.fanStarts, "fanStarts", tables.fanStarts);
  replace(buffers.fans, "fans", tables.fans);
}

Result<ColliderId> Scene::addCollider(const SdfData& data, const SdfColliderDef& def) {
  if (Result<void> valid = detail::checkSdfColliderDef(def); !valid) {
    return Error{valid.error().code, "collider '" + def.name + "': " + valid.error().message};
  }
  const auto refuse = [&](const char* what) {
    return Error{ErrorCode::kInvalidArgument, "collider '" + def.name + "': " + what};
  };
  if (colliders_.isFull()) return refuse("the scene has as many colliders as ids");
  if (def.skeleton != SkeletonId::kInvalid)
    return refuse("a field that was built before never moves, and follows no skeleton");
  auto collider = std::unique_ptr<SdfCollider>(new SdfCollider);
  collider->name_ = def.name;
  SdfColliderInternals& c = *collider->internals_;
  c.def = def;
  c.data = data;
  c.grid = data.grid;
  c.origin = detail::LocalOrigin{{}, shifted()}.near({});
  c.dataNode = detail::toDouble3(data.grid.origin) - (c.origin.metres - c.origin.shifted);
  const auto end = [&](float origin, uint32_t nodes) {
    return origin + static_cast<float>(nodes - 1) * data.grid.cellSize;
  };
  c.vertexBounds = {
      data.grid.origin,
      {end(data.grid.origin.x, data.grid.nodes[0]), end(data.grid.origin.y, data.grid.nodes[1]),
       end(data.grid.origin.z, data.grid.nodes[2])}};
  c.topology.report.triangleCount = c.topology.report.usedTriangleCount = data.triangleCount;
  const ColliderId id = colliders_.add(std::move(collider));
  layOutFields();
  return id;
}

Result<void> Scene::removeCollider(ColliderId id) {
  if (!isValid(id)) return detail::noSuchThing("removeCollider()", colliders_.whyNot(id));
  settleFrames(false);
  SdfCollider& removed = collider(id);
  forgetOwner(&removed);
  removeIsoSurface(removed);
  SdfColliderBuffers& b = removed.buffers_;
  if (removed.internals_->skeleton != nullptr) b.bones = BufferId::kInvalid;
  for (BufferId* buffer : {&b.bindVertices, &b.bindings, &b.bones, &b.vertices, &b.verticesBefore,
                           &b.placeVertices, &b.indices, &b.neighbors, &b.fanStarts, &b.fans,
                           &b.counts, &b.places, &b.work, &b.marks, &b.votes})
    removeBuffer(*buffer);
  colliders_.remove(id);
  removeUnusedCopies();
  layOutFields();
  return {};
}

SdfCollider& Scene::collider(ColliderId id) {
  SdfCollider* found = colliders_.find(id);
  if (found == nullptr) detail::endForId("collider()", colliders_.whyNot(id));
  return *found;
}

const SdfCollider& Scene::collider(ColliderId id) const {
  return const_cast<Scene*>(this)->collider(id);
}

// Gives every field its place in the shared buffers, which are new: all fields are built again.
void Scene::layOutFields() {
  removeBuffer(sdfKeys_);
  removeBuffer(sdfSurface_);
  uint64_t keys = 0, elements = 0;
  for (const auto& held : colliders_) {
    if (held == nullptr) continue;
    SdfColliderInternals& c = *held->internals_;
    c.keyOffset = static_cast<uint32_t>(keys);
    c.surfaceOffset = static_cast<uint32_t>(elements);
    c.keyCapacity = static_cast<uint32_t>(std::max<uint64_t>(c.keyCapacity, keyCount(c)));
    c.buildPending = true;
    keys += c.keyCapacity;
    elements += surfaceElements(c);
  }
  if (keys == 0) return relayFrames();
  std::vector<std::byte> keyBytes(keys * sizeof(uint32_t));
  const uint64_t records = std::max<uint64_t>(elements, 1) * kRecordBytes;
  std::vector<std::byte> recordBytes(records);
  for (const auto& held : colliders_) {
    if (held == nullptr || !held->internals_->data) continue;
    const SdfColliderInternals& c = *held->internals_;
    const auto from = std::as_bytes(std::span(c.data->keys));
    std::copy(from.begin(), from.end(), keyBytes.begin() + int64_t{c.keyOffset} * 4);
    const auto surface = std::as_bytes(std::span(c.data->surface));
    std::copy(surface.begin(), surface.end(), recordBytes.begin() + int64_t{c.surfaceOffset} * 16);
  }
  sdfKeys_ = resources_.add({.name = "sdf/keys",
                             .size = keys * sizeof(uint32_t),
                             .stride = sizeof(uint32_t),
                             .usage = BufferUsage::kStorage | BufferUsage::kReadback,
                             .initial = std::move(keyBytes)});
  sdfSurface_ = resources_.add({.name = "sdf/surface",
                                .size = records,
                                .stride = kRecordBytes,
                                .usage = BufferUsage::kStorage | BufferUsage::kReadback,
                                .initial = std::move(recordBytes)});
  relayFrames();
}

// Takes a new grid, and makes the buffers that are too small for it anew.
// True when the shared buffers are too small for it.
bool Scene::planCollider(SdfCollider& collider, const detail::SdfGridPlan& plan) {
  SdfColliderInternals& c = *collider.internals_;
  // The state is relative to the old origin; both are whole metres.
  const detail::LocalOrigin origin = detail::originFor(c);
  const Float3 moved = detail::between(c.origin, origin);
  c.state.origin = {c.state.origin.x + moved.x, c.state.origin.y + moved.y,
                    c.state.origin.z + moved.z};
  c.origin = origin;
  c.plan = plan;
  c.grid = detail::gridOf(c);
  c.buildPending = true;
  const detail::SdfBuildDef def = detail::buildDefOf(c);
  const detail::SdfBufferSizes sizes = detail::sdfBufferSizes(def);
  const auto ensure = [&](BufferId& buffer, const char* what, uint64_t size, uint32_t stride,
                          BufferUsage usage = BufferUsage::kStorage) {
    const BufferDesc* desc = resources_.find(buffer);
    if (size == 0 || (desc != nullptr && desc->size >= size)) return;
    removeBuffer(buffer);
    buffer = resources_.add(
        {.name = c.def.name + "/" + what, .size = size, .stride = stride, .usage = usage});
  };
  SdfColliderBuffers& b = collider.buffers_;
  ensure(b.counts, "counts", sizes.counts, sizeof(uint32_t));
  ensure(b.places, "places", sizes.places, kVector);
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

bool Scene::isReached(size_t place) const {
  const SdfCollider& collider = *colliders_[place];
  if (!collider.enabled) return false;
  const ColliderId id = colliders_.idOf(place);
  const SdfColliderInternals& c = *collider.internals_;
  const detail::Box box = c.data ? c.vertexBounds : detail::boundsOf(c);
  return std::any_of(objects_.begin(), objects_.end(), [&](const auto& object) {
    if (object == nullptr || !object->usesMeshColliders) return false;
    if (!detail::meets(*object->internals_, id)) return false;
    detail::Ball ball =
        detail::ballOfCollisions(*object->internals_, object->settings.tipSeparation);
    ball.radius += std::max(collider.margin, 0.0f);
    return detail::reaches(box, ball);
  });
}

// The grids that colliders need in this frame where they have none that does, [collider].
Result<std::vector<std::optional<detail::SdfGridPlan>>> Scene::checkColliders() const {
  std::vector<std::optional<detail::SdfGridPlan>> plans(colliders_.size());
  for (size_t i = 0; i < colliders_.size(); ++i) {
    const SdfCollider* collider = colliders_[i];
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
    if (c.data || !isReached(i)) continue;
    if (const std::string fault = faultOfVertices(resources_, c.def, c.vertexCount); !fault.empty())
      return Error{ErrorCode::kInvalidArgument, "collider '" + collider->name_ + "': " + fault};
    Result<std::optional<detail::SdfGridPlan>> plan = detail::planGrid(c);
    if (!plan) return plan.error();
    plans[i] = *plan;
  }
  return plans;
}

Result<void> Scene::buildCollider(size_t place, PassList& list) {
  SdfCollider& collider = *colliders_[place];
  SdfColliderInternals& c = *collider.internals_;
  c.wasActive = c.active;
  c.active = isReached(place);
  c.builtNow = c.moves = false;
  if (!c.active || c.data || c.plan.nodeCount() == 0) return {};
  if (const bool mirrored = detail::isMirrored(c); mirrored != c.mirrored) {
    c.mirrored = mirrored;
    c.buildPending = true;
    addColliderTables(collider);
  }
  const float tolerance = c.def.motionTolerance * c.plan.cellSize;
  const bool own = ownsVertices(c);
  const bool changed = own ? detail::motionSinceBuild(c) > tolerance : c.verticesChanged;
  if (!c.buildPending && !changed) return {};

  // Its vertices would be relative to another origin than its grid.
  if (c.skeleton != nullptr && !c.origin.isAt(c.skeleton->origin)) return {};
  const bool whole = c.buildPending || (own && detail::movedShare(c, tolerance) > kMostMovedShare);
  if (own && c.vertexCount > 0) {
    if (Result<void> added = addSkinningPass(collider, list); !added) return added;
  }
  // Then the build has no positions from before.
  if (c.resetPending) c.state.cellSize = 0;
  const SdfColliderBuffers& b = collider.buffers_;
  const detail::SdfBuildBuffers buffers = {.vertices = own ? b.vertices : c.def.vertices,
                                           .placeVertices = b.placeVertices,
                                           .indices = b.indices,
                                           .neighbors = b.neighbors,
                                           .fanStarts = b.fanStarts,
                                           .fans = b.fans,
                                           .keys = sdfKeys_,
                                           .surface = sdfSurface_,
                                           .counts = b.counts,
                                           .places = b.places,
                                           .work = b.work,
                                           .marks = b.marks,
                                           .votes = b.votes};
  // Motion is from one frame to the next; after a pause it is not known.
  c.moves = c.wasActive && !c.resetPending && !c.builtBones.empty();
  const Result<void> built = detail::addSdfBuild(
      list, resources_, buffers, detail::buildDefOf(c),
      whole ? detail::SdfBuildMode::kFull : detail::SdfBuildMode::kIncremental, c.state);
  if (!built) return built;
  c.builtNow = true;
  c.buildPending = c.resetPending = c.verticesChanged = false;
  c.builtBones = c.bones;
  return {};
}

Result<void> Scene::addSkinningPass(SdfCollider& collider, PassList& list) {
  SdfColliderInternals& c = *collider.internals_;
  const SdfColliderBuffers& b = collider.buffers_;
  const SkinningMethod method = c.def.skinning;
  if (c.skeleton != nullptr) {
    detail::uploadBones(*c.skeleton, method, list);
  } else {
    const std::vector<Float4> bones = detail::packBones(c.bones, c.origin, method);
    addUpload(list, b.bones, std::as_bytes(std::span(bones)));
  }
  BoneSkinningConstants constants = {};
  constants.skinnedCount = c.vertexCount;
  constants.skinningCount = static_cast<uint32_t>(c.bones.size());
  constants.skinningReset = c.builtBones.empty() ? 1 : 0;
  constants.dualQuaternions = method == SkinningMethod::kDualQuaternions ? 1 : 0;
  constants.bindStride = constants.skinnedStride = constants.beforeStride = 3;
  const uint64_t bytes = uint64_t{3} * c.vertexCount * sizeof(float);
  PassBuilder builder(list);
  builder
      .dispatch(skinVerticesVariant(), std::min(c.vertexCount, kSkinningRow),
                (c.vertexCount + kSkinningRow - 1) / kSkinningRow)
      .bind("g_bindVertices", b.bindVertices, bytes)
      .bind("g_vertexBindings", b.bindings, c.vertexCount * sizeof(VertexBinding))
      .bind("g_skinningBones", b.bones, detail::rowsOf(method) * c.bones.size() * kVector)
      .bind("g_skinned", b.vertices, bytes)
      .bind("g_skinnedBefore", b.verticesBefore, bytes)
      .constants("BoneSkinningConstants", constants)
      .bytes(4 * bytes + c.vertexCount * sizeof(VertexBinding));
  return builder.finish();
}

// The fields that an object's strands can reach.
void Scene::addFields(Frame& frame) {
  detail::HairInternals& internals = frame.internals;
  std::vector<SdfField> fields;
  bool stirred = false;
  if (frame.object.usesMeshColliders) {
    const detail::Ball around =
        detail::ballOfCollisions(internals, frame.object.settings.tipSeparation);
    for (size_t place = 0; place < colliders_.size(); ++place) {
      const SdfCollider* held = colliders_[place];
      if (held == nullptr || !held->internals_->active) continue;
      if (!detail::meets(internals, colliders_.idOf(place))) continue;
      const SdfColliderInternals& c = *held->internals_;
      detail::Ball ball = around;
      ball.radius += held->margin;
      if (!detail::reaches(c.data ? c.vertexBounds : detail::boundsOf(c), ball)) continue;
      SdfField field = detail::fieldOf(c, internals.origin);
      field.margin = held->margin;
      field.friction = held->friction;
      fields.push_back(field);
      stirred = stirred || c.builtNow;
    }
  }
  const std::vector<std::byte> bytes = bytesOf(fields);
  frame.fieldCount = static_cast<uint32_t>(fields.size());
  if (stirred || bytes != internals.fieldsBefore) frame.collidersReplaced = true;
  if (frame.fieldCount > 0 && (frame.fieldCount > internals.fieldCapacity)) {
    removeBuffer(frame.object.buffers_.fields);
    internals.fieldCapacity = frame.fieldCount;
    frame.object.buffers_.fields =
        resources_.add({.name = frame.object.name_ + "/fields",
                        .size = bytes.size(),
                        .stride = sizeof(SdfField),
                        .usage = BufferUsage::kStorage | BufferUsage::kUpload});
    internals.fieldsBefore.clear();
  }
  if (!bytes.empty() && bytes != internals.fieldsBefore)
    addUpload(frame.list, frame.object.buffers_.fields, bytes);
  internals.fieldsBefore = bytes;
}

Result<SdfData> Scene::copyField(ColliderId id, std::span<const std::byte> keys,
                                 std::span<const std::byte> surface) const {
  const SdfColliderInternals& c = *collider(id).internals_;
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
  const uint64_t firstRecord = c.surfaceOffset * kRecordBytes;
  const uint64_t recordBytes = surfaceElements(c) * kRecordBytes;
  if (keys.size() < firstKey + keyBytes || surface.size() < firstRecord + recordBytes)
    return refuse("the bytes are fewer than sdfKeys() and sdfSurface() have");
  data.keys.resize(keyCount(c));
  std::copy_n(keys.begin() + static_cast<int64_t>(firstKey), keyBytes,
              std::as_writable_bytes(std::span(data.keys)).begin());
  const std::span<const std::byte> records = surface.subspan(firstRecord, recordBytes);
  const uint64_t kept = kStaticRecord * kRecordBytes;
  data.surface.resize(uint64_t{data.triangleCount} * kept / sizeof(uint32_t));
  const auto to = std::as_writable_bytes(std::span(data.surface));
  for (uint64_t t = 0; t < data.triangleCount; ++t) {
    std::copy_n(records.begin() + static_cast<int64_t>(t * kMovingRecord * kRecordBytes), kept,
                to.begin() + static_cast<int64_t>(t * kept));
  }
  return data;
}

}  // namespace pelage
