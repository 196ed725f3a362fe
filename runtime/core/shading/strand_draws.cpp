// Strands as ribbons: constants of a view, of an object, and the draws.
#include "shading/strand_draws.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

#include "base/eigen_matrix.h"
#include "base/range.h"
#include "pelage/kernels.h"
#include "shading/light_numbers.h"
#include "shading/lit_kernels.h"

namespace pelage::detail {

static_assert(kMaxStrandLights == shading::kMaxStrandLights);
static_assert(kMaxStrandShadows == shading::kMaxStrandShadows);

namespace {

// Offset of a viewport. Kernels take it as an integer.
bool isOffset(float x) { return x >= 0 && x < 65536 && x == std::floor(x); }

// Expects a vector that is finite and not zero.
Float3 normalized(Float3 v) {
  float length = std::sqrt(v.x * v.x + v.y * v.y + v.z * v.z);
  if (!(length > 0x1p-60f && length < 0x1p60f)) {
    // Its square is no float.
    const float scale = std::max({std::abs(v.x), std::abs(v.y), std::abs(v.z)});
    v = {v.x / scale, v.y / scale, v.z / scale};
    length = std::sqrt(v.x * v.x + v.y * v.y + v.z * v.z);
  }
  return {v.x / length, v.y / length, v.z / length};
}

std::string toText(Float3 v) {
  return "(" + std::to_string(v.x) + ", " + std::to_string(v.y) + ", " + std::to_string(v.z) + ")";
}

// Describes the error in the numbers of a view; empty if there is none.
std::string faultOf(const View& view) {
  for (int row = 0; row < 4; ++row) {
    if (!isFinite(view.worldToClip.rows[row])) {
      return "worldToClip has values that are not finite in row " + std::to_string(row) +
             ": pass the matrix of the camera";
    }
  }
  if (!isFinite(view.eye)) return "eye is " + toText(view.eye) + ", but must be finite";
  if (!isOffset(view.x) || !isOffset(view.y)) {
    return "begins at (" + std::to_string(view.x) + ", " + std::to_string(view.y) +
           "); both are whole numbers from 0 to 65535";
  }
  if (view.samples != 1 && view.samples != 2 && view.samples != 4 && view.samples != 8) {
    return "samples is " + std::to_string(view.samples) +
           ", but must be 1, 2, 4 or 8: those of the target";
  }
  return {};
}

// The same of a light.
std::string faultOf(const Light& light) {
  const std::pair<const char*, Float3> vectors[] = {{"color", light.color},
                                                    {"ambient", light.ambient},
                                                    {"position", light.position},
                                                    {"environment.l00", light.environment.l00},
                                                    {"environment.l1m1", light.environment.l1m1},
                                                    {"environment.l10", light.environment.l10},
                                                    {"environment.l11", light.environment.l11},
                                                    {"environment.l2m2", light.environment.l2m2},
                                                    {"environment.l2m1", light.environment.l2m1},
                                                    {"environment.l20", light.environment.l20},
                                                    {"environment.l21", light.environment.l21},
                                                    {"environment.l22", light.environment.l22}};
  for (const auto& [name, vector] : vectors)
    if (!isFinite(vector)) return name + (" is " + toText(vector)) + ", but must be finite";
  if (light.shadow > HairShadow::kDeep) {
    return "shadow is " + std::to_string(static_cast<uint32_t>(light.shadow)) +
           ", which is no HairShadow; take one of its values";
  }
  if (std::string fault = numberFaultOf(light); !fault.empty()) return fault;
  if (light.hasPosition && !(light.outerConeAngle > 0)) return {};
  if (!isFinite(light.direction) || light.direction == Float3{}) {
    return "direction is " + toText(light.direction) +
           "; give a finite vector towards the light, of any length > 0";
  }
  return {};
}

Float4 withW(Float3 v, float w) { return {v.x, v.y, v.z, w}; }

void addTo(Float4& sum, Float3 v, float weight) {
  sum.x += weight * v.x;
  sum.y += weight * v.y;
  sum.z += weight * v.z;
}

// Each coefficient times the factor of its polynomial.
void addEnvironment(const EnvironmentLight& from, StrandViewConstants& constants) {
  addTo(constants.ambientColor, from.l00, 0.282095f);
  const std::pair<Float3, float> bands[] = {
      {from.l1m1, 0.488603f}, {from.l10, 0.488603f}, {from.l11, 0.488603f}, {from.l2m2, 1.092548f},
      {from.l2m1, 1.092548f}, {from.l20, 0.315392f}, {from.l21, 1.092548f}, {from.l22, 0.546274f}};
  for (size_t i = 0; i < std::size(bands); ++i)
    addTo(constants.environment[i], bands[i].first, bands[i].second);
}

// Root data of draws: colors of an engine's texture, pelage's own texture, or UV alone.
BufferRange rootRange(const DrawnHair& hair) {
  const uint64_t guides = hair.guideCount;
  const uint64_t texels = uint64_t{hair.textureSize.x} * hair.textureSize.y;
  if (hair.colors.isBound()) return hair.colors;
  if (hair.buffers->baseTexture != BufferId::kInvalid)
    return {hair.buffers->baseTexture, (texels + guides) * sizeof(Uint2)};
  if (hair.buffers->strandUvs != BufferId::kInvalid)
    return {hair.buffers->strandUvs, guides * sizeof(Float4)};
  return {};
}

// Draws in a state that kinds of ribbons share.
Result<void> addDraw(const DrawnView& view, const DrawnHair& hair, size_t material, bool smooth,
                     const KernelVariant& pixel, DrawState state,
                     std::optional<LayoutBindings> method, PassList& list) {
  state.depthCompare = view.view.reversedDepth ? DepthCompare::kGreater : DepthCompare::kLess;
  const StrandBindings strands = strandBindings(view, hair, material);
  const EngineLights* lights = lightsOf(view.engineLights, pixel);
  PassBuilder builder(list);
  if (view.transformsFirst) {
    // An instance is a segment, or the gap between two strands.
    const uint64_t records = hair.drawnVertices();
    state.topology = PrimitiveTopology::kTriangleStrip;
    builder
        .draw(litVariant(lights, strandRecordVertexVariant({.smooth = smooth})), pixel, state, 4,
              static_cast<uint32_t>(records - 1))
        .vertices({view.records.buffer, records * kRecordBytes, hair.firstRecord * kRecordBytes})
        .bytes(records * kRecordBytes);
  } else {
    const StrandVertexKey key{.smooth = smooth, .attributes = strandAttributes(view, hair) != 0};
    builder
        .draw(litVariant(lights, strandVertexVariant(key)), pixel, state,
              (hair.vertexCount - 1) * 6, hair.strands.count, hair.buffers->indices)
        .bytes(strands.bytes);
  }
  if (lights != nullptr) builder.offer(lights->resources);
  if (!method) return builder.finish(strands.posTan, strands.render);
  return builder.finish(strands.posTan, strands.render, *method);
}

}  // namespace

Error refuseView(const std::string& what) { return {ErrorCode::kInvalidArgument, "view: " + what}; }

bool isInFrustum(const View& view, const Ball& ball) {
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
  if (const std::string fault = faultOf(view); !fault.empty()) return refuseView(fault);
  StrandViewConstants constants = {};
  std::copy(std::begin(view.worldToClip.rows), std::end(view.worldToClip.rows),
            std::begin(constants.worldToClip));
  const Eigen::Matrix4d inverse = toMatrix(view.worldToClip).inverse();
  for (int row = 0; row < 4; ++row) {
    const Eigen::Vector4f r = inverse.row(row).cast<float>();
    if (!r.allFinite()) return refuseView("worldToClip has no inverse");
    constants.clipToWorld[row] = {r.x(), r.y(), r.z(), r.w()};
  }
  constants.eye = withW(view.eye, 1);
  constants.viewport = {view.x, view.y, static_cast<float>(view.width),
                        static_cast<float>(view.height)};
  constants.reversedDepth = view.reversedDepth ? 1 : 0;
  constants.sampleCount = view.samples;
  constants.seed = view.seed;
  if (lights.size() > kMaxStrandLights) {
    return refuseView("has " + std::to_string(lights.size()) + " lights, but at most " +
                      std::to_string(kMaxStrandLights) + " are taken");
  }
  constants.lightCount = static_cast<uint32_t>(lights.size());
  for (size_t i = 0; i < lights.size(); ++i) {
    const Light& light = lights[i];
    if (const std::string fault = faultOf(light); !fault.empty())
      return refuseView("light " + std::to_string(i) + ": " + fault);
    constants.lightDirections[i] =
        light.hasPosition ? withW(light.position, 1) : withW(normalized(light.direction), 0);
    constants.lightColors[i] = withW(light.color, 0);
    constants.lightShadows[i].x = ~0u;
    if (light.outerConeAngle > 0)
      constants.lightCones[i] = coneOf(light, normalized(light.direction));
    addTo(constants.ambientColor, light.ambient, 1);
    addEnvironment(light.environment, constants);
  }
  return constants;
}

std::string faultOf(const StrandMaterial& m) {
  const Range ranges[] = {
      {"rootColor.x", m.rootColor.x, 0, 1},
      {"rootColor.y", m.rootColor.y, 0, 1},
      {"rootColor.z", m.rootColor.z, 0, 1},
      {"tipColor.x", m.tipColor.x, 0, 1},
      {"tipColor.y", m.tipColor.y, 0, 1},
      {"tipColor.z", m.tipColor.z, 0, 1},
      {"tipShare", m.tipShare, 0, 1},
      {"colorVariation", m.colorVariation, 0, 1},
      {"opacity", m.opacity, 0, 1},
      {"fiberRadius", m.fiberRadius, 0, Range::kInfinity, true},
      {"tipRadiusRatio", m.tipRadiusRatio, 0, 1},
      {"ambientStrength", m.ambientStrength, 0, 64},
      {"diffuseStrength", m.diffuseStrength, 0, 64},
      {"primaryStrength", m.primaryStrength, 0, 64},
      {"primaryExponent", m.primaryExponent, 1, 10000},
      {"primaryShift", m.primaryShift},
      {"secondaryStrength", m.secondaryStrength, 0, 64},
      {"secondaryExponent", m.secondaryExponent, 1, 10000},
      {"secondaryShift", m.secondaryShift},
      {"secondaryTint", m.secondaryTint, 0, 1},
      {"longitudinalRoughness", m.longitudinalRoughness, 0, 1},
      {"azimuthalRoughness", m.azimuthalRoughness, 0, 1},
      {"cuticleTilt", m.cuticleTilt},
      {"refractiveIndex", m.refractiveIndex, 1, Range::kInfinity, true},
      {"scatteredShare", m.scatteredShare, 0, 1},
      {"multipleScattering", m.multipleScattering, 0, 1},
  };
  for (const Range& range : ranges)
    if (const std::string fault = faultOf(range); !fault.empty()) return "material." + fault;
  if (m.model <= ShadingModel::kFiber) return {};
  return "material.model is " + std::to_string(static_cast<uint32_t>(m.model)) +
         ", which is no ShadingModel; take one of its values";
}

ShadingParts shadingOf(const StrandMaterial& m) {
  return {static_cast<uint32_t>(m.model),
          {m.diffuseStrength, m.ambientStrength, m.scatteredShare, m.multipleScattering},
          {m.primaryStrength, m.primaryExponent, m.primaryShift, 0},
          {m.secondaryStrength, m.secondaryExponent, m.secondaryShift, m.secondaryTint},
          {m.longitudinalRoughness, m.azimuthalRoughness, m.cuticleTilt, m.refractiveIndex}};
}

void setMaterials(std::span<const StrandMaterial* const> materials, std::span<Uint4> models,
                  std::span<Float4> bodies, std::span<Float4> primaries,
                  std::span<Float4> secondaries, std::span<Float4> fibers) {
  for (size_t i = 0; i < materials.size(); ++i) {
    const ShadingParts shading = shadingOf(*materials[i]);
    uint32_t Uint4::*const parts[4] = {&Uint4::x, &Uint4::y, &Uint4::z, &Uint4::w};
    models[i / 4].*parts[i % 4] = shading.model;
    bodies[i] = shading.body;
    primaries[i] = shading.primary;
    secondaries[i] = shading.secondary;
    fibers[i] = shading.fiber;
  }
}

uint32_t strandAttributes(const DrawnView& view, const DrawnHair& hair) {
  const HairBuffers& buffers = *hair.buffers;
  const auto bit = [](BufferId buffer, uint32_t attribute) {
    return buffer != BufferId::kInvalid ? attribute : 0;
  };
  const bool colors = hair.colors.isBound();
  return bit(buffers.strandThickness, render::kHasThickness) |
         bit(buffers.vertexColors, render::kHasVertexColors) |
         (view.readsUv ? bit(buffers.strandUvs, render::kHasStrandUvs) : 0) |
         (colors ? render::kHasStrandColors : bit(buffers.baseTexture, render::kHasBaseTexture));
}

StrandBindings strandBindings(const DrawnView& view, const DrawnHair& hair, size_t material) {
  const StrandMaterial& m = *hair.material;
  const DrawnStrands& strands = hair.strands;

  RenderConstants constants = {};
  const ShadingParts shading = shadingOf(m);
  constants.shadingModel = shading.model;
  constants.shadingBody = shading.body;
  constants.shadingPrimary = shading.primary;
  constants.shadingSecondary = shading.secondary;
  constants.shadingFiber = shading.fiber;
  constants.rootColor = withW(m.rootColor, m.opacity);
  constants.tipColor = withW(m.tipColor, m.tipShare);
  constants.strandVariation = m.colorVariation;
  constants.materialIndex = static_cast<uint32_t>(material);
  constants.renderVertexCount = hair.vertexCount;
  constants.renderStrandCount = hair.strandCount();
  constants.renderGuideCount = hair.guideCount;
  constants.renderTipSeparation = hair.tipSeparation;
  constants.fiberRadius = m.fiberRadius;
  constants.tipRadiusRatio = m.tipRadiusRatio;
  constants.drawnStrands = strands.shown;
  constants.fadingStrands = strands.fading;
  constants.strandWidening = strands.widening;
  constants.textureSize = hair.textureSize;
  const HairBuffers& buffers = *hair.buffers;
  constants.strandAttributes = strandAttributes(view, hair);
  constants.evaluatesFollows = hair.evaluatedStrands() > 0 ? 1 : 0;

  const uint64_t guides = hair.guideCount;
  const uint64_t strandBytes = hair.vertexCount * sizeof(Float4);
  const uint64_t bytes = (hair.storesFollows ? hair.strandCount() : guides) * strandBytes;
  const uint64_t evaluated = hair.evaluatedStrands();
  const BufferRange positions = {hair.positions, bytes};
  const BufferRange& roots = hair.roots;
  // Positions stand in for attributes that the object lacks, and roots for follow strands: they are
  // bound beside the others, but not read.
  const auto orPositions = [&](const BufferRange& range) {
    return range.isBound() ? range : positions;
  };
  const BufferRange follows = {buffers.followHairRecords,
                               uint64_t{hair.followCount} * sizeof(FollowHairRecord)};
  return {.posTan = {.renderPositions = positions, .renderTangents = {hair.tangents, bytes}},
          .render = {.strandViewConstants = view.constants,
                     .renderConstants = constants,
                     .strandThickness = orPositions(
                         {buffers.strandThickness, uint64_t{hair.strandCount()} * sizeof(float)}),
                     .renderFollowHairRecords = hair.followCount > 0 ? follows : roots,
                     .renderRoots = roots,
                     .vertexColors = orPositions(
                         {buffers.vertexColors, guides * hair.vertexCount * sizeof(Uint2)}),
                     .baseTexture = orPositions(rootRange(hair)),
                     .shadowWords = {view.shadowWords, view.shadowBytes}},
          .bytes = 2 * (strands.count - evaluated) * strandBytes +
                   evaluated * sizeof(FollowHairRecord) +
                   (evaluated > 0 ? guides * sizeof(RootTransform) : 0)};
}

RecordThreads recordThreads(uint64_t records) {
  constexpr uint32_t kRow = strand_record::kRecordDispatchRow;
  return {static_cast<uint32_t>(std::min<uint64_t>(records, kRow)),
          static_cast<uint32_t>((records + kRow - 1) / kRow)};
}

Result<void> addTransform(const DrawnView& view, const DrawnHair& hair, size_t material,
                          const BufferRange& records, uint64_t first, PassList& list) {
  StrandRecordsConstants place = {};
  place.recordCapacity = static_cast<uint32_t>(records.size / kRecordBytes);
  place.firstRecord = static_cast<uint32_t>(first);
  place.objectRecords = static_cast<uint32_t>(hair.drawnVertices());
  const TransformStrandsKey key = completeKey(TransformStrandsKey{
      .follows = hair.evaluatedStrands() > 0, .attributes = strandAttributes(view, hair) != 0});
  const RecordThreads threads = recordThreads(hair.drawnVertices());
  const StrandBindings bound = strandBindings(view, hair, material);
  PassBuilder builder(list);
  builder.dispatch(*transformStrandsVariant(key), threads.x, threads.y).bytes(bound.bytes);
  return builder.finish(
      bound.posTan, bound.render,
      StrandRecordsBindings{.strandRecordsConstants = place, .strandRecords = records});
}

uint64_t placeRecords(DrawnView& view) {
  // Each object binds its own part, and devices want offsets that are multiples of up to 256 bytes.
  constexpr uint64_t kAlignment = 16;
  static_assert(kAlignment * kRecordBytes % 256 == 0);
  uint64_t next = 0;
  for (DrawnHair& hair : view.hairs) {
    hair.firstRecord = next;
    next += (hair.drawnVertices() + kAlignment - 1) / kAlignment * kAlignment;
  }
  return next * kRecordBytes;
}

Result<void> addTransforms(const DrawnView& view, PassList& list) {
  for (size_t i = 0; i < view.hairs.size(); ++i) {
    const DrawnHair& hair = view.hairs[i];
    const BufferRange own = {view.records.buffer, hair.drawnVertices() * kRecordBytes,
                             hair.firstRecord * kRecordBytes};
    if (Result<void> added = addTransform(view, hair, i, own, 0, list); !added) return added;
  }
  return {};
}

Result<void> addStrandDraw(const DrawnView& view, const DrawnHair& hair, size_t material,
                           const KernelVariant& pixel, const LayoutBindings& method,
                           PassList& list) {
  DrawState into;
  into.depthWrite = false;
  into.colorWrite = false;
  return addDraw(view, hair, material, true, pixel, into, method, list);
}

Result<void> addStrandDraws(const DrawnView& view, const KernelVariant& pixel,
                            const LayoutBindings& method, PassList& list) {
  for (size_t i = 0; i < view.hairs.size(); ++i) {
    Result<void> added = addStrandDraw(view, view.hairs[i], i, pixel, method, list);
    if (!added) return added;
  }
  return {};
}

Result<void> addOpaqueDraws(const DrawnView& view, bool stochastic, PassList& list) {
  const KernelVariant& pixel =
      litVariant(view.engineLights, strandPixelVariant({.stochastic = stochastic}));
  for (size_t i = 0; i < view.hairs.size(); ++i) {
    if (Result<void> added =
            addDraw(view, view.hairs[i], i, false, pixel, DrawState{}, std::nullopt, list);
        !added)
      return added;
  }
  return {};
}

}  // namespace pelage::detail
