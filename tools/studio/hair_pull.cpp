#include "hair_pull.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <utility>

#include "camera.h"
#include "names.h"
#include "sample/bindings.h"
#include "sample/gpu_structs.h"
#include "sample/kernels.h"

namespace sample {

using pelage::BufferId;

namespace {

constexpr uint32_t kHeldVertices = 2;    // of each strand, held by bones
constexpr float kUnder = 8, kNear = 40;  // [pixels]
// The spring follows the mouse within some frames, and is stable at the longest step, 1/60 s.
constexpr float kSpringRate = 40;  // [1/s]
constexpr float kLimit = 1000;     // [m/s2]

float squaredDistance(const Float4& a, const Float3& b) {
  const float x = a.x - b.x, y = a.y - b.y, z = a.z - b.z;
  return x * x + y * y + z * z;
}

Result<std::vector<Float4>> guidesOf(const pelage::HairObject& hair,
                                     const pelage::BufferReader& read) {
  auto bytes = read(hair.buffers().positions);
  if (!bytes) return bytes.error();
  std::vector<Float4> positions(size_t{hair.guideCount()} * hair.verticesPerStrand());
  if (bytes->size() < positions.size() * sizeof(Float4))
    return pelage::Error{pelage::ErrorCode::kDevice,
                         "the positions of '" + hair.name() + "' that were read are too few"};
  std::memcpy(positions.data(), bytes->data(), positions.size() * sizeof(Float4));
  return positions;
}

}  // namespace

std::optional<PickedVertex> pickVertex(std::span<const Float4> positions,
                                       uint32_t verticesPerStrand, const pelage::View& view,
                                       float x, float y) {
  std::optional<PickedVertex> best;
  float bestAway = kNear;
  for (size_t i = 0; i < positions.size(); ++i) {
    if (i % verticesPerStrand < kHeldVertices) continue;
    const Float3 position = {positions[i].x, positions[i].y, positions[i].z};
    const auto at = project(view, position);
    if (!at) continue;
    const float dx = at->x - x, dy = at->y - y;
    const float away = std::max(std::sqrt(dx * dx + dy * dy), kUnder);
    if (!(away <= bestAway)) continue;
    if (away == bestAway && best && !(at->depth < best->depth)) continue;
    best = {static_cast<uint32_t>(i), position, at->depth};
    bestAway = away;
  }
  return best;
}

void HairPull::ask(const pelage::View& view, float x, float y, float radius) {
  asked_ = {view, x, y, radius};
}

Result<void> HairPull::take(pelage::Scene& scene, std::span<const pelage::HairId> hairs,
                            const pelage::BufferReader& read) {
  const std::optional<Asked> asked = std::exchange(asked_, std::nullopt);
  if (!asked) return {};
  release(scene);
  std::vector<std::vector<Float4>> positions;
  std::optional<PickedVertex> best;
  for (const pelage::HairId id : hairs) {
    const pelage::HairObject& hair = scene.hair(id);
    positions.emplace_back();
    if (!hair.visible || hair.buffers().positions == BufferId::kInvalid) continue;
    auto guides = guidesOf(hair, read);
    if (!guides) return guides.error();
    positions.back() = *std::move(guides);
    const auto picked =
        pickVertex(positions.back(), hair.verticesPerStrand(), asked->view, asked->x, asked->y);
    if (picked && (!best || picked->depth < best->depth)) best = picked;
  }
  if (!best) return {};
  point_ = target_ = best->position;
  for (size_t i = 0; i < hairs.size(); ++i) hold(scene, hairs[i], positions[i], asked->radius);
  return {};
}

// Takes the vertices around the point; the force falls off with their distance.
void HairPull::hold(pelage::Scene& scene, pelage::HairId hair, std::span<const Float4> positions,
                    float radius) {
  std::vector<Float4> taken(positions.begin(), positions.end());
  bool any = false;
  for (Float4& vertex : taken) {
    const float share = squaredDistance(vertex, point_) / (radius * radius);
    vertex.w = share < 1 ? (1 - share) * (1 - share) : 0;
    any |= vertex.w > 0;
  }
  if (!any) return;
  pelage::ResourceTable& resources = scene.resources();
  Lock lock;
  lock.hair = hair;
  lock.vertexCount = static_cast<uint32_t>(taken.size());
  lock.taken = resources.add("pull/taken", taken);
  lock.forces = resources.add(
      {.name = "pull/forces", .size = taken.size() * sizeof(Float4), .stride = sizeof(Float4)});
  scene.hair(hair).setForces(lock.forces);
  locks_.push_back(lock);
}

void HairPull::release(pelage::Scene& scene) {
  asked_.reset();
  for (const Lock& lock : locks_) {
    if (scene.isValid(lock.hair)) scene.hair(lock.hair).setForces(BufferId::kInvalid);
    scene.resources().remove(lock.taken);
    scene.resources().remove(lock.forces);
  }
  locks_.clear();
}

Result<void> HairPull::record(pelage::Scene& scene, pelage::PassList& list) {
  for (const Lock& lock : locks_) {
    if (!scene.isValid(lock.hair)) continue;
    const pelage::ResourceTable& resources = scene.resources();
    PullConstants constants = {};
    constants.pullVertexCount = lock.vertexCount;
    constants.pullStiffness = kSpringRate * kSpringRate;
    constants.pullDamping = 2 * kSpringRate;
    constants.pullLimit = kLimit;
    constants.pullDrag = {target_.x - point_.x, target_.y - point_.y, target_.z - point_.z, 0};
    PullBindings bindings{.pullConstants = constants};
    bindings.pullPositions = resources.whole(scene.hair(lock.hair).buffers().positions);
    bindings.pullTaken = resources.whole(lock.taken);
    bindings.pullForces = resources.whole(lock.forces);
    Result<void> done =
        pelage::PassBuilder(list).dispatch(pullHairVariant({}), lock.vertexCount).finish(bindings);
    if (!done) return done;
  }
  return {};
}

}  // namespace sample
