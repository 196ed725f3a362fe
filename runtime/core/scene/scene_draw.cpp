// Drawing of hair: views, lights, materials, and the passes of each kind of transparency.
#include "scene/scene_draw.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

#include "pelage/kernels.h"
#include "scene/scene_frame.h"

namespace pelage {

namespace {

Error refuse(const std::string& what) { return {ErrorCode::kInvalidArgument, "view: " + what}; }

bool isFinite(Float3 v) { return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z); }

Float3 normalized(Float3 v, Float3 fallback) {
  const float length = std::sqrt(v.x * v.x + v.y * v.y + v.z * v.z);
  if (!(length > 0) || !std::isfinite(length)) return fallback;
  return {v.x / length, v.y / length, v.z / length};
}

// Of a viewport. Kernels take it as an integer.
bool isOffset(float x) { return x >= 0 && x < 65536 && x == std::floor(x); }

Float4 withW(Float3 v, float w) { return {v.x, v.y, v.z, w}; }

Eigen::Matrix4d toMatrix(const Matrix4& m) {
  Eigen::Matrix4d result;
  for (int row = 0; row < 4; ++row) {
    const Float4& r = m.rows[row];
    result.row(row) << double{r.x}, double{r.y}, double{r.z}, double{r.w};
  }
  return result;
}

// The ball is in front of all planes of the frustum, or cuts them.
bool isInFrustum(const View& view, const detail::Ball& ball) {
  const Eigen::Matrix4d clip = toMatrix(view.worldToClip);
  const Eigen::Vector4d center(double{ball.center.x}, double{ball.center.y}, double{ball.center.z},
                               1);
  const Eigen::RowVector4d w = clip.row(3);
  for (const Eigen::RowVector4d& plane :
       {Eigen::RowVector4d(w + clip.row(0)), Eigen::RowVector4d(w - clip.row(0)),
        Eigen::RowVector4d(w + clip.row(1)), Eigen::RowVector4d(w - clip.row(1)),
        Eigen::RowVector4d(clip.row(2)), Eigen::RowVector4d(w - clip.row(2))}) {
    if (plane * center < -double{ball.radius} * plane.head<3>().norm()) return false;
  }
  return true;
}

Result<StrandViewConstants> viewConstants(const View& view, std::span<const Light> lights) {
  StrandViewConstants constants = {};
  std::copy(std::begin(view.worldToClip.rows), std::end(view.worldToClip.rows),
            std::begin(constants.worldToClip));
  const Eigen::Matrix4d inverse = toMatrix(view.worldToClip).inverse();
  for (int row = 0; row < 4; ++row) {
    const Eigen::Vector4f r = inverse.row(row).cast<float>();
    if (!r.allFinite()) return refuse("worldToClip has no inverse, or values that are not finite");
    constants.clipToWorld[row] = {r.x(), r.y(), r.z(), r.w()};
  }
  if (!isFinite(view.eye)) return refuse("the eye is not finite");
  constants.eye = withW(view.eye, 1);
  if (!isOffset(view.x) || !isOffset(view.y)) {
    return refuse("begins at (" + std::to_string(view.x) + ", " + std::to_string(view.y) +
                  "); both are whole numbers from 0 to 65535");
  }
  constants.viewport = {view.x, view.y, static_cast<float>(view.width),
                        static_cast<float>(view.height)};
  constants.reversedDepth = view.reversedDepth ? 1 : 0;
  constants.sampleCount = view.samples;
  constants.seed = view.seed;
  if (lights.size() > kMaxStrandLights) {
    return refuse("has " + std::to_string(lights.size()) + " lights, but at most " +
                  std::to_string(kMaxStrandLights) + " are taken");
  }
  constants.lightCount = static_cast<uint32_t>(lights.size());
  for (size_t i = 0; i < lights.size(); ++i) {
    const Light& light = lights[i];
    if (!isFinite(light.color) || !isFinite(light.ambient) || !isFinite(light.position))
      return refuse("light " + std::to_string(i) + " is not finite");
    constants.lightDirections[i] = light.hasPosition
                                       ? withW(light.position, 1)
                                       : withW(normalized(light.direction, {0, 1, 0}), 0);
    constants.lightColors[i] = withW(light.color, 0);
    constants.lightShadows[i].x = ~0u;
    constants.ambientColor.x += light.ambient.x;
    constants.ambientColor.y += light.ambient.y;
    constants.ambientColor.z += light.ambient.z;
  }
  return constants;
}

}  // namespace

