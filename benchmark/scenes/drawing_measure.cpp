#include "scenes/drawing_measure.h"

#include <algorithm>
#include <cmath>
#include <string>

namespace bench {

using pelage::Error;
using pelage::ErrorCode;
using pelage::Result;

namespace {

// A row draws a third of the frames of a row without pictures: each picture is read back.
constexpr int kFrameShare = 3;
constexpr int kPlayedFrames = 48;

double meanLightOf(const pelage::RenderedImage& picture) {
  double sum = 0;
  for (const pelage::Float4& p : picture.pixels)
    sum += static_cast<double>(p.x) + static_cast<double>(p.y) + static_cast<double>(p.z);
  return sum / (3 * static_cast<double>(picture.pixels.size()));
}

sample::ByteImage shownOf(pelage::RenderedImage picture) {
  sample::compositeOver(picture, {});
  return sample::encodeSrgb(picture);
}

// Counts what the measured frames held. The device reads each picture back, which is a pause.
Result<void> measureFrames(DrawingRun& run, CopyReference& reference, int frames,
                           DrawingResult& result) {
  for (int frame = 0; frame < frames; ++frame) {
    if (Result<void> done = reference.afterPause(); !done) return done;
    if (Result<void> done = run.runFrame(&result.figures); !done) return done;
    const auto held = run.counters();
    if (!held) return held.error();
    result.fragments = std::max(result.fragments, held->fragments);
    result.spilled = std::max(result.spilled, held->spilled);
    if (result.row.extra == DrawingExtra::kPlayback) result.showUs.push_back(run.showUs());
  }
  return {};
}

Result<DrawingResult> measureOnce(Workbench& workbench, CopyReference& reference,
                                  SceneAssets& assets, const DrawingRow& row,
                                  const engine_lights::LightRig& rig, const DrawingDef& drawing,
                                  const MeasureDef& def) {
  auto run = DrawingRun::create(workbench, assets, row, drawing, rig);
  if (!run) return run.error();
  DrawingResult result;
  result.row = row;
  for (const sample::DemoScene& demo : (*run)->demos())
    for (const pelage::HairId id : demo.hairs()) {
      const pelage::HairObject& hair = workbench.scene.hair(id);
      result.guides += hair.guideCount();
      result.followHairs += hair.followCount();
    }
  if (row.extra == DrawingExtra::kPlayback)
    if (Result<void> done = (*run)->recordFrames(std::clamp(def.frames, 1, kPlayedFrames)); !done)
      return done.error();
  for (int frame = 0; frame < def.warmUpFrames / kFrameShare; ++frame) {
    if (Result<void> done = (*run)->runFrame(nullptr); !done) return done.error();
    if (Result<void> done = (*run)->grow(); !done) return done.error();
  }
  const auto copies = reference.around([&] {
    return measureFrames(**run, reference, std::max(def.frames / kFrameShare, 1), result);
  });
  if (!copies) return copies.error();
  result.copies = *copies;
  result.bytes = workbench.device.bufferBytes();
  result.method = (*run)->method();
  result.meanLight = meanLightOf((*run)->picture());
  result.picture = shownOf((*run)->picture());
  return result;
}

bool hasGroup(DrawingExtra extra, PassGroup group) {
  switch (group) {
    case PassGroup::kKept:
      return extra == DrawingExtra::kMotion || extra == DrawingExtra::kInterpolation;
    case PassGroup::kInterpolation:
      return extra == DrawingExtra::kInterpolation;
    case PassGroup::kDepth:
      return extra == DrawingExtra::kDepth || extra == DrawingExtra::kMotion;
    case PassGroup::kSdf:
      return extra != DrawingExtra::kPlayback;
    default:
      return true;
  }
}

}  // namespace

Spread drawingTime(const FrameFigures& figures) { return figures.of(kDrawingGroups); }

Result<DrawingResult> measureDrawing(Workbench& workbench, CopyReference& reference,
                                     SceneAssets& assets, const DrawingRow& row,
                                     const engine_lights::LightRig& rig, const DrawingDef& drawing,
                                     const MeasureDef& def) {
  return steadiest(reference.clocks(), [&] {
    return measureOnce(workbench, reference, assets, row, rig, drawing, def);
  });
}

Result<void> checkDrawing(const DrawingResult& result) {
  const auto fault = [&](const std::string& what) -> Result<void> {
    return Error{ErrorCode::kDevice, result.row.name() + ": " + what};
  };
  for (size_t i = 0; i < kPassGroups; ++i) {
    const auto group = static_cast<PassGroup>(i);
    const bool wanted = hasGroup(result.row.extra, group);
    if (result.figures.has(group) != wanted)
      return fault((wanted ? "no pass of the group " : "a pass of the group ") +
                   std::string(passGroupName(group)));
  }
  if (result.figures.isTimed() && !(drawingTime(result.figures).mean > 0))
    return fault("no pass that draws took time");
  if (result.fragments == 0) return fault("no hair is in the picture");
  if (!(result.meanLight > 0) || !std::isfinite(result.meanLight))
    return fault("the picture is black, or not finite");
  return {};
}

Result<void> comparePictures(std::span<const DrawingResult> results) {
  const DrawingResult* alone = nullptr;
  for (const DrawingResult& result : results) {
    const DrawingExtra extra = result.row.extra;
    if (extra == DrawingExtra::kNone) alone = &result;
    if (alone == nullptr) continue;
    const bool same = result.meanLight == alone->meanLight;
    const bool mustBe = extra == DrawingExtra::kDepth || extra == DrawingExtra::kMotion ||
                        extra == DrawingExtra::kStereo;
    const bool mustNot = extra == DrawingExtra::kEngineLights;
    if ((mustBe && !same) || (mustNot && same))
      return Error{ErrorCode::kDevice, result.row.name() + ": its picture is " +
                                           (same ? "that" : "not that") + " of the row alone"};
  }
  return {};
}

}  // namespace bench
