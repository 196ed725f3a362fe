#include "pelage/scene.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <iterator>
#include <numbers>

#include "pelage/gpu_structs.h"
#include "pelage/kernels.h"
#include "pelage/skeleton.h"

namespace pelage {
namespace {

// The step that the artist's 0..1 values are defined at [s].
constexpr double kReferenceStep = 1.0 / 60.0;
// Bit of SimulationConstants::flags, as in kernels/layouts/simulation.hlsli.
constexpr uint32_t kFlagReset = 1;
// Root frames a guide in g_rootTransforms, as there.
constexpr uint64_t kRootTransformSets = 2;
// Stiffness 1 would be an infinite spring.
constexpr double kMaxGlobalStiffness = 0.9999;
// Beyond this the local shape's sweeps overshoot; found by sweeping it on curled strands.
constexpr double kMaxLocalStiffness = 0.95;

template <class T>
std::vector<std::byte> bytesOf(const std::vector<T>& values) {
  const auto bytes = std::as_bytes(std::span(values));
  return {bytes.begin(), bytes.end()};
}

Float3 normalized(Float3 v, Float3 fallback) {
  const float length = std::sqrt(v.x * v.x + v.y * v.y + v.z * v.z);
  if (!(length > 0) || !std::isfinite(length)) return fallback;
  return {v.x / length, v.y / length, v.z / length};
}

bool isZero(Float3 v) { return v.x == 0 && v.y == 0 && v.z == 0; }

// A share s of the way to a goal in 1/60 s as a share for a step of h: a spring of the same
// frequency, solved implicitly.
double mapStiffness(double s, double h) {
  const double ratio = h / kReferenceStep;
  const double spring = ratio * ratio * s / (1 - s);
  return spring / (1 + spring);
}

// Gusts: two incommensurate waves, so that the pattern does not repeat soon; in -1..1.
double gust(double time, double period) {
  const double phase = 2 * std::numbers::pi * time / period;
  return 0.6 * std::sin(phase) + 0.4 * std::sin(2.618 * phase + 1.3);
}

SimulateStrandsKey simulateKey(const SimulationSettings& s) {
  SimulateStrandsKey key;
  key.wind = !isZero(s.wind.velocity) && s.airDrag > 0;
  key.globalShape = s.globalStiffness > 0 && s.globalRange > 0;
  key.localShape = s.localStiffness > 0;
  key.velocityShockPropagation = s.vspCoefficient > 0 || std::isfinite(s.vspThreshold);
  return key;
}

}  // namespace

void HairObject::setBones(std::span<const AffineTransform> bones) {
  PELAGE_ASSERT(bones.size() == boneCount_, "setBones() takes boneCount() transforms");
  const size_t count = std::min<size_t>(bones.size(), boneCount_);
  if (skinning_ == SkinningMethod::kMatrices) {
    for (size_t i = 0; i < count; ++i)
      std::copy(std::begin(bones[i].rows), std::end(bones[i].rows), &boneData_[3 * i]);
  } else {
    for (size_t i = 0; i < count; ++i) {
      const DualQuaternion motion = toDualQuaternion(bones[i]);
      boneData_[2 * i] = motion.real;
      boneData_[2 * i + 1] = motion.dual;
    }
  }
  bonesChanged_ = true;
}

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
  for (size_t i = 0; i < def.influences.size(); ++i) {
    for (const uint32_t bone : def.influences[i].bones) {
      if (bone >= def.boneCount) {
        return refuse("guide " + std::to_string(i) + " refers to bone " + std::to_string(bone) +
                      ", but boneCount is " + std::to_string(def.boneCount));
      }
    }
  }
  for (size_t i = 0; i < follows; ++i) {
    if (def.followHairs[i].guide >= guides) {
      return refuse("follow hair " + std::to_string(i) + " refers to guide " +
                    std::to_string(def.followHairs[i].guide) + " of " + std::to_string(guides));
    }
  }
  Result<std::vector<Float4>> rest = packRest(asset);
  if (!rest) return rest.error();

