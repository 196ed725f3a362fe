// The characters of a row on a device, simulated with their colliders and drawn.
#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "demo_scene.h"
#include "light_rig.h"
#include "pelage/engine_lights.h"
#include "pelage/headless.h"
#include "scenes/drawing_rows.h"
#include "scenes/frame_figures.h"
#include "scenes/playback.h"
#include "scenes/scene_assets.h"
#include "simulation/workbench.h"

namespace bench {

/// How rows are drawn.
struct DrawingDef {
  /// kWindowed or kTiles; nothing: as chooseTransparency() has it in the first frame.
  std::optional<pelage::Transparency> method;
};

/// The lights of sample/engine_lights on a device, with the shadow maps of the character of a row
/// in its bind pose. Make them once a device, which keeps their textures.
pelage::Result<engine_lights::LightRig> makeLightRig(pelage::HeadlessDevice& device,
                                                     SceneAssets& assets, const DrawingRow& row);

/// Its objects and buffers are removed from the workbench's scene with it.
class DrawingRun {
 public:
  /// \param rig  lives as long. Errors: those of the scene; a method without its kernels.
  static pelage::Result<std::unique_ptr<DrawingRun>> create(Workbench& workbench,
                                                            SceneAssets& assets,
                                                            const DrawingRow& row,
                                                            const DrawingDef& def,
                                                            const engine_lights::LightRig& rig);
  ~DrawingRun();
  DrawingRun(const DrawingRun&) = delete;
  DrawingRun& operator=(const DrawingRun&) = delete;

  /// Runs frames of 1/60 s, and keeps the hair of each in caches, which the next frames play.
  /// \param frames  1 or more
  pelage::Result<void> recordFrames(int frames);
  /// Runs the next frame of 1/60 s. \param figures  nullptr: it is not timed
  pelage::Result<void> runFrame(FrameFigures* figures);
  /// Contents of lists or tiles in the last frame.
  pelage::Result<pelage::TransparencyCounters> counters();
  /// Gives lists or tiles the room that the last frame wanted. They keep it in the next ones.
  pelage::Result<void> grow();

  const std::vector<sample::DemoScene>& demos() const { return demos_; }
  /// How long the host took to set the positions of the last frame that was played [us].
  double showUs() const { return showUs_; }
  pelage::Transparency method() const { return settings_.method; }
  /// The picture of the last frame.
  const pelage::RenderedImage& picture() const { return picture_; }

 private:
  DrawingRun(Workbench& workbench, std::vector<sample::DemoScene> demos, const DrawingRow& row);
  void choose();
  void chooseDetail();
  bool drawsDepth() const;
  pelage::Result<void> write();
  pelage::Result<void> drawDepth();
  pelage::Result<void> simulate(FrameFigures* figures);
  pelage::Result<pelage::RenderedImage> showView(const std::vector<pelage::PassList>& view,
                                                 FrameFigures* figures);
  pelage::Result<void> show(FrameFigures* figures);
  PassGroup groupInSimulation(const pelage::PassList& list, const pelage::Pass& pass) const;
  uint64_t vertexCount() const;
  PassGroup groupInPicture(const pelage::PassList& list, const pelage::Pass& pass) const;

  Workbench& workbench_;
  std::vector<sample::DemoScene> demos_;
  sample::DemoScene& demo_;  ///< the first, whose light and camera are those of all
  DrawingRow row_;
  DrawingDef def_;
  std::optional<pelage::EngineLights> lights_;
  bool chosen_ = false;
  pelage::View view_, otherView_;
  pelage::RenderTargetDef target_;
  pelage::TransparencySettings settings_;
  pelage::PassList simulation_, between_, depth_;
  std::vector<pelage::PassList> lists_, otherLists_;  ///< of the picture, of the other eye's
  pelage::RenderedImage picture_;
  Playback playback_;
  double showUs_ = 0;
};

}  // namespace bench
