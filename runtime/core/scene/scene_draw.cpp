// Drawing of hair: which hair a view has, its shadows, and its kind of transparency.
#include "base/eigen_matrix.h"
#include "pelage/list_check.h"
#include "scene/scene_impl.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

namespace pelage::detail {

namespace {

// Of the map around all hair, without the ball.
StrandShadowDef shadowDefOf(const Light& light) {
  StrandShadowDef def;
  def.toLight = light.direction;
  def.hasPosition = light.hasPosition;
  def.position = light.position;
  def.coneAngle = light.outerConeAngle;
  def.size = light.shadowSize;
  def.layers = light.shadow == HairShadow::kDeep ? light.shadowLayers : 0;
  def.biasTexels = light.shadowBias;
  def.layerRange = light.shadowLayerRange;
  def.volume = light.shadowVolume;
  return def;
}

OpaqueShadowPlan opaquePlanOf(const Light& light) {
  return {.depth = light.opaque.depth, .words = light.opaque.width * light.opaque.height};
}

PixelArea areaOf(const View& view) {
  return {static_cast<uint32_t>(view.x), static_cast<uint32_t>(view.y), view.width, view.height};
}

}  // namespace

void setArea(std::span<PassList> lists, const View& view) {
  for (PassList& list : lists) {
    if (!list.passes.empty() && isDraw(list.passes.back().kind)) list.area = areaOf(view);
  }
}

BufferId SceneImpl::shadowWords() const { return draws_.shadows.words(); }

BufferId SceneImpl::shadowViews() const { return draws_.shadows.views(); }

BufferId SceneImpl::transparencyCounters() const { return draws_.oit.counters(); }

TransparencyTiles SceneImpl::transparencyTiles() const { return draws_.oit.tiles(); }

DrawBytes SceneImpl::drawBytes() const {
  return {draws_.oit.bytes(resources_), draws_.shadows.bytes(resources_)};
}

void SceneImpl::setTier(Tier tier) { draws_.tier = tier; }

void SceneImpl::setShadowMemory(uint64_t maxBytes) { draws_.shadows.maxBytes = maxBytes; }

// Numbers that the object's draws and shadows would take.
Result<void> SceneImpl::checkLook(const HairObject& object) {
  std::string fault = faultOf(object.material);
  if (fault.empty()) fault = faultOf(object.strandTexture, object.buffers());
  if (fault.empty()) return {};
  return Error{ErrorCode::kInvalidArgument, "hair '" + object.name() + "': " + fault};
}

Result<DrawnView> SceneImpl::beginDraw(const View& view, std::span<const Light> lights,
                                       const PassList* list) const {
  if (view.width == 0 || view.height == 0)
    return refuseView("is " + std::to_string(view.width) + " x " + std::to_string(view.height) +
                      " pixels; View::width and height are those of the viewport, and above 0");
  Result<StrandViewConstants> constants = viewConstants(view, lights);
  if (!constants) return constants.error();
  if (list != nullptr) {
    if (Result<void> fits = checkArea(*list, areaOf(view)); !fits) return fits.error();
  }
  DrawnView frame = {.view = view, .lights = lights, .constants = *constants};
  frame.transformsFirst = limitsOf(draws_.tier).storageBuffers.vertex == 0;
  for (const auto& held : objects_) {
    if (held == nullptr || !held->visible) continue;
    if (Result<void> checked = checkLook(*held); !checked) return checked.error();
    DrawnHair hair = drawnHairOf(*held, *held->internals_, draws_.frame);
    hair.before = held->internals_->motion.before(draws_.frame);
    if (hair.strands.count > 0 && isInFrustum(view, hair.ball)) frame.hairs.push_back(hair);
  }
  return frame;
}

float SceneImpl::shareForView(HairId id, const View& view, float pixels) const {
  constexpr double kLeast = 1.0 / 64;
  const HairObject& object = hair(id);
  const Ball ball = ballOfStrands(*object.internals_);
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

// One list without sorting.
Result<void> SceneImpl::draw(const View& view, const Light& light, PassList& list) {
  settleFrames(false);
  Result<DrawnView> frame = beginDraw(view, {&light, 1}, &list);
  if (!frame) return frame.error();
  Result<ShadowCast> cast = checkShadows(frame->lights, true);
  if (!cast) return cast.error();
  if (Result<void> added = addShadows(*cast, *frame, list); !added) return added;
  const TransparencySettings settings = {.method = Transparency::kStochastic};
  const Result<OitPlan> plan = OitViews::check(*frame, settings, room());
  if (!plan) return plan.error();
  std::vector<PassList> lists;
  lists.push_back(std::move(list));
  Result<void> added = draws_.colors.record(*frame, room(), draws_.frame, lists[0]);
  if (added) added = draws_.oit.record(*frame, settings, *plan, room(), draws_.frame, lists);
  list = std::move(lists.front());
  if (added) finishShift();
  setArea({&list, 1}, view);
  return added;
}

Result<void> SceneImpl::draw(const View& view, std::span<const Light> lights,
                             const TransparencySettings& settings, std::vector<PassList>& lists) {
  settleFrames(false);
  if (lists.empty()) lists.resize(1);
  for (size_t i = 1; i < lists.size(); ++i) lists[i].clear();
  const RoomBuffers room = this->room();
  Result<DrawnView> frame = beginDraw(view, lights, lists.data());
  if (!frame) return frame.error();
  const Result<OitPlan> plan = OitViews::check(*frame, settings, room);
  if (!plan) return plan.error();
  if (frame->hairs.empty()) return {};
  Result<ShadowCast> cast = checkShadows(lights, true);
  if (!cast) return cast.error();
  if (Result<void> added = addShadows(*cast, *frame, lists[0]); !added) return added;
  Result<void> added = draws_.colors.record(*frame, room, draws_.frame, lists[0]);
  if (added) added = draws_.oit.record(*frame, settings, *plan, room, draws_.frame, lists);
  draws_.colors.share(*frame, lists, draws_.frame);
  draws_.shadows.share(lists, draws_.frame);
  if (added) finishShift();
  setArea(lists, view);
  return added;
}

// Beside any kind of transparency: it takes the strands alone.
Result<void> SceneImpl::drawDepth(const View& view, const HairDepthSettings& settings,
                                  PassList& list) {
  settleFrames(false);
  if (Result<void> valid = validate(settings); !valid) return valid;
  Result<DrawnView> frame = beginDraw(view, {});
  if (!frame) return frame.error();
  if (Result<void> fits = StrandDepths::check(*frame, settings); !fits) return fits;
  if (frame->hairs.empty()) return {};
  if (Result<void> moved = addPendingShifts(list); !moved) return moved;
  Result<void> added = draws_.colors.record(*frame, room(), draws_.frame, list);
  if (added) added = draws_.depths.record(*frame, settings, room(), draws_.frame, list);
  if (added) finishShift();
  return added;
}

Result<uint32_t> SceneImpl::castShadows(std::span<const Light> lights, PassList& list) {
  settleFrames(false);
  // Maps do not depend on who looks.
  const View view;
  Result<StrandViewConstants> constants = viewConstants(view, lights);
  if (!constants) return constants.error();
  DrawnView frame = {.view = view, .lights = lights, .constants = *constants};
  Result<ShadowCast> cast = checkShadows(lights, false);
  if (!cast) return cast.error();
  if (Result<void> added = addShadows(*cast, frame, list); !added) return added.error();
  finishShift();
  return static_cast<uint32_t>(cast->plan.maps.size());
}

// Depth maps of opaque geometry that cast shadows on hair.
Result<void> SceneImpl::checkOpaques(std::span<const Light> lights, ShadowCast& cast) const {
  for (size_t i = 0; i < lights.size(); ++i) {
    const OpaqueShadow& map = lights[i].opaque;
    if (map.depth == BufferId::kInvalid) continue;
    if (cast.opaqueLights.size() == kMaxStrandShadows)
      return refuseView("more than " + std::to_string(kMaxStrandShadows) +
                        " lights have a shadow of opaque geometry");
    const uint64_t bytes = uint64_t{opaquePlanOf(lights[i]).words} * sizeof(float);
    const BufferDesc* desc = resources_.find(map.depth);
    const uint64_t given = desc != nullptr ? desc->size : 0;
    if (given < bytes)
      return refuseView("light " + std::to_string(i) + ": opaque.depth has " +
                        std::to_string(given) + " bytes, but " + std::to_string(map.width) + " x " +
                        std::to_string(map.height) + " floats take " + std::to_string(bytes));
    cast.opaqueLights.push_back(i);
  }
  return {};
}

// Maps of the lights that cast shadows, from all hair in the scene that is visible to anybody.
// \param draws hair is drawn, and opaque geometry casts shadows on it.
Result<ShadowCast> SceneImpl::checkShadows(std::span<const Light> lights, bool draws) {
  ShadowCast cast;
  Ball all;
  for (const auto& held : objects_) {
    if (held == nullptr || !held->visible || drawnStrandsOf(*held).count == 0) continue;
    if (Result<void> checked = checkLook(*held); !checked) return checked.error();
    const Ball ball = ballOfDrawn(*held, *held->internals_, draws_.frame);
    // One that is anywhere has no map that it fits into.
    if (!std::isfinite(ball.radius)) continue;
    all = cast.hairs.empty() ? ball : ballAround(all, ball);
    cast.hairs.push_back(shadowedHairOf(*held, *held->internals_, draws_.frame));
  }
  std::vector<StrandShadowDef> defs;
  for (size_t i = 0; i < lights.size() && !cast.hairs.empty(); ++i) {
    const Light& light = lights[i];
    if (light.shadow == HairShadow::kNone) continue;
    if (defs.size() == kMaxStrandShadows)
      return refuseView("more than " + std::to_string(kMaxStrandShadows) + " lights have a shadow");
    StrandShadowDef def = shadowDefOf(light);
    def.center = all.center;
    def.shifted = shifted();
    def.radius = steadyRadius(all.radius);
    defs.push_back(def);
    cast.lights.push_back(i);
  }
  std::vector<OpaqueShadowPlan> opaques;
  if (draws && !cast.hairs.empty()) {
    if (Result<void> checked = checkOpaques(lights, cast); !checked) return checked.error();
    for (const size_t light : cast.opaqueLights) opaques.push_back(opaquePlanOf(lights[light]));
  }
  Result<ShadowPlan> plan = draws_.shadows.check(defs, opaques, cast.hairs, room(), draws_.frame);
  if (!plan) return plan.error();
  cast.plan = std::move(*plan);
  return cast;
}

// Positions where they are after a shift of the world; then the maps.
Result<void> SceneImpl::addShadows(ShadowCast& cast, DrawnView& frame, PassList& list) {
  if (Result<void> moved = addPendingShifts(list); !moved) return moved;
  const RoomBuffers room = this->room();
  if (Result<void> added = draws_.shadows.record(cast.plan, cast.hairs, room, draws_.frame, list);
      !added)
    return added;
  for (size_t i = 0; i < cast.lights.size(); ++i) {
    const auto index = static_cast<uint32_t>(i);
    setShadow(frame.constants, index, cast.plan.maps[i].view);
    frame.constants.lightShadows[cast.lights[i]].x = index;
  }
  for (size_t i = 0; i < cast.opaqueLights.size(); ++i) {
    const auto index = static_cast<uint32_t>(i);
    setOpaqueShadow(frame.constants, index, frame.lights[cast.opaqueLights[i]].opaque,
                    cast.plan.opaques[i].firstWord);
    frame.constants.lightShadows[cast.opaqueLights[i]].y = 1 + index;
  }
  frame.shadowWords = draws_.shadows.words();
  frame.shadowBytes = room.bytesOf(frame.shadowWords);
  return {};
}

}  // namespace pelage::detail