  auto object = std::unique_ptr<HairObject>(new HairObject);
  object->name_ = def.name;
  object->settings = def.settings;
  object->material = def.material;
  object->skinning_ = def.skinning;
  object->guideCount_ = static_cast<uint32_t>(guides);
  object->followCount_ = static_cast<uint32_t>(follows);
  object->vertexCount_ = static_cast<uint32_t>(vertices);
  object->boneCount_ = def.boneCount;
  object->drawnStrands = object->strandCount();
  const uint32_t rows = def.skinning == SkinningMethod::kMatrices ? 3 : 2;
  object->boneData_.resize(size_t{rows} * def.boneCount);
  const std::vector<AffineTransform> identity(def.boneCount);
  object->setBones(identity);

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
  buffers.positions = add("positions", strands * vertices, sizeof(Float4));
  buffers.tangents = add("tangents", strands * vertices, sizeof(Float4));
  buffers.state = add("state", 2 * guides * vertices, sizeof(Float4));
  buffers.rest = add("rest", rest->size(), sizeof(Float4), bytesOf(*rest));
  buffers.rootTransforms =
      add("rootTransforms", kRootTransformSets * guides, sizeof(RootTransform));

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
  buffers.boneTransforms = add("boneTransforms", object->boneData_.size(), sizeof(Float4), {},
                               BufferUsage::kStorage | BufferUsage::kUpload);

