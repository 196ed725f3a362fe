#include <algorithm>
#include <bit>
#include <cmath>
#include <iterator>
#include <limits>

#include "base/vector3.h"
#include "scene/view_drawing.h"

namespace pelage {

DrawnStrands drawnStrandsOf(const HairObject& object) {
  const uint32_t all = std::min(object.drawnStrands, object.strandCount());
  // NaN counts as 1.
  const double share =
      object.drawnShare >= 0 ? std::min(static_cast<double>(object.drawnShare), 1.0) : 1.0;
  DrawnStrands drawn;
  const double shown = share * all;
  // The fading strands vanish where all are drawn, so that nothing jumps there.
  const double fading = std::min(shown / 8, all - shown);
  drawn.count = static_cast<uint32_t>(std::ceil(shown));
  drawn.shown = static_cast<float>(shown);
  drawn.fading = static_cast<float>(fading);
  const double widths = shown - fading / 2;
  drawn.widening = widths > 0 ? static_cast<float>(all / widths) : 1;
  return drawn;
}

namespace detail {

namespace {

// The roots that draws compute follow hairs from.
BufferRange drawnRoots(const HairObject& object, const StrandsBetween& between) {
  BufferRange roots = object.rootTransforms();
  if (between.roots != BufferId::kInvalid) roots = {between.roots, roots.size};
  return roots;
}

}  // namespace

DrawnHair drawnHairOf(const HairObject& object, const HairInternals& hair, uint64_t frame) {
  DrawnHair drawn;
  drawn.material = &object.material;
  drawn.buffers = &object.buffers();
  drawn.strands = drawnStrandsOf(object);
  drawn.vertexCount = object.verticesPerStrand();
  drawn.guideCount = object.guideCount();
  drawn.followCount = object.strandCount() - object.guideCount();
  drawn.storesFollows = hair.groom.storesFollowHairs;
  drawn.tipSeparation = object.settings.tipSeparation;
  drawn.textureSize = {hair.groom.textureWidth, hair.groom.textureHeight};
  if (object.strandTexture.texture != TextureId::kInvalid) drawn.texture = &object.strandTexture;
  const StrandsBetween between = hair.get<StrandInterpolation>().drawn(frame);
  const bool placed = between.positions != BufferId::kInvalid;
  drawn.positions = placed ? between.positions : object.buffers().positions;
  drawn.tangents = placed ? between.tangents : object.buffers().tangents;
  drawn.roots = drawnRoots(object, between);
  drawn.ball = ballOfDrawn(object, hair, frame);
  return drawn;
}

Ball ballOfDrawn(const HairObject& object, const HairInternals& hair, uint64_t frame) {
  const Ball now = ballOfHair(hair, object.settings.tipSeparation);
  const bool placed = hair.get<StrandInterpolation>().drawn(frame).positions != BufferId::kInvalid;
  return placed ? ballAround(now, hair.get<StrandInterpolation>().ballBefore()) : now;
}

Ball ballOfHair(const HairInternals& hair, float tipSeparation) {
  Ball ball = ballOfStrands(hair);
  // Between root and tip the offset goes linearly from one to the other.
  const float tip =
      std::isfinite(tipSeparation) ? std::abs(tipSeparation) * hair.groom.followTipRange : 0;
  ball.radius += std::max(hair.groom.followRange, tip);
  return ball;
}

ShadowedHair shadowedHairOf(const HairObject& object, const HairInternals& hair, uint64_t frame) {
  const DrawnStrands drawn = drawnStrandsOf(object);
  const HairBuffers& buffers = object.buffers();
  const StrandMaterial& m = object.material;
  ShadowedHair shadowed;
  shadowed.vertexCount = object.verticesPerStrand();
  shadowed.strandCount = drawn.count;
  shadowed.guideCount = object.guideCount();
  shadowed.storesFollows = hair.groom.storesFollowHairs;
  shadowed.tipSeparation = object.settings.tipSeparation;
  shadowed.fiberRadius = m.fiberRadius * drawn.widening;
  shadowed.tipRadiusRatio = m.tipRadiusRatio;
  shadowed.opacity = m.opacity;
  // Fading strands have half their width on average.
  shadowed.fadingCount = static_cast<uint32_t>(std::lround(drawn.fading));
  shadowed.fade = 0.5f;
  shadowed.strandLength = hair.rest.meanStrand;
  shadowed.volume = hair.rest.volume;
  shadowed.meanThickness = hair.groom.meanThickness;
  shadowed.maxThickness = hair.groom.maxThickness;
  const StrandsBetween between = hair.get<StrandInterpolation>().drawn(frame);
  shadowed.positions =
      between.positions != BufferId::kInvalid ? between.positions : buffers.positions;
  shadowed.thickness = buffers.strandThickness;
  shadowed.followHairRecords = buffers.followHairRecords;
  shadowed.rootTransforms = drawnRoots(object, between);
  return shadowed;
}

Ball ballAround(const Ball& a, const Ball& b) {
  const Float3 displacement = {b.center.x - a.center.x, b.center.y - a.center.y,
                               b.center.z - a.center.z};
  const float distance =
      std::sqrt(displacement.x * displacement.x + displacement.y * displacement.y +
                displacement.z * displacement.z);
  if (distance + b.radius <= a.radius) return a;
  if (distance + a.radius <= b.radius) return b;
  Ball all;
  all.radius = 0.5f * (a.radius + b.radius + distance);
  const float share = distance > 0 ? (all.radius - a.radius) / distance : 0;
  all.center = {a.center.x + share * displacement.x, a.center.y + share * displacement.y,
                a.center.z + share * displacement.z};
  return all;
}

float steadyRadius(float radius) {
  constexpr float kStep = 1.25f;
  if (!(radius > 0)) return 1e-3f;
  return std::pow(kStep, std::ceil(std::log(radius) / std::log(kStep)));
}

void setShadow(StrandViewConstants& constants, uint32_t index, const StrandShadowView& map) {
  constants.shadowRows[4 * index] = map.mapX;
  constants.shadowRows[4 * index + 1] = map.mapY;
  constants.shadowRows[4 * index + 2] = map.mapZ;
  constants.shadowRows[4 * index + 3] = map.mapW;
  constants.shadowSizes[index] = {map.width, map.height, map.firstWord, map.layerCount};
  constants.shadowDepths[index] = {map.layerRange, map.bias, map.extinction, map.texelSize};
  constants.shadowScales[index] = {map.tauScale, map.tauQuantum, map.maxRadius, map.nearW};
  constants.shadowFaces[index] = {map.faceCount, std::bit_cast<uint32_t>(map.across), 0, 0};
}

void setOpaqueShadow(StrandViewConstants& constants, uint32_t index, const OpaqueShadow& map,
                     uint32_t firstWord) {
  std::copy(std::begin(map.worldToClip.rows), std::end(map.worldToClip.rows),
            constants.opaqueRows + size_t{4} * index);
  constants.opaqueSizes[index] = {map.width, map.height, firstWord, map.reversedDepth ? 1u : 0u};
  constants.opaqueBiases[index].x = map.bias;
}

}  // namespace detail
}  // namespace pelage
