// Hair objects of a scene: what is wrong with one, and its buffers.
#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <iterator>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "base/finite.h"
#include "base/ids.h"
#include "pelage/constants.h"
#include "pelage/kernels.h"
#include "scene/hair_order.h"
#include "scene/scene_parts.h"
#include "shading/root_uvs.h"
#include "simulation/hair_passes.h"

namespace pelage::detail {

namespace {

constexpr uint32_t kMaxTextureSize = 16384;  // [texels]

// The follow hairs take part in passes of their own.
bool storesFollowHairs(const HairDef& def) {
  return def.storeFollowHairs || def.collidingHair == CollidingHair::kGuidesAndFollows;
}

// Each of these returns what is wrong, or nothing.

std::string faultOfCounts(const HairAsset& asset, const HairDef& def) {
  const uint64_t guides = asset.strandCount, follows = def.followHairs.size();
  const uint64_t mostGuides = kMaxGroups * skinRootsVariant().groupSize[0];
  const uint64_t mostFollows = maxStoredFollows();
  if (guides > mostGuides || (storesFollowHairs(def) && follows > mostFollows)) {
    return "has " + std::to_string(guides) + " guides and " + std::to_string(follows) +
           " follow hairs; an object takes " + std::to_string(mostGuides) + ", and " +
           std::to_string(mostFollows) + " that are stored: use several";
  }
  // Kernels index vertices with 32 bits.
  if (guides + follows > 0x7fffffffu / uint64_t{asset.verticesPerStrand})
    return "has more than 2^31 vertices; use several objects";
  const auto others = [&](const char* what, size_t count) {
    return "has " + std::to_string(guides) + " guides, but " + what + " for " +
           std::to_string(count);
  };
  if (!def.influences.empty() && def.influences.size() != guides)
    return others("bone weights", def.influences.size());
  if (!def.strandFactors.empty() && def.strandFactors.size() != guides)
    return others("strand factors", def.strandFactors.size());
  return {};
}

std::string faultOfEnums(const HairDef& def) {
  const auto none = [](const char* field, uint32_t value, const char* type) {
    return std::string(field) + " is " + std::to_string(value) + ", which is no " + type +
           "; take one of its values";
  };
  if (def.skinning > SkinningMethod::kDualQuaternions)
    return none("HairDef::skinning", static_cast<uint32_t>(def.skinning), "SkinningMethod");
  if (def.collidingHair > CollidingHair::kGuidesAndFollows)
    return none("HairDef::collidingHair", static_cast<uint32_t>(def.collidingHair),
                "CollidingHair");
  return {};
}

std::string faultOfGuides(const HairDef& def, uint32_t boneCount) {
  for (size_t i = 0; i < def.strandFactors.size(); ++i) {
    const StrandFactors& factors = def.strandFactors[i];
    for (const float factor : {factors.stiffness, factors.globalStiffness, factors.damping}) {
      if (!std::isfinite(factor) || factor < 0)
        return "a strand factor of guide " + std::to_string(i) + " is " + std::to_string(factor) +
               ", but must be finite and at least 0";
    }
  }
  for (size_t i = 0; i < def.influences.size(); ++i) {
    for (const uint32_t bone : def.influences[i].bones) {
      if (bone >= boneCount) {
        return "guide " + std::to_string(i) + " refers to bone " + std::to_string(bone) +
               ", but boneCount is " + std::to_string(boneCount);
      }
    }
  }
  return {};
}

std::string faultOfFollows(const HairDef& def, uint32_t guides) {
  for (size_t i = 0; i < def.followHairs.size(); ++i) {
    const FollowHair& hair = def.followHairs[i];
    for (const uint32_t guide : {hair.guide, hair.otherGuides[0], hair.otherGuides[1]}) {
      if (guide >= guides) {
        return "follow hair " + std::to_string(i) + " refers to guide " + std::to_string(guide) +
               " of " + std::to_string(guides);
      }
    }
    if (!isFinite(hair.offset))
      return "the offset of follow hair " + std::to_string(i) + " is not finite";
    const float others[2] = {hair.otherWeights[0], hair.otherWeights[1]};
    if (!(others[0] >= 0 && others[1] >= 0 && others[0] + others[1] <= 1))
      return "the weights of follow hair " + std::to_string(i) + " are not 0 to 1";
  }
  return {};
}

std::string faultOfTexture(const HairAsset& asset, const ColorTexture& texture) {
  const uint64_t texels = uint64_t{texture.width} * texture.height;
  if (texture.width > kMaxTextureSize || texture.height > kMaxTextureSize ||
      texture.texels.size() != texels) {
    return "its texture has " + std::to_string(texture.texels.size()) + " texels for " +
           std::to_string(texture.width) + " x " + std::to_string(texture.height) +
           "; at most 16384 x 16384 are taken";
  }
  if (texels > 0 && asset.strandUv.empty()) return "has a texture, but the asset has no strandUv";
  return {};
}

std::string faultOfUvs(const HairAsset& asset, const HairDef& def) {
  if (!def.strandUvs || !asset.strandUv.empty()) return {};
  return "HairDef::strandUvs is set, but the asset has no strandUv";
}

// [strand] thickness, the follow hairs' that of their guides.
std::vector<float> thicknessOf(const HairAsset& asset, const HairDef& def) {
  std::vector<float> thickness = asset.strandThickness;
  if (thickness.empty()) return thickness;
  thickness.reserve(asset.strandCount + def.followHairs.size());
  for (const FollowHair& follow : def.followHairs)
    thickness.push_back(asset.strandThickness[follow.guide]);
  return thickness;
}

Groom groomOf(std::shared_ptr<const HairAsset> shared, const HairDef& def,
              std::span<const float> thickness) {
  const HairAsset& asset = *shared;
  Groom groom;
  groom.strandFactors.assign(def.strandFactors.begin(), def.strandFactors.end());
  groom.levelOfDetail = def.levelOfDetail;
  const bool follows = !def.followHairs.empty();
  groom.collidesFollowHairs = def.collidingHair == CollidingHair::kGuidesAndFollows && follows;
  groom.storesFollowHairs = storesFollowHairs(def) && follows;
  groom.heldVertices = hasHeldVertices(asset);
  groom.hairsOfGuides.assign(asset.strandCount, 1);
  for (const FollowHair& follow : def.followHairs) ++groom.hairsOfGuides[follow.guide];
  for (const FollowHair& follow : def.followHairs) {
    const float range = std::hypot(follow.offset.x, follow.offset.y, follow.offset.z);
    groom.followRange = std::max(groom.followRange, range);
    groom.followTipRange = std::max(groom.followTipRange, range * std::abs(follow.offset.w));
  }
  groom.textureWidth = def.baseTexture.width;
  groom.textureHeight = def.baseTexture.height;
  groom.influences.assign(def.influences.begin(), def.influences.end());
  groom.firstAsset = std::move(shared);
  if (thickness.empty()) return groom;
  double sum = 0;
  groom.maxThickness = 0;
  for (const float factor : thickness) {
    sum += static_cast<double>(factor);
    groom.maxThickness = std::max(groom.maxThickness, factor);
  }
  groom.meanThickness = static_cast<float>(sum / static_cast<double>(thickness.size()));
  return groom;
}

std::vector<RootBinding> bindingsOf(const HairAsset& asset, const HairDef& def) {
  std::vector<RootBinding> bindings(asset.strandCount);
  for (size_t i = 0; i < bindings.size(); ++i) {
    if (def.influences.empty()) {
      bindings[i].weights = {1, 0, 0, 0};
      continue;
    }
    const BoneInfluences& from = def.influences[i];
    bindings[i].bones = {from.bones[0], from.bones[1], from.bones[2], from.bones[3]};
    bindings[i].weights = {from.weights[0], from.weights[1], from.weights[2], from.weights[3]};
  }
  return bindings;
}

std::vector<FollowHairRecord> recordsOf(std::span<const FollowHair> follows) {
  std::vector<FollowHairRecord> records(follows.size());
  for (size_t i = 0; i < follows.size(); ++i) {
    const FollowHair& hair = follows[i];
    const float* others = hair.otherWeights;
    records[i].offset = hair.offset;
    records[i].guides = {hair.guide, hair.otherGuides[0], hair.otherGuides[1], 0};
    records[i].weights = {1 - others[0] - others[1], others[0], others[1], 0};
  }
  return records;
}

// Two words of two unorms.
std::vector<Uint2> packColors(std::span<const Float4> colors) {
  const auto unorm = [](float value) {
    return static_cast<uint32_t>(
        value > 0 ? std::min(value, 1.0f) * color_packing::kUnormRange + 0.5f : 0);
  };
  std::vector<Uint2> packed;
  packed.reserve(colors.size());
  for (const Float4& c : colors)
    packed.push_back({unorm(c.x) | unorm(c.y) << 16, unorm(c.z) | unorm(c.w) << 16});
  return packed;
}

// The texels, and behind them where each guide is on them.
std::vector<Uint2> textureOf(const HairAsset& asset, const ColorTexture& texture) {
  std::vector<Uint2> words = packColors(texture.texels);
  for (const Float2& uv : asset.strandUv)
    words.push_back({std::bit_cast<uint32_t>(uv.x), std::bit_cast<uint32_t>(uv.y)});
  return words;
}

// One ribbon, shared by all strands: vertex 2 i and 2 i + 1 are the two sides at strand vertex i.
std::vector<uint32_t> ribbonIndices(uint32_t vertices) {
  std::vector<uint32_t> indices;
  for (uint32_t i = 0; i + 1 < vertices; ++i) {
    const uint32_t corner = 2 * i;
    const uint32_t quad[6] = {corner, corner + 1, corner + 2, corner + 2, corner + 1, corner + 3};
    indices.insert(indices.end(), std::begin(quad), std::end(quad));
  }
  return indices;
}

// Adds the buffers that stay as long as the object does.
void addHairBuffers(HairObject& object, const HairAsset& asset, const HairDef& def,
                    const std::vector<float>& thickness, HairStore& store) {
  HairInternals& hair = HairStore::of(object);
  const BufferFactory factory = store.factory();
  const auto add = [&](const char* what, uint64_t count, uint32_t stride,
                       BufferUsage usage = BufferUsage::kStorage) {
    return factory.add(def.name + "/" + what, count, stride, {}, usage);
  };
  const auto table = [&](const char* what, const auto& values) {
    return factory.share(def.name, what, sizeof(values[0]), detail::bytesOf(values));
  };
  HairBuffers& buffers = HairStore::buffersOf(object);
  const uint64_t guides = object.guideCount();
  const uint64_t stored = hair.groom.storesFollowHairs ? object.strandCount() : guides;
  buffers.positions = add("positions", stored * object.verticesPerStrand(), sizeof(Float4));
  buffers.tangents = add("tangents", stored * object.verticesPerStrand(), sizeof(Float4));
  buffers.bindRoots = table("bindRoots", bindRootsOf(asset));
  buffers.rootBindings = table("rootBindings", bindingsOf(asset, def));
  if (hair.skeleton != nullptr) {
    buffers.boneTransforms = bonesFor(*hair.skeleton, def.skinning, factory);
  } else {
    buffers.boneTransforms = add("boneTransforms", rowsOf(def.skinning) * object.boneCount(),
                                 sizeof(Float4), BufferUsage::kStorage | BufferUsage::kUpload);
  }
  if (!def.followHairs.empty())
    buffers.followHairRecords = table("followHairRecords", recordsOf(def.followHairs));
  if (!thickness.empty()) buffers.strandThickness = table("strandThickness", thickness);
  if (!asset.vertexColor.empty())
    buffers.vertexColors = table("vertexColors", packColors(asset.vertexColor));
  if (!def.baseTexture.texels.empty())
    buffers.baseTexture = table("baseTexture", textureOf(asset, def.baseTexture));
  if (def.strandUvs) buffers.strandUvs = table("strandUvs", rootUvsOf(asset));
  buffers.indices = factory.share(def.name, "indices", sizeof(uint32_t),
                                  detail::bytesOf(ribbonIndices(object.verticesPerStrand())),
                                  BufferUsage::kIndex);
}

}  // namespace

Result<HairId> HairStore::addHair(std::shared_ptr<const HairAsset> given, const HairDef& def) {
  const auto refuse = [&](const std::string& what) {
    return Error{ErrorCode::kInvalidArgument, "hair '" + def.name + "': " + what};
  };
  if (given == nullptr) return refuse("the asset is null");
  const HairAsset& asset = *given;
  if (asset.restLengths.empty()) {
    return refuse("the asset has no rest data: call process() on it first, without an error");
  }
  // It may have changed since.
  if (Result<void> valid = pelage::validate(asset); !valid) return refuse(valid.error().message);
  if (Result<void> valid = checkRestData(asset); !valid) return refuse(valid.error().message);
  if (Result<void> valid = validate(def.settings); !valid) return refuse(valid.error().message);
  if (hairSlots.isFull()) return refuse("the scene has as many hair objects as ids");
  const Result<SkeletonPose*> skeleton = findSkeleton(def.skeleton, def.boneCount);
  if (!skeleton) return refuse(skeleton.error().message);
  const uint32_t boneCount = *skeleton != nullptr ? (*skeleton)->boneCount() : def.boneCount;
  if (const std::string fault = faultOfCounts(asset, def); !fault.empty()) return refuse(fault);
  for (const std::string& fault :
       {faultOfEnums(def), faultOfGuides(def, boneCount), faultOfFollows(def, asset.strandCount),
        faultOfTexture(asset, def.baseTexture), faultOfUvs(asset, def)})
    if (!fault.empty()) return refuse(fault);

  const std::vector<float> thickness = thicknessOf(asset, def);
  auto object = std::unique_ptr<HairObject>(
      new HairObject(std::make_unique<HairInternals>(groomOf(given, def, thickness))));
  object->name_ = def.name;
  object->settings = def.settings;
  object->material = def.material;
  object->guideCount_ = asset.strandCount;
  object->followCount_ = static_cast<uint32_t>(def.followHairs.size());
  object->vertexCount_ = asset.verticesPerStrand;
  object->boneCount_ = boneCount;
  object->drawnStrands = object->strandCount();
  HairInternals& hair = *object->internals_;
  setRestData(hair.rest, std::move(given));
  hair.skinning = def.skinning;
  hair.bones.resize(boneCount);
  hair.bounds = boundsOfRoots(asset, def.influences);
  hair.origin.shifted = shifted;
  if (*skeleton != nullptr) {
    hair.skeleton = &of(**skeleton);
    if (hair.skeleton->isOnGpu()) {
      hair.bones = hair.skeleton->bones;
      hair.bounds = boundsOfRoots(asset, {});
      hair.deviation = hair.skeleton->deviation;
    }
    moveOrigin(*hair.skeleton, {hair.bounds.front().bone, hair.bounds.front().center});
  }
  addHairBuffers(*object, asset, def, thickness, *this);
  PassList unused;
  HairFrame first = frameOf(*this, *object, object->settings, FrameMode::kPose, {}, unused);
  hair.get<StrandSolver>().prepare(first);
  return hairSlots.add(std::move(object));
}

void removeHairBuffers(HairBuffers& buffers, HairFrameState& state, bool hasSkeleton,
                       const BufferFactory& factory) {
  removeRooms(state.rooms, buffers, factory);
  if (hasSkeleton) buffers.boneTransforms = BufferId::kInvalid;
  for (BufferId* buffer :
       {&buffers.positions, &buffers.tangents, &buffers.bindRoots, &buffers.rootBindings,
        &buffers.boneTransforms, &buffers.followHairRecords, &buffers.strandThickness,
        &buffers.indices, &buffers.vertexColors, &buffers.baseTexture, &buffers.strandUvs})
    factory.remove(*buffer);
}

HairObject& HairStore::hair(HairId id) const {
  HairObject* object = hairSlots.find(id);
  if (object == nullptr) endForId("hair()", hairSlots.whyNot(id));
  return *object;
}

}  // namespace pelage::detail