namespace detail {

ShadingParts shadingOf(const StrandMaterial& m) {
  return {static_cast<uint32_t>(m.model),
          {m.diffuseStrength, m.ambientStrength, m.scatteredShare, 0},
          {m.primaryStrength, m.primaryExponent, m.primaryShift, 0},
          {m.secondaryStrength, m.secondaryExponent, m.secondaryShift, m.secondaryTint},
          {m.longitudinalRoughness, m.azimuthalRoughness, m.cuticleTilt, m.refractiveIndex}};
}

void setMaterials(std::span<const HairObject* const> objects, std::span<Uint4> models,
                  std::span<Float4> bodies, std::span<Float4> primaries,
                  std::span<Float4> secondaries, std::span<Float4> fibers) {
  for (size_t i = 0; i < objects.size(); ++i) {
    const ShadingParts shading = shadingOf(objects[i]->material);
    uint32_t Uint4::*const parts[4] = {&Uint4::x, &Uint4::y, &Uint4::z, &Uint4::w};
    models[i / 4].*parts[i % 4] = shading.model;
    bodies[i] = shading.body;
    primaries[i] = shading.primary;
    secondaries[i] = shading.secondary;
    fibers[i] = shading.fiber;
  }
}

DrawState overTarget() {
  DrawState over;
  over.depthCompare = DepthCompare::kAlways;
  over.depthWrite = false;
  over.blend = BlendMode::kPremultipliedAlpha;
  return over;
}

uint32_t strandAttributes(const HairBuffers& buffers) {
  const auto bit = [](BufferId buffer, uint32_t attribute) {
    return buffer != BufferId::kInvalid ? attribute : 0;
  };
  return bit(buffers.strandThickness, kHasThickness) | bit(buffers.vertexColors, kHasVertexColors) |
         bit(buffers.baseTexture, kHasBaseTexture);
}

uint64_t placedStrands(const HairObject& object, const HairInternals& hair) {
  const uint32_t drawn = drawnCount(object);
  const uint32_t guides = object.guideCount();
  return hair.storesFollowHairs || drawn <= guides ? 0 : drawn - guides;
}

}  // namespace detail

using detail::shadingOf;
using detail::ShadingParts;

Result<Scene::DrawFrame> Scene::beginDraw(const View& view, std::span<const Light> lights) const {
  if (view.width == 0 || view.height == 0) return refuse("has no pixels");
  Result<StrandViewConstants> constants = viewConstants(view, lights);
  if (!constants) return constants.error();
  DrawFrame frame = {view, lights, *constants, {}};
  for (const auto& held : objects_) {
    if (held == nullptr || !held->visible || detail::drawnCount(*held) == 0) continue;
    if (isInFrustum(view, detail::ballOfHair(*held->internals_, held->settings.tipSeparation)))
      frame.visible.push_back(held.get());
  }
  return frame;
}

