#include "pelage/scene.h"

#include <algorithm>
#include <cmath>
#include <iterator>

#include "base/ids.h"
#include "pelage/kernels.h"
#include "scene/scene_frame.h"
#include "shadow/strand_shadow.h"

namespace pelage {

using detail::bytesOf;

namespace {

constexpr uint64_t kMostGroups = 65535;  // of a dispatch, on every device

bool isFinite(const Float4& v) {
  return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z) && std::isfinite(v.w);
}

// As kernels/common/color_packing.hlsli reads them.
std::vector<Uint2> packColors(std::span<const Float4> colors) {
  const auto unorm = [](float value) {
    return static_cast<uint32_t>(value > 0 ? std::min(value, 1.0f) * 65535 + 0.5f : 0);
  };
  std::vector<Uint2> packed;
  packed.reserve(colors.size());
  for (const Float4& c : colors)
    packed.push_back({unorm(c.x) | unorm(c.y) << 16, unorm(c.z) | unorm(c.w) << 16});
  return packed;
}

}  // namespace

Result<HairId> Scene::addHair(const HairAsset& asset, const HairDef& def) {
  const auto refuse = [&](const std::string& what) {
    return Error{ErrorCode::kInvalidArgument, "hair '" + def.name + "': " + what};
  };
  if (asset.restLengths.empty()) return refuse("call process() on the asset first");
  if (Result<void> valid = validate(def.settings); !valid) return refuse(valid.error().message);
  if (objects_.isFull()) return refuse("the scene has as many hair objects as ids");
  const Result<SkeletonPose*> skeleton = findSkeleton(def.skeleton, def.boneCount);
  if (!skeleton) return refuse(skeleton.error().message);
  const uint32_t boneCount = *skeleton != nullptr ? (*skeleton)->boneCount() : def.boneCount;
  const uint64_t guides = asset.strandCount;
  const uint64_t follows = def.followHairs.size();
  const uint64_t vertices = asset.verticesPerStrand;
  // What one dispatch takes: of skin_roots, and of update_follow_strands, which may be indirect.
  const uint64_t mostGuides = kMostGroups * skinRootsVariant().groupSize[0];
  const uint64_t mostFollows =
      kMostGroups * updateFollowStrandsVariant({}).groupSize[0] * detail::kFollowsAThread;
  const bool stores = def.storeFollowHairs || def.collidingHair == CollidingHair::kGuidesAndFollows;
  if (guides > mostGuides || (stores && follows > mostFollows)) {
    return refuse("has " + std::to_string(guides) + " guides and " + std::to_string(follows) +
                  " follow hairs; an object takes " + std::to_string(mostGuides) + ", and " +
                  std::to_string(mostFollows) + " that are stored: use several");
  }
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
      if (bone >= boneCount) {
        return refuse("guide " + std::to_string(i) + " refers to bone " + std::to_string(bone) +
                      ", but boneCount is " + std::to_string(boneCount));
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
    if (!isFinite(hair.offset))
      return refuse("the offset of follow hair " + std::to_string(i) + " is not finite");
    const float others[2] = {hair.otherWeights[0], hair.otherWeights[1]};
    if (!(others[0] >= 0 && others[1] >= 0 && others[0] + others[1] <= 1))
      return refuse("the weights of follow hair " + std::to_string(i) + " are not 0 to 1");
  }
  const ColorTexture& texture = def.baseTexture;
  const uint64_t texels = uint64_t{texture.width} * texture.height;
  if (texture.width > 16384 || texture.height > 16384 || texture.texels.size() != texels)
    return refuse("its texture has " + std::to_string(texture.texels.size()) + " texels for " +
                  std::to_string(texture.width) + " x " + std::to_string(texture.height) +
                  "; at most 16384 x 16384 are taken");
  if (texels > 0 && asset.strandUv.empty())
    return refuse("has a texture, but the asset has no strandUv");
  // Checks the rest data, too.
  if (const auto rest = packRest(asset); !rest) return rest.error();

  auto object = std::unique_ptr<HairObject>(new HairObject);
  object->name_ = def.name;
  object->settings = def.settings;
  object->material = def.material;
  object->guideCount_ = static_cast<uint32_t>(guides);
  object->followCount_ = static_cast<uint32_t>(follows);
  object->vertexCount_ = static_cast<uint32_t>(vertices);
  object->boneCount_ = boneCount;
  object->drawnStrands = object->strandCount();
  detail::HairInternals& internals = *object->internals_;
  internals.asset = asset;
  internals.skinning = def.skinning;
  internals.bones.resize(boneCount);
  internals.bounds = detail::boundsOfRoots(asset, def.influences);
  internals.strandFactors.assign(def.strandFactors.begin(), def.strandFactors.end());
  internals.levelOfDetail = def.levelOfDetail;
  internals.collidesFollowHairs =
      def.collidingHair == CollidingHair::kGuidesAndFollows && follows > 0;
  internals.storesFollowHairs =
      (def.storeFollowHairs && follows > 0) || internals.collidesFollowHairs;
  internals.heldVertices = detail::hasHeldVertices(asset);
  internals.origin.shifted = shifted();
  internals.hairsOfGuides.assign(guides, 1);
  for (const FollowHair& follow : def.followHairs) ++internals.hairsOfGuides[follow.guide];
  internals.longestStrand = detail::longestStrand(asset);
  internals.volume =
      static_cast<float>(detail::hairVolume(asset.positions, asset.verticesPerStrand));
  double lengths = 0;
  for (const float length : asset.restLengths) lengths += static_cast<double>(length);
  internals.meanStrand = static_cast<float>(lengths / static_cast<double>(guides));
  for (const FollowHair& follow : def.followHairs) {
    const float reach = std::hypot(follow.offset.x, follow.offset.y, follow.offset.z);
    internals.followReach = std::max(internals.followReach, reach);
    internals.followTipReach =
        std::max(internals.followTipReach, reach * std::abs(follow.offset.w));
  }

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
  if (*skeleton != nullptr) {
    const detail::BoneBounds& bounds = internals.bounds.front();
    internals.skeleton = (*skeleton)->internals_.get();
    detail::moveOrigin(*internals.skeleton, {bounds.bone, bounds.center});
    buffers.boneTransforms = skeletonBuffer(*internals.skeleton, def.skinning);
  } else {
    buffers.boneTransforms = add("boneTransforms", detail::rowsOf(def.skinning) * boneCount,
                                 sizeof(Float4), {}, BufferUsage::kStorage | BufferUsage::kUpload);
  }

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
    double sum = 0;
    internals.largestThickness = 0;
    for (const float factor : thickness) {
      sum += static_cast<double>(factor);
      internals.largestThickness = std::max(internals.largestThickness, factor);
    }
    internals.meanThickness = static_cast<float>(sum / static_cast<double>(thickness.size()));
    buffers.strandThickness =
        add("strandThickness", thickness.size(), sizeof(float), bytesOf(thickness));
  }

  if (!asset.vertexColor.empty())
    buffers.vertexColors = add("vertexColors", asset.vertexColor.size(), sizeof(Uint2),
                               bytesOf(packColors(asset.vertexColor)));
  if (texels > 0) {
    buffers.strandUv =
        add("strandUv", asset.strandUv.size(), sizeof(Float2), bytesOf(asset.strandUv));
    buffers.baseTexture =
        add("baseTexture", texels, sizeof(Uint2), bytesOf(packColors(texture.texels)));
    internals.textureWidth = texture.width;
    internals.textureHeight = texture.height;
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
  return objects_.add(std::move(object));
}