  if (follows > 0) {
    std::vector<FollowStrand> table(follows);
    for (size_t i = 0; i < follows; ++i) {
      table[i].guide = def.followHairs[i].guide;
      table[i].offset = def.followHairs[i].offset;
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

  objects_.push_back(std::move(object));
  return static_cast<HairId>(objects_.size() - 1);
}

void Scene::removeHair(HairId id) {
  const HairBuffers buffers = hair(id).buffers();
  for (const BufferId buffer :
       {buffers.positions, buffers.tangents, buffers.state, buffers.rest, buffers.rootTransforms,
        buffers.rootBindings, buffers.boneTransforms, buffers.followStrands,
        buffers.strandThickness, buffers.indices}) {
    if (buffer == BufferId::kInvalid) continue;
    resources_.remove(buffer);
    hazards_.forget(buffer);
  }
  objects_[static_cast<uint32_t>(id)].reset();
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

Result<void> Scene::simulate(float dt, PassList& list) {
  list.clear();
  if (!std::isfinite(dt) || dt < 0) {
    return Error{ErrorCode::kInvalidArgument,
                 "time step is " + std::to_string(dt) + " s, but must be finite and at least 0"};
  }
  if (dt == 0) return {};
  // A frame of 1/60 s that is a little long by rounding is still one step.
  const double steps = std::ceil(static_cast<double>(dt) / kReferenceStep - 1e-3);
  const auto subSteps = static_cast<uint32_t>(std::clamp(steps, 1.0, double{kMaxSubSteps}));
  const auto frame =
      static_cast<float>(std::min(static_cast<double>(dt), kMaxSubSteps * kReferenceStep));
  for (const auto& object : objects_) {
    if (object == nullptr) continue;
    if (Result<void> done = simulateObject(*object, frame, subSteps, list); !done) {
      list.clear();
      return done;
    }
  }
  time_ += frame;
  return {};
}

Result<void> Scene::simulateObject(HairObject& object, float frame, uint32_t subSteps,
                                   PassList& list) {
  const SimulationSettings& s = object.settings;
  if (Result<void> valid = validate(s); !valid) {
    return Error{valid.error().code, "hair '" + object.name_ + "': " + valid.error().message};
  }
  const HairBuffers& buffers = object.buffers_;
  const uint64_t guides = object.guideCount_;
  const uint64_t follows = object.followCount_;
  const uint64_t vertices = object.vertexCount_;
  constexpr uint64_t kVector = sizeof(Float4);

  const double h = static_cast<double>(frame) / subSteps;
  const double damping = s.damping;
  const double keep = std::pow(1 - damping, h / kReferenceStep);
  const double swell = 1 + static_cast<double>(s.wind.gustStrength) *
                               gust(time_, static_cast<double>(s.wind.gustPeriod));

  SimulationConstants constants = {};
  constants.gravity = {s.gravity.x, s.gravity.y, s.gravity.z, 0};
  const auto wind = [&](float speed) {
    return static_cast<float>(static_cast<double>(speed) * swell);
  };
  constants.wind = {wind(s.wind.velocity.x), wind(s.wind.velocity.y), wind(s.wind.velocity.z),
                    s.airDrag};
  constants.guideCount = object.guideCount_;
  constants.followCount = object.followCount_;
  constants.vertexCount = object.vertexCount_;
  constants.boneCount = object.boneCount_;
  constants.timeStep = static_cast<float>(h);
  constants.dampingKeep = static_cast<float>(keep);
  // What a step of 1/60 s gains at the same terminal velocity.
  constants.gravityStep =
      static_cast<float>(damping > 1e-6 ? h * kReferenceStep * (1 - keep) / damping : h * h);
  constants.localStiffness =
      static_cast<float>(mapStiffness(std::min<double>(s.localStiffness, kMaxLocalStiffness), h));
  constants.globalStiffness =
      static_cast<float>(mapStiffness(std::min<double>(s.globalStiffness, kMaxGlobalStiffness), h));
  constants.globalRange = s.globalRange;
  constants.vspCoefficient = s.vspCoefficient;
  constants.vspThreshold = s.vspThreshold;
  constants.maxSpeed = s.maxSpeed;
  constants.localIterations = s.localIterations;
  constants.lengthIterations = s.lengthIterations;
  constants.tipSeparation = s.tipSeparation;

  const auto bindAll = [&](PassBuilder& pass) -> PassBuilder& {
    return pass.bind("g_positions", buffers.positions, (guides + follows) * vertices * kVector)
        .bind("g_tangents", buffers.tangents, (guides + follows) * vertices * kVector)
        .bind("g_state", buffers.state, 2 * guides * vertices * kVector)
        .bind("g_rest", buffers.rest, 2 * guides * vertices * kVector)
        .bind("g_rootTransforms", buffers.rootTransforms,
              kRootTransformSets * guides * sizeof(RootTransform))
        .bind("g_boneTransforms", buffers.boneTransforms, object.boneData_.size() * kVector)
        .bind("g_rootBindings", buffers.rootBindings, guides * sizeof(RootBinding))
        .bind("g_followStrands", buffers.followStrands, follows * sizeof(FollowStrand))
        .constants("SimulationConstants", constants);
  };

  if (object.bonesChanged_) {
    addUpload(list, buffers.boneTransforms, std::as_bytes(std::span(object.boneData_)));
    object.bonesChanged_ = false;
  }

  PassBuilder builder(list);
  const bool reset = object.resetPending_;
  constants.flags = reset ? kFlagReset : 0;
  constants.timeStepRatio = 1;
  constants.rootBegin = 0;
  constants.rootEnd = 1;
  const bool dual = object.skinning_ == SkinningMethod::kDualQuaternions;
  builder.dispatch(skinRootsVariant({.dualQuaternions = dual}), object.guideCount_);
  if (Result<void> added =
          bindAll(builder)
              .bytes(guides * (sizeof(RootBinding) + kVector + 3 * sizeof(RootTransform)))
              .finish();
      !added)
    return added;

  const KernelVariant& simulate = simulateStrandsVariant(simulateKey(s));
  for (uint32_t step = 0; step < subSteps; ++step) {
    constants.flags = reset && step == 0 ? kFlagReset : 0;
    constants.rootBegin = static_cast<float>(step) / static_cast<float>(subSteps);
    constants.rootEnd = static_cast<float>(step + 1) / static_cast<float>(subSteps);
    constants.timeStepRatio = object.lastStep_ > 0 ? constants.timeStep / object.lastStep_ : 1.0f;
    object.lastStep_ = constants.timeStep;
    builder.dispatch(simulate, object.guideCount_);
    // State read and written twice each, rest data, positions and tangents.
    if (Result<void> added =
            bindAll(builder)
                .bytes(guides * (8 * vertices * kVector + 2 * sizeof(RootTransform)))
                .finish();
        !added)
      return added;
  }
  if (follows > 0) {
    builder.dispatch(updateFollowStrandsVariant({}), object.followCount_, object.vertexCount_);
    if (Result<void> added = bindAll(builder)
                                 .bytes(follows * (sizeof(FollowStrand) + 3 * vertices * kVector))
                                 .finish();
        !added)
      return added;
  }
  object.resetPending_ = false;
  return {};
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

    const HairBuffers& buffers = object.buffers_;
    const uint64_t bytes = uint64_t{object.strandCount()} * object.vertexCount_ * sizeof(Float4);
    DrawState state;
    state.depthCompare = view.reversedDepth ? DepthCompare::kGreater : DepthCompare::kLess;
    const StrandVertexKey key{.strandThickness = buffers.strandThickness != BufferId::kInvalid};
    PassBuilder builder(list);
    builder
        .draw(strandVertexVariant(key), strandPixelVariant({}), state,
              (object.vertexCount_ - 1) * 6, strands, buffers.indices)
        .bind("g_renderPositions", buffers.positions, bytes)
        .bind("g_renderTangents", buffers.tangents, bytes)
        .bind("g_strandThickness", buffers.strandThickness,
              uint64_t{object.strandCount()} * sizeof(float))
        .constants("RenderConstants", constants)
        .bytes(2 * uint64_t{strands} * object.vertexCount_ * sizeof(Float4));
    if (Result<void> added = builder.finish(); !added) return added;
  }
  return {};
}

}  // namespace pelage