// What draws and dispatches over an object's strands read.
void Scene::offerStrands(const DrawFrame& frame, size_t material, PassBuilder& builder) const {
  const HairObject& object = *frame.visible[material];
  const StrandMaterial& m = object.material;
  const detail::HairInternals& internals = *object.internals_;
  const detail::DrawnStrands strands = detail::drawnStrands(object);

  RenderConstants constants = {};
  const ShadingParts shading = shadingOf(m);
  constants.shadingModel = shading.model;
  constants.shadingBody = shading.body;
  constants.shadingPrimary = shading.primary;
  constants.shadingSecondary = shading.secondary;
  constants.shadingFiber = shading.fiber;
  constants.rootColor = withW(m.rootColor, m.opacity);
  constants.tipColor = withW(m.tipColor, 1);
  constants.strandVariation = m.colorVariation;
  constants.materialIndex = static_cast<uint32_t>(material);
  constants.renderVertexCount = object.vertexCount_;
  constants.renderStrandCount = object.strandCount();
  constants.renderGuideCount = object.guideCount_;
  constants.renderTipSeparation = object.settings.tipSeparation;
  constants.fiberRadius = m.fiberRadius;
  constants.tipRadiusRatio = m.tipRadiusRatio;
  constants.drawnStrands = strands.shown;
  constants.fadingStrands = strands.fading;
  constants.strandWidening = strands.widening;
  constants.textureSize = {internals.textureWidth, internals.textureHeight};
  const HairBuffers& buffers = object.buffers_;
  constants.strandAttributes = detail::strandAttributes(buffers);
  constants.placesFollows = detail::placedStrands(object, internals) > 0 ? 1 : 0;

  const bool stored = internals.storesFollowHairs;
  const uint64_t guides = object.guideCount_;
  const uint64_t strandBytes = object.vertexCount_ * sizeof(Float4);
  const uint64_t bytes = (stored ? object.strandCount() : guides) * strandBytes;
  const uint64_t placed = detail::placedStrands(object, internals);
  // Bound also where there are no follow strands to read.
  const std::pair<BufferId, uint64_t> follows =
      object.followCount_ > 0
          ? std::pair(buffers.followStrands, uint64_t{object.followCount_} * sizeof(FollowStrand))
          : std::pair(buffers.rootTransforms, 2 * guides * sizeof(RootTransform));
  builder.bind("g_renderPositions", buffers.positions, bytes)
      .bind("g_renderTangents", buffers.tangents, bytes)
      .bind("g_strandThickness", buffers.strandThickness,
            uint64_t{object.strandCount()} * sizeof(float))
      .bind("g_renderFollowStrands", follows.first, follows.second)
      .bind("g_renderRoots", buffers.rootTransforms, 2 * guides * sizeof(RootTransform))
      .bind("g_vertexColors", buffers.vertexColors, guides * object.vertexCount_ * sizeof(Uint2))
      .bind("g_strandUv", buffers.strandUv, guides * sizeof(Float2))
      .bind("g_baseTexture", buffers.baseTexture,
            uint64_t{internals.textureWidth} * internals.textureHeight * sizeof(Uint2))
      .bind("g_shadowWords", shadowWords_, bytesOfBuffer(shadowWords_))
      .constants("RenderConstants", constants)
      .constants("StrandViewConstants", frame.constants)
      .bytes(2 * (strands.count - placed) * strandBytes + placed * sizeof(FollowStrand) +
             (placed > 0 ? guides * sizeof(RootTransform) : 0));
  // Stand-ins for the attributes that the object lacks: bound beside the others, but not read.
  for (const char* name : {"g_strandThickness", "g_vertexColors", "g_strandUv", "g_baseTexture"})
    builder.bind(name, buffers.positions, bytes);
}

Result<void> Scene::addStrandDraw(const DrawFrame& frame, size_t material, bool smooth,
                                  const KernelVariant& pixel, DrawState state,
                                  const detail::DrawOffers& offers, PassList& list) const {
  const HairObject& object = *frame.visible[material];
  const HairBuffers& buffers = object.buffers_;
  state.depthCompare = frame.view.reversedDepth ? DepthCompare::kGreater : DepthCompare::kLess;
  const StrandVertexKey key{.smooth = smooth, .attributes = detail::strandAttributes(buffers) != 0};
  PassBuilder builder(list);
  builder.draw(strandVertexVariant(key), pixel, state, (object.vertexCount_ - 1) * 6,
               detail::drawnCount(object), buffers.indices);
  offerStrands(frame, material, builder);
  for (const detail::DrawOffers::Buffer& offer : offers.buffers)
    builder.bind(offer.name, offer.id, offer.size);
  if (!offers.blockName.empty()) builder.constants(offers.blockName, offers.block);
  return builder.finish();
}

