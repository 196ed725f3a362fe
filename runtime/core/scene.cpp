#include "pelage/scene.h"

#include <algorithm>
#include <cmath>
#include <iterator>

#include "pelage/kernels.h"
#include "scene_frame.h"

namespace pelage {

using detail::bytesOf;

namespace {

Float3 normalized(Float3 v, Float3 fallback) {
  const float length = std::sqrt(v.x * v.x + v.y * v.y + v.z * v.z);
  if (!(length > 0) || !std::isfinite(length)) return fallback;
  return {v.x / length, v.y / length, v.z / length};
}

}  // namespace

Result<HairId> Scene::addHair(const HairAsset& asset, const HairDef& def) {
  const auto refuse = [&](const std::string& what) {
    return Error{ErrorCode::kInvalidArgument, "hair '" + def.name + "': " + what};
  };
  if (asset.restLengths.empty()) return refuse("call process() on the asset first");
  if (Result<void> valid = validate(def.settings); !valid) return refuse(valid.error().message);
  if (def.boneCount == 0) return refuse("boneCount must be at least 1");
  const uint64_t guides = asset.strandCount;
  const uint64_t follows = def.followHairs.size();
  const uint64_t vertices = asset.verticesPerStrand;
  // Kernels index vertices with 32 bits.
  if (guides + follows > 0x7fffffffu / vertices)
    return refuse("has more than 2^31 vertices; use several objects");
  if (!def.influences.empty() && def.influences.size() != guides) {
    return refuse("has " + std::to_string(guides) + " guides, but bone weights for " +
                  std::to_string(def.influences.size()));
  }
  if (!def.strandFactors.empty() && def.strandFactors.size() != guides) {
    return refuse("has " + std::to_string(guides) + " guides, but strand factors for " +
                  std::to_string(def.strandFactors.size()));
  }
  for (size_t i = 0; i < def.strandFactors.size(); ++i) {
    for (const float factor : {def.strandFactors[i].stiffness, def.strandFactors[i].globalStiffness,
                               def.strandFactors[i].damping}) {
      if (!std::isfinite(factor) || factor < 0)
        return refuse("a strand factor of guide " + std::to_string(i) + " is " +
                      std::to_string(factor) + ", but must be finite and at least 0");
    }
  }
  for (size_t i = 0; i < def.influences.size(); ++i) {
    for (const uint32_t bone : def.influences[i].bones) {
      if (bone >= def.boneCount) {
        return refuse("guide " + std::to_string(i) + " refers to bone " + std::to_string(bone) +
                      ", but boneCount is " + std::to_string(def.boneCount));
      }
    }
  }
  for (size_t i = 0; i < follows; ++i) {
    const FollowHair& hair = def.followHairs[i];
    for (const uint32_t guide : {hair.guide, hair.otherGuides[0], hair.otherGuides[1]}) {
      if (guide >= guides) {
        return refuse("follow hair " + std::to_string(i) + " refers to guide " +
                      std::to_string(guide) + " of " + std::to_string(guides));
      }
    }
    const float others[2] = {hair.otherWeights[0], hair.otherWeights[1]};
    if (!(others[0] >= 0 && others[1] >= 0 && others[0] + others[1] <= 1))
      return refuse("the weights of follow hair " + std::to_string(i) + " are not 0 to 1");
  }
  // Checks the rest data, too.
  if (const auto rest = packRest(asset); !rest) return rest.error();

  auto object = std::unique_ptr<HairObject>(new HairObject);
  object->name_ = def.name;
  object->settings = def.settings;
  object->material = def.material;
  object->guideCount_ = static_cast<uint32_t>(guides);
  object->followCount_ = static_cast<uint32_t>(follows);
  object->vertexCount_ = static_cast<uint32_t>(vertices);
  object->boneCount_ = def.boneCount;
  object->drawnStrands = object->strandCount();
  detail::HairInternals& internals = *object->internals_;
  internals.asset = asset;
  internals.skinning = def.skinning;
  internals.bones.resize(def.boneCount);
  internals.bounds = detail::boundsOfRoots(asset, def.influences);
  internals.strandFactors.assign(def.strandFactors.begin(), def.strandFactors.end());
  internals.levelOfDetail = def.levelOfDetail;
  internals.storesFollowHairs = def.storeFollowHairs && follows > 0;
  internals.heldVertices = detail::hasHeldVertices(asset);
  internals.hairsOfGuides.assign(guides, 1);
  for (const FollowHair& follow : def.followHairs) ++internals.hairsOfGuides[follow.guide];
  internals.longestStrand = detail::longestStrand(asset);

  const auto add = [&](const char* what, uint64_t count, uint32_t stride,
                       std::vector<std::byte> initial = {},
                       BufferUsage usage = BufferUsage::kStorage) {
    return resources_.add({.name = def.name + "/" + what,
                           .size = count * stride,
                           .stride = stride,
                           .usage = usage,
                           .initial = std::move(initial)});
  };
  HairBuffers& buffers = object->buffers_;
  const uint64_t strands = guides + follows;
  const uint64_t stored = internals.storesFollowHairs ? strands : guides;
  buffers.positions = add("positions", stored * vertices, sizeof(Float4));
  buffers.tangents = add("tangents", stored * vertices, sizeof(Float4));
  std::vector<Float4> bindRoots;
  bindRoots.reserve(guides);
  for (size_t i = 0; i < guides; ++i) bindRoots.push_back(asset.positions[i * vertices]);
  buffers.bindRoots = add("bindRoots", guides, sizeof(Float4), bytesOf(bindRoots));
  buffers.rootTransforms = add("rootTransforms", 2 * guides, sizeof(RootTransform));

  std::vector<RootBinding> bindings(guides);
  for (size_t i = 0; i < guides; ++i) {
    if (def.influences.empty()) {
      bindings[i].weights = {1, 0, 0, 0};
      continue;
    }
    const BoneInfluences& from = def.influences[i];
    bindings[i].bones = {from.bones[0], from.bones[1], from.bones[2], from.bones[3]};
    bindings[i].weights = {from.weights[0], from.weights[1], from.weights[2], from.weights[3]};
  }
  buffers.rootBindings =
      add("rootBindings", bindings.size(), sizeof(RootBinding), bytesOf(bindings));
  const uint64_t rows = def.skinning == SkinningMethod::kMatrices ? 3 : 2;
  buffers.boneTransforms = add("boneTransforms", rows * def.boneCount, sizeof(Float4), {},
                               BufferUsage::kStorage | BufferUsage::kUpload);

  if (follows > 0) {
    std::vector<FollowStrand> table(follows);
    for (size_t i = 0; i < follows; ++i) {
      const FollowHair& hair = def.followHairs[i];
      const float* others = hair.otherWeights;
      table[i].offset = hair.offset;
      table[i].guides = {hair.guide, hair.otherGuides[0], hair.otherGuides[1], 0};
      table[i].weights = {1 - others[0] - others[1], others[0], others[1], 0};
    }
    buffers.followStrands =
        add("followStrands", table.size(), sizeof(FollowStrand), bytesOf(table));
  }
  if (!asset.strandThickness.empty()) {
    std::vector<float> thickness = asset.strandThickness;
    thickness.reserve(strands);
    for (const FollowHair& follow : def.followHairs)
      thickness.push_back(asset.strandThickness[follow.guide]);
    buffers.strandThickness =
        add("strandThickness", thickness.size(), sizeof(float), bytesOf(thickness));
  }

  // One ribbon, shared by all strands: vertex 2 i and 2 i + 1 are the two sides at strand vertex i.
  std::vector<uint32_t> indices;
  for (uint32_t i = 0; i + 1 < vertices; ++i) {
    const uint32_t corner = 2 * i;
    const uint32_t quad[6] = {corner, corner + 1, corner + 2, corner + 2, corner + 1, corner + 3};
    indices.insert(indices.end(), std::begin(quad), std::end(quad));
  }
  buffers.indices =
      add("indices", indices.size(), sizeof(uint32_t), bytesOf(indices), BufferUsage::kIndex);

  addSolverBuffers(*object);
  objects_.push_back(std::move(object));
  return static_cast<HairId>(objects_.size() - 1);
}

void Scene::removeHair(HairId id) {
  HairObject& object = hair(id);
  removeSolverBuffers(object);
  removeHairGrid(object);
  HairBuffers& buffers = object.buffers_;
  for (BufferId* buffer :
       {&buffers.positions, &buffers.tangents, &buffers.bindRoots, &buffers.rootTransforms,
        &buffers.rootBindings, &buffers.boneTransforms, &buffers.followStrands,
        &buffers.strandThickness, &buffers.indices, &buffers.colliders, &buffers.fields})
    removeBuffer(*buffer);
  objects_[static_cast<uint32_t>(id)].reset();
}

void Scene::removeBuffer(BufferId& buffer) {
  if (buffer == BufferId::kInvalid) return;
  resources_.remove(buffer);
  hazards_.forget(buffer);
  buffer = BufferId::kInvalid;
}

uint64_t Scene::bytesOfBuffer(BufferId id) const {
  const BufferDesc* desc = resources_.find(id);
  return desc != nullptr ? desc->size : 0;
}

HairObject& Scene::hair(HairId id) {
  const auto index = static_cast<uint32_t>(id);
  PELAGE_ASSERT(index < objects_.size() && objects_[index], "no such hair object");
  return *objects_[index];
}

const HairObject& Scene::hair(HairId id) const { return const_cast<Scene*>(this)->hair(id); }

uint32_t Scene::hairCount() const {
  return static_cast<uint32_t>(
      std::count_if(objects_.begin(), objects_.end(), [](const auto& o) { return o != nullptr; }));
}

Result<void> Scene::draw(const View& view, const Light& light, PassList& list) {
  if (view.width == 0 || view.height == 0) {
    return Error{ErrorCode::kInvalidArgument, "the viewport has no pixels"};
  }
  for (const auto& held : objects_) {
    if (held == nullptr || !held->visible) continue;
    const HairObject& object = *held;
    const StrandMaterial& m = object.material;
    const uint32_t strands = std::min(object.drawnStrands, object.strandCount());

    RenderConstants constants = {};
    std::copy(std::begin(view.worldToClip.rows), std::end(view.worldToClip.rows),
              std::begin(constants.worldToClip));
    const Float3 toLight = normalized(light.direction, {0, 1, 0});
    constants.eye = {view.eye.x, view.eye.y, view.eye.z, 1};
    constants.viewport = {view.x, view.y, static_cast<float>(view.width),
                          static_cast<float>(view.height)};
    constants.lightDirection = {toLight.x, toLight.y, toLight.z, 0};
    constants.lightColor = {light.color.x, light.color.y, light.color.z, 0};
    constants.ambientColor = {light.ambient.x, light.ambient.y, light.ambient.z, 0};
    constants.rootColor = {m.rootColor.x, m.rootColor.y, m.rootColor.z, m.opacity};
    constants.tipColor = {m.tipColor.x, m.tipColor.y, m.tipColor.z, 1};
    constants.specular = {m.primaryStrength, m.primaryExponent, m.secondaryStrength,
                          m.secondaryExponent};
    constants.specularShift = {m.primaryShift, m.secondaryShift, 0, 0};
    constants.renderVertexCount = object.vertexCount_;
    constants.renderStrandCount = object.strandCount();
    constants.sampleCount = view.samples;
    constants.seed = view.seed;
    constants.fiberRadius = m.fiberRadius;
    constants.tipRadiusRatio = m.tipRadiusRatio;
    constants.renderGuideCount = object.guideCount_;
    constants.renderTipSeparation = object.settings.tipSeparation;

    const HairBuffers& buffers = object.buffers_;
    const bool stored = object.internals_->storesFollowHairs;
    const uint64_t guides = object.guideCount_;
    const uint64_t strandBytes = object.vertexCount_ * sizeof(Float4);
    const uint64_t bytes = (stored ? object.strandCount() : guides) * strandBytes;
    // Those that the vertex kernel places itself.
    const uint64_t placed = stored || strands <= guides ? 0 : strands - guides;
    DrawState state;
    state.depthCompare = view.reversedDepth ? DepthCompare::kGreater : DepthCompare::kLess;
    const StrandVertexKey key{.strandThickness = buffers.strandThickness != BufferId::kInvalid,
                              .followStrands = placed > 0};
    PassBuilder builder(list);
    builder
        .draw(strandVertexVariant(key), strandPixelVariant({}), state,
              (object.vertexCount_ - 1) * 6, strands, buffers.indices)
        .bind("g_renderPositions", buffers.positions, bytes)
        .bind("g_renderTangents", buffers.tangents, bytes)
        .bind("g_strandThickness", buffers.strandThickness,
              uint64_t{object.strandCount()} * sizeof(float))
        .bind("g_renderFollowStrands", buffers.followStrands,
              uint64_t{object.followCount_} * sizeof(FollowStrand))
        .bind("g_renderRoots", buffers.rootTransforms, 2 * guides * sizeof(RootTransform))
        .constants("RenderConstants", constants)
        .bytes(2 * (strands - placed) * strandBytes + placed * sizeof(FollowStrand) +
               (placed > 0 ? guides * sizeof(RootTransform) : 0));
    if (Result<void> added = builder.finish(); !added) return added;
  }
  return {};
}

}  // namespace pelage