namespace pelage {

// Removes copies of the state, and adds up the bytes.
ObjectBytes Scene::bytesOf(HairId id) const {
  detail::HairStore& store = parts_->store;
  const HairObject& object = store.hair(id);
  HairBuffers buffers = object.buffers();
  detail::HairFrameState state = detail::HairStore::of(object);
  HostArray<detail::RemovedBuffer> removed;
  const detail::BufferFactory factory = {store.resources, store.hazards, &removed};
  removeHairBuffers(buffers, state, detail::HairStore::of(object).skeleton != nullptr, factory);
  ObjectBytes bytes;
  for (const detail::RemovedBuffer& buffer : removed) {
    uint64_t& sum = store.shared.contains(buffer.buffer) ? bytes.shared : bytes.own;
    sum += factory.bytesOf(buffer.buffer);
  }
  return bytes;
}

Result<void> Scene::removeHair(HairId id) {
  detail::HairStore& store = parts_->store;
  if (!isValid(id)) return detail::noSuchThing("removeHair()", store.hairSlots.whyNot(id));
  parts_->journal.settle(false);
  HairObject& object = store.hair(id);
  parts_->journal.forgetOwner(&object);
  detail::HairInternals& hair = detail::HairStore::of(object);
  removeHairBuffers(detail::HairStore::buffersOf(object), hair, hair.skeleton != nullptr,
                    store.factory());
  store.hairSlots.remove(id);
  store.removeUnusedCopies();
  parts_->journal.collectShared();
  if (hairCount() == 0)
    parts_->drawing.trim("its buffers went with the last hair object; write it again");
  return {};
}

uint32_t Scene::hairCount() const {
  return static_cast<uint32_t>(std::ranges::distance(parts_->store.hairs()));
}

}  // namespace pelage