Result<void> Scene::removeHair(HairId id) {
  if (!isValid(id)) return detail::noSuchThing("removeHair()", objects_.whyNot(id));
  settleFrames(false);
  HairObject& object = hair(id);
  forgetOwner(&object);
  removeSolverBuffers(object);
  removeHairGrid(object);
  HairBuffers& buffers = object.buffers_;
  if (object.internals_->skeleton != nullptr) buffers.boneTransforms = BufferId::kInvalid;
  for (BufferId* buffer :
       {&buffers.positions, &buffers.tangents, &buffers.bindRoots, &buffers.rootTransforms,
        &buffers.rootBindings, &buffers.boneTransforms, &buffers.followStrands,
        &buffers.strandThickness, &buffers.indices, &buffers.colliders, &buffers.fields,
        &buffers.vertexColors, &buffers.strandUv, &buffers.baseTexture})
    removeBuffer(*buffer);
  for (BufferId* buffer : object.internals_->followContacts.buffers()) removeBuffer(*buffer);
  objects_.remove(id);
  removeUnusedCopies();
  if (hairCount() == 0) removeDrawBuffers();
  return {};
}

uint64_t Scene::bytesOfBuffer(BufferId id) const {
  const BufferDesc* desc = resources_.find(id);
  return desc != nullptr ? desc->size : 0;
}

HairObject& Scene::hair(HairId id) {
  HairObject* object = objects_.find(id);
  if (object == nullptr) detail::endForId("hair()", objects_.whyNot(id));
  return *object;
}

const HairObject& Scene::hair(HairId id) const { return const_cast<Scene*>(this)->hair(id); }

uint32_t Scene::hairCount() const {
  return static_cast<uint32_t>(
      std::count_if(objects_.begin(), objects_.end(), [](const auto& o) { return o != nullptr; }));
}

}  // namespace pelage
