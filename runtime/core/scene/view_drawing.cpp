// Drawing of hair: which hair a view has, its shadows, and its kind of transparency.
#include "base/eigen_matrix.h"
#include "base/range.h"
#include "pelage/list_check.h"
#include "scene/scene_parts.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

namespace pelage::detail {

namespace {

// Definition of the map around all hair, without the ball.
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

// Validates numbers of strands, material and texture.
Result<void> checkLook(const HairObject& object) {
  std::string fault = detail::faultOf(Range{"drawnShare", object.drawnShare, 0, 1});
  if (object.drawnStrands > object.strandCount())
    fault = "drawnStrands is " + std::to_string(object.drawnStrands) + ", but must be in 0.." +
            std::to_string(object.strandCount());
  if (fault.empty()) fault = detail::faultOf(object.material);
  if (fault.empty()) fault = detail::faultOf(object.strandTexture, object.buffers());
  if (fault.empty()) return {};
  return Error{ErrorCode::kInvalidArgument, "hair '" + object.name() + "': " + fault};
}

// Depth maps of opaque geometry that cast shadows on hair.
Result<void> checkOpaques(std::span<const Light> lights, const ResourceTable& resources,
                          ShadowCast& cast) {
  for (size_t i = 0; i < lights.size(); ++i) {
    const OpaqueShadow& map = lights[i].opaque;
    if (map.depth == BufferId::kInvalid) continue;
    if (cast.opaqueLights.size() == kMaxStrandShadows)
      return refuseView("more than " + std::to_string(kMaxStrandShadows) +
                        " lights have a shadow of opaque geometry");
    const uint64_t bytes = uint64_t{opaquePlanOf(lights[i]).words} * sizeof(float);
    const BufferDesc* desc = resources.find(map.depth);
    const uint64_t given = desc != nullptr ? desc->size : 0;
    if (given < bytes)
      return refuseView("light " + std::to_string(i) + ": opaque.depth has " +
                        std::to_string(given) + " bytes, but " + std::to_string(map.width) + " x " +
                        std::to_string(map.height) + " floats take " + std::to_string(bytes));
    cast.opaqueLights.push_back(i);
  }
  return {};
}

}  // namespace

void setArea(std::span<PassList> lists, const View& view) {
  for (PassList& list : lists) {
    if (list.passes.empty() || !isDraw(list.passes.back().kind)) continue;
    list.area = areaOf(view);
    list.samples = view.samples;
  }
}

Result<DrawnView> ViewDrawing::begin(const View& view, std::span<const Light> lights,
                                     const PassList* list) {
  if (view.width == 0 || view.height == 0)
    return refuseView("is " + std::to_string(view.width) + " x " + std::to_string(view.height) +
                      " pixels; View::width and height are those of the viewport, and above 0");
  Result<StrandViewConstants> constants = viewConstants(view, lights);
  if (!constants) return constants.error();
  if (list != nullptr) {
    if (Result<void> fits = checkArea(*list, areaOf(view)); !fits) return fits.error();
  }
  DrawnView frame = {.view = view, .lights = lights, .constants = *constants};
  drawn_.clear();
  frame.transformsFirst = limitsOf(tier).storageBuffers.vertex == 0;
  for (const HairObject& object : store_.hairs()) {
    if (!object.visible) continue;
    if (Result<void> checked = checkLook(object); !checked) return checked.error();
    DrawnHair hair = drawnHairOf(object, HairStore::of(object), store_.frame);
    hair.before = HairStore::of(object).get<StrandMotion>().before(store_.frame);
    if (hair.strands.count > 0 && isInFrustum(view, hair.ball)) drawn_.push_back(hair);
  }
  frame.hairs = drawn_;
  return frame;
}

// One list without sorting.
Result<void> ViewDrawing::draw(const View& view, const Light& light, PassList& list) {
  journal_.settle(false);
  Result<DrawnView> frame = begin(view, {&light, 1}, &list);
  if (!frame) return frame.error();
  if (Result<void> cast = checkShadows(frame->lights, true); !cast) return cast;
  if (Result<void> added = addShadows(*frame, list); !added) return added;
  const TransparencySettings settings = {.method = Transparency::kStochastic};
  if (Result<void> planned = OitViews::check(*frame, settings, store_.factory(), plan_); !planned)
    return planned;
  std::vector<PassList> lists;
  lists.push_back(std::move(list));
  Result<void> added = colors.record(*frame, store_.factory(), store_.frame, lists[0]);
  if (added) added = oit.record(*frame, settings, plan_, store_.factory(), store_.frame, lists);
  list = std::move(lists.front());
  if (added) simulation_.finishMoves();
  setArea({&list, 1}, view);
  return added;
}

Result<void> ViewDrawing::draw(const View& view, std::span<const Light> lights,
                               const TransparencySettings& settings, std::vector<PassList>& lists) {
  journal_.settle(false);
  if (lists.empty()) lists.resize(1);
  for (size_t i = 1; i < lists.size(); ++i) lists[i].clear();
  const BufferFactory factory = store_.factory();
  Result<DrawnView> frame = begin(view, lights, lists.data());
  if (!frame) return frame.error();
  if (Result<void> planned = OitViews::check(*frame, settings, factory, plan_); !planned)
    return planned;
  if (frame->hairs.empty()) return {};
  if (Result<void> cast = checkShadows(lights, true); !cast) return cast;
  if (Result<void> added = addShadows(*frame, lists[0]); !added) return added;
  Result<void> added = colors.record(*frame, factory, store_.frame, lists[0]);
  if (added) added = oit.record(*frame, settings, plan_, factory, store_.frame, lists);
  if (!added && settings.engineLights != nullptr)
    added = Error{added.error().code, added.error().message +
                                          "; what engineLight() reads goes into "
                                          "EngineLights::resources"};
  colors.share(*frame, lists, store_.frame);
  shadows.share(lists, store_.frame);
  if (added) simulation_.finishMoves();
  setArea(lists, view);
  return added;
}

// Beside any kind of transparency: it takes the strands alone.
Result<void> ViewDrawing::drawDepth(const View& view, const HairDepthSettings& settings,
                                    PassList& list) {
  journal_.settle(false);
  if (Result<void> valid = validate(settings); !valid) return valid;
  Result<DrawnView> frame = begin(view, {});
  if (!frame) return frame.error();
  if (Result<void> fits = StrandDepths::check(*frame, settings); !fits) return fits;
  if (frame->hairs.empty()) return {};
  if (Result<void> moved = simulation_.movePending(list); !moved) return moved;
  Result<void> added = colors.record(*frame, store_.factory(), store_.frame, list);
  if (added) added = depths.record(*frame, settings, store_.factory(), store_.frame, list);
  if (added) simulation_.finishMoves();
  return added;
}

Result<uint32_t> ViewDrawing::castShadows(std::span<const Light> lights, PassList& list) {
  journal_.settle(false);
  // Shadow maps are independent of the view.
  const View view;
  Result<StrandViewConstants> constants = viewConstants(view, lights);
  if (!constants) return constants.error();
  DrawnView frame = {.view = view, .lights = lights, .constants = *constants};
  if (Result<void> cast = checkShadows(lights, false); !cast) return cast.error();
  if (Result<void> added = addShadows(frame, list); !added) return added.error();
  simulation_.finishMoves();
  return static_cast<uint32_t>(cast_.plan.maps.size());
}

// All hair that casts shadows.
// \param all  the ball around it
Result<void> ViewDrawing::castHairs(Ball& all) {
  std::vector<ShadowedHair>& hairs = cast_.hairs;
  hairs.clear();
  for (const HairObject& object : store_.hairs()) {
    if (!object.visible) continue;
    if (Result<void> checked = checkLook(object); !checked) return checked;
    if (drawnStrandsOf(object).count == 0) continue;
    const HairInternals& hair = HairStore::of(object);
    const Ball ball = ballOfDrawn(object, hair, store_.frame);
    // Unbounded hair casts no shadow.
    if (!std::isfinite(ball.radius)) continue;
    all = hairs.empty() ? ball : ballAround(all, ball);
    hairs.push_back(shadowedHairOf(object, hair, store_.frame));
  }
  return {};
}

// Maps of the lights that cast shadows, from all hair in the scene that is visible to anybody.
// \param draws hair is drawn, and opaque geometry casts shadows on it.
Result<void> ViewDrawing::checkShadows(std::span<const Light> lights, bool draws) {
  ShadowCast& cast = cast_;
  cast.lights.clear();
  cast.opaqueLights.clear();
  cast.defs.clear();
  cast.opaques.clear();
  Ball all;
  if (Result<void> found = castHairs(all); !found) return found;
  for (size_t i = 0; i < lights.size() && !cast.hairs.empty(); ++i) {
    const Light& light = lights[i];
    if (light.shadow == HairShadow::kNone) continue;
    if (cast.defs.size() == kMaxStrandShadows)
      return refuseView("more than " + std::to_string(kMaxStrandShadows) + " lights have a shadow");
    StrandShadowDef def = shadowDefOf(light);
    def.center = all.center;
    def.shifted = store_.shifted;
    def.radius = steadyRadius(all.radius);
    cast.defs.push_back(def);
    cast.lights.push_back(i);
  }
  if (draws && !cast.hairs.empty()) {
    if (Result<void> checked = checkOpaques(lights, store_.resources, cast); !checked)
      return checked;
    for (const size_t light : cast.opaqueLights)
      cast.opaques.push_back(opaquePlanOf(lights[light]));
  }
  return shadows.check(cast.defs, cast.opaques, cast.hairs, store_.factory(), store_.frame,
                       store_.moves, cast.plan);
}

// Positions where they are after a shift of the world; then the maps.
Result<void> ViewDrawing::addShadows(DrawnView& frame, PassList& list) {
  ShadowCast& cast = cast_;
  if (Result<void> moved = simulation_.movePending(list); !moved) return moved;
  const BufferFactory factory = store_.factory();
  if (Result<void> added = shadows.record(cast.plan, cast.hairs, factory, store_.frame, list);
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
  frame.shadowWords = shadows.words();
  frame.shadowBytes = factory.bytesOf(frame.shadowWords);
  return {};
}

// For debugging.
Result<void> ViewDrawing::drawCollider(ColliderId id, const View& view, const Light& light,
                                       const ColliderLook& look, PassList& list) {
  journal_.settle(false);
  static_cast<void>(store_.collider(id));
  if (const Result<DrawnView> frame = begin(view, {&light, 1}, &list); !frame) return frame.error();
  Result<void> added = store_.sdfs.draw(id, view, light, look, store_.factory(), list);
  setArea({&list, 1}, view);
  return added;
}

Result<void> ViewDrawing::drawContacts(HairId id, const View& view, const ContactLook& look,
                                       PassList& list) {
  journal_.settle(false);
  const HairObject& object = store_.hair(id);
  if (const Result<DrawnView> frame = begin(view, {}, &list); !frame) return frame.error();
  for (const auto& [value, name] :
       {std::pair(look.length, "length"), std::pair(look.width, "width"),
        std::pair(look.deepestDepth, "deepestDepth")}) {
    if (!(value > 0) || !std::isfinite(value))
      return Error{ErrorCode::kInvalidArgument, "ContactLook::" + std::string(name) + " is " +
                                                    std::to_string(value) +
                                                    "; it is a finite number > 0"};
  }
  if (Result<void> moved = simulation_.movePending(list); !moved) return moved;
  simulation_.finishMoves();
  Result<void> added = HairStore::of(object).get<HairColliders>().contacts().addDraw(
      list, object.buffers().positions, view, look);
  setArea({&list, 1}, view);
  return added;
}

void ViewDrawing::trim(const char* reason) {
  const BufferFactory factory = store_.factory();
  oit.trim(factory, reason);
  shadows.trim(factory, reason);
  colors.trim(factory, reason);
  depths.trim(factory, reason);
}

}  // namespace pelage::detail

namespace pelage {

float Scene::shareForView(HairId id, const View& view, float pixels) const {
  constexpr double kLeast = 1.0 / 64;
  const HairObject& object = hair(id);
  const detail::Ball ball = ballOfStrands(detail::HairStore::of(object));
  const Eigen::Matrix4d clip = detail::toMatrix(view.worldToClip);
  const Eigen::Vector4d center(double{ball.center.x}, double{ball.center.y}, double{ball.center.z},
                               1);
  // The nearest strands decide.
  const double w = clip.row(3) * center - double{ball.radius} * clip.row(3).head<3>().norm();
  const double pixelsAMetre = 0.5 * view.height * clip.row(1).head<3>().norm() / w;
  const double width = 2 * double{object.material.fiberRadius} * pixelsAMetre;
  const double share = width / double{pixels};
  // Behind or around the eye, and what is not a number, keep all strands; so does a width of 0.
  if (!(w > 0) || !(share >= 0)) return 1;
  return static_cast<float>(std::clamp(share, kLeast, 1.0));
}

Result<float> Scene::deepestContact(HairId id, std::span<const std::byte> contacts,
                                    std::span<const std::byte> contactWords,
                                    std::span<const std::byte> positions) const {
  return detail::HairStore::of(hair(id)).get<detail::HairColliders>().contacts().deepest(
      contacts, contactWords, positions);
}

}  // namespace pelage