Result<void> Scene::addStrandDraws(const DrawFrame& frame, const KernelVariant& pixel,
                                   const detail::DrawOffers& offers, PassList& list) const {
  DrawState into;
  into.depthWrite = false;
  into.colorWrite = false;
  for (size_t i = 0; i < frame.visible.size(); ++i) {
    if (Result<void> added = addStrandDraw(frame, i, true, pixel, into, offers, list); !added)
      return added;
  }
  return {};
}

Result<void> Scene::addOpaqueDraws(const DrawFrame& frame, bool stochastic, PassList& list) const {
  for (size_t i = 0; i < frame.visible.size(); ++i) {
    if (Result<void> added = addStrandDraw(
            frame, i, false, strandPixelVariant({.stochastic = stochastic}), DrawState{}, {}, list);
        !added)
      return added;
  }
  return {};
}

float Scene::shareForView(HairId id, const View& view, float pixels) const {
  constexpr double kLeast = 1.0 / 64;
  const HairObject& object = hair(id);
  const detail::Ball ball = detail::ballOfStrands(*object.internals_);
  const Eigen::Matrix4d clip = toMatrix(view.worldToClip);
  const Eigen::Vector4d center(double{ball.center.x}, double{ball.center.y}, double{ball.center.z},
                               1);
  // The nearest strands decide.
  const double w = clip.row(3) * center - double{ball.radius} * clip.row(3).head<3>().norm();
  const double pixelsAMetre = 0.5 * view.height * clip.row(1).head<3>().norm() / w;
  const double width = 2 * double{object.material.fiberRadius} * pixelsAMetre;
  const double share = width / double{pixels};
  // Behind or around the eye, and what is not a number, keep all strands.
  if (!(w > 0) || !(share >= 0)) return 1;
  return static_cast<float>(std::clamp(share, kLeast, 1.0));
}

Result<void> Scene::draw(const View& view, const Light& light, PassList& list) {
  settleFrames(false);
  Result<DrawFrame> frame = beginDraw(view, {&light, 1});
  if (!frame) return frame.error();
  if (Result<uint32_t> added = addShadows(*frame, list); !added) return added.error();
  Result<void> added = addOpaqueDraws(*frame, true, list);
  if (added) finishShift();
  return added;
}

Result<void> Scene::draw(const View& view, std::span<const Light> lights,
                         const TransparencySettings& settings, std::vector<PassList>& lists) {
  settleFrames(false);
  if (lists.empty()) lists.resize(1);
  for (size_t i = 1; i < lists.size(); ++i) lists[i].clear();
  Result<DrawFrame> frame = beginDraw(view, lights);
  if (!frame) return frame.error();
  uint64_t vertices = 0;
  for (const HairObject* object : frame->visible)
    vertices += uint64_t{detail::drawnCount(*object)} * object->vertexCount_;
  const Result<TransparencyPlan> plan =
      planTransparency(view.width, view.height, settings, vertices);
  if (!plan) return plan.error();
  if (frame->visible.empty()) return {};
  const bool keepsMaterials =
      settings.method == Transparency::kWindowed || settings.method == Transparency::kTiles;
  if (keepsMaterials && frame->visible.size() > detail::kMaxMaterials) {
    return refuse("has " + std::to_string(frame->visible.size()) +
                  " hair objects in it, but lists and tiles tell at most " +
                  std::to_string(detail::kMaxMaterials) + " apart");
  }
  if (Result<uint32_t> added = addShadows(*frame, lists[0]); !added) return added.error();
  Result<void> added = addTransparency(*frame, settings, *plan, vertices, lists);
  if (added) finishShift();
  return added;
}

Result<void> Scene::addTransparency(const DrawFrame& frame, const TransparencySettings& settings,
                                    const TransparencyPlan& plan, uint64_t vertices,
                                    std::vector<PassList>& lists) {
  switch (settings.method) {
    case Transparency::kAlphaTest:
    case Transparency::kStochastic:
      return addOpaqueDraws(frame, settings.method == Transparency::kStochastic, lists[0]);
    case Transparency::kWindowed:
      if (lists.size() < 2) lists.resize(2);
      return addListPasses(frame, settings, plan, lists);
    case Transparency::kHybrid4:
    case Transparency::kHybrid8:
    case Transparency::kHybrid16:
      if (lists.size() < 3) lists.resize(3);
      return addHybridPasses(frame, detail::layerCount(settings.method), lists);
    case Transparency::kShortCut:
      if (lists.size() < 4) lists.resize(4);
      return addShortCutPasses(frame, lists);
    case Transparency::kTiles:
      if (lists.size() < 2) lists.resize(2);
      return addTilePasses(frame, settings, plan, vertices, lists[1]);
  }
  return {};
}

void Scene::makeRoom(const detail::BufferNeed& need) {
  if (bytesOfBuffer(need.buffer) >= need.bytes) return;
  removeBuffer(need.buffer);
  need.buffer = resources_.add(
      {.name = need.name, .size = need.bytes, .stride = need.stride, .usage = need.usage});
}

Result<void> Scene::addListPasses(const DrawFrame& frame, const TransparencySettings& settings,
                                  const TransparencyPlan& plan, std::vector<PassList>& lists) {
  const View& view = frame.view;
  const bool tail = settings.spillTail;
  const detail::ListSizes sizes = detail::listSizes(view.width, view.height, tail);
  const uint64_t nodeBytes = plan.nodeCount * detail::kNodeBytes;
  constexpr uint32_t kWord = sizeof(uint32_t);
  makeRoom({lists_.heads, "transparency/heads", sizes.headBytes, kWord});
  makeRoom({lists_.nodes, "transparency/nodes", nodeBytes, sizeof(Uint4)});
  makeRoom({lists_.tiles, "transparency/tiles", sizes.tileBytes, kWord});
  makeRoom({lists_.counters, "transparency/counters", detail::kCounterBytes, kWord,
            BufferUsage::kStorage | BufferUsage::kIndirect | BufferUsage::kReadback});
  if (tail)
    makeRoom({lists_.tail, "transparency/tail", sizes.tailBytes, sizeof(Uint4)});
  else
    removeBuffer(lists_.tail);

  PPLLBuildConstants build = {};
  build.listWidth = view.width;
  build.listHeight = view.height;
  build.nodeCapacity = plan.nodeCount;
  build.listTileColumns = sizes.columns;
  PassBuilder clear(lists[0]);
  clear.dispatch(clearPpllVariant({.tail = tail}), view.width, view.height)
      .bind("g_listHeads", lists_.heads, sizes.headBytes)
      .bind("g_listTiles", lists_.tiles, sizes.tileBytes)
      .bind("g_listCounters", lists_.counters, detail::kCounterBytes)
      .bind("g_listTail", lists_.tail, sizes.tailBytes)
      .constants("PPLLBuildConstants", build)
      .bytes(sizes.headBytes + sizes.tailBytes);
  if (Result<void> added = clear.finish(); !added) return added;

  detail::DrawOffers offers;
  offers.buffers = {{"g_listHeads", lists_.heads, sizes.headBytes},
                    {"g_listNodes", lists_.nodes, nodeBytes},
                    {"g_listCounters", lists_.counters, detail::kCounterBytes},
                    {"g_listTiles", lists_.tiles, sizes.tileBytes},
                    {"g_listTail", lists_.tail, sizes.tailBytes}};
  offers.blockName = "PPLLBuildConstants";
  offers.block = std::as_bytes(std::span(&build, 1));
  if (Result<void> added =
          addStrandDraws(frame, ppllBuildVariant({.tail = tail}), offers, lists[0]);
      !added)
    return added;

  PPLLReadConstants read = {};
  detail::setMaterials(frame.visible, read.readModels, read.readBodies, read.readPrimaries,
                       read.readSecondaries, read.readFibers);
  read.readWidth = view.width;
  read.readHeight = view.height;
  read.readNodeCapacity = plan.nodeCount;
  read.readEpsilon = settings.epsilon;
  PassBuilder resolve(lists[1]);
  resolve
      .drawIndirect(oitTileVertexVariant({}), ppllReadVariant({.tail = tail}), detail::overTarget(),
                    lists_.counters)
      .bind("g_tiles", lists_.tiles, sizes.tileBytes)
      .bind("g_readHeads", lists_.heads, sizes.headBytes)
      .bind("g_readNodes", lists_.nodes, nodeBytes)
      .bind("g_readTail", lists_.tail, sizes.tailBytes)
      .bind("g_readShadowWords", shadowWords_, bytesOfBuffer(shadowWords_))
      .constants("OitTileConstants", detail::tileConstants(view.width, view.height))
      .constants("StrandViewConstants", frame.constants)
      .constants("PPLLReadConstants", read);
  return resolve.finish();
}

Result<uint32_t> Scene::castShadows(std::span<const Light> lights, PassList& list) {
  settleFrames(false);
  // Maps do not depend on who looks.
  const View view;
  Result<StrandViewConstants> constants = viewConstants(view, lights);
  if (!constants) return constants.error();
  DrawFrame frame = {view, lights, *constants, {}};
  Result<uint32_t> added = addShadows(frame, list);
  if (added) finishShift();
  return added;
}

// Positions where they are after a shift of the world; maps of the lights that cast shadows, from
// all hair in the scene that is visible to anybody.
Result<uint32_t> Scene::addShadows(DrawFrame& frame, PassList& list) {
  std::vector<detail::ShadowedHair> hairs;
  detail::Ball all;
  for (const auto& held : objects_) {
    if (held == nullptr || !held->visible || detail::drawnCount(*held) == 0) continue;
    const detail::Ball ball = detail::ballOfHair(*held->internals_, held->settings.tipSeparation);
    // One that is anywhere has no map that it fits into.
    if (!std::isfinite(ball.radius)) continue;
    all = hairs.empty() ? ball : detail::ballAround(all, ball);
    hairs.push_back(detail::shadowedHairOf(*held, *held->internals_));
  }
  std::vector<detail::StrandShadowPlan> plans;
  uint32_t words = 0;
  for (size_t i = 0; i < frame.lights.size() && !hairs.empty(); ++i) {
    const Light& light = frame.lights[i];
    if (light.shadow == HairShadow::kNone || light.hasPosition) continue;
    if (plans.size() == kMaxStrandShadows) {
      return refuse("more than " + std::to_string(kMaxStrandShadows) + " lights have a shadow");
    }
    detail::StrandShadowDef def;
    def.toLight = light.direction;
    def.center = all.center;
    def.shifted = shifted();
    def.radius = detail::steadyRadius(all.radius);
    def.size = light.shadowSize;
    def.layers = light.shadow == HairShadow::kDeep ? light.shadowLayers : 0;
    def.firstWord = words;
    Result<detail::StrandShadowPlan> plan = detail::planStrandShadow(def, hairs);
    if (!plan) return plan.error();
    words += plan->words;
    const auto index = static_cast<uint32_t>(plans.size());
    detail::setShadow(frame.constants, index, plan->view);
    frame.constants.lightShadows[i].x = index;
    plans.push_back(*plan);
  }
  if (Result<void> moved = addPendingShifts(list); !moved) return moved.error();
  // Kernels that read shadows have the buffer bound, also where no light has one.
  const uint64_t wordBytes = std::max<uint64_t>(words, 4) * sizeof(uint32_t);
  makeRoom({shadowWords_, "shadows/words", wordBytes, sizeof(uint32_t)});
  makeRoom({shadowViews_, "shadows/views", kMaxStrandShadows * sizeof(StrandShadowView),
            sizeof(StrandShadowView), BufferUsage::kStorage | BufferUsage::kUpload});
  for (size_t i = 0; i < plans.size(); ++i) {
    detail::StrandShadowBuffers buffers;
    buffers.views = shadowViews_;
    buffers.viewCount = kMaxStrandShadows;
    buffers.view = static_cast<uint32_t>(i);
    buffers.words = shadowWords_;
    buffers.wordCount = bytesOfBuffer(shadowWords_) / sizeof(uint32_t);
    if (Result<void> added = detail::addStrandShadow(list, plans[i], buffers, hairs); !added)
      return added.error();
  }
  return static_cast<uint32_t>(plans.size());
}

}  // namespace pelage
