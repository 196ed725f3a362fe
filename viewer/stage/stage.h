// What is shown: a scene with hair, its camera and its clock.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "canvas/canvas.h"
#include "demo_scene.h"
#include "pelage/frame.h"
#include "pelage/hair_size.h"
#include "pelage/scene.h"
#include "pelage/settings/scene_settings.h"
#include "stage/ball_mesh.h"
#include "stage/files.h"
#include "stage/hair_pull.h"
#include "stage/inspection.h"
#include "stage/inspection_look.h"
#include "stage/orbit_camera.h"
#include "stage/play_clock.h"
#include "stage/statistics.h"

namespace viewer {

enum class StageKind : uint8_t {
  kCharacter,  ///< the generated character with three grooms
  kHead,       ///< a generated head with one groom
  kFiles,
};

/// What to show. Equal values show the same.
struct StageSource {
  StageKind kind = StageKind::kCharacter;
  sample::GroomPreset preset = sample::GroomPreset::kParted;  ///< kHead
  std::vector<std::filesystem::path> files = {};              ///< kFiles
  std::string clip = {};  ///< kFiles: name of the clip that moves bones; empty: the first one
  /// kFiles: meters per unit; 0: 1, or what the hair's size makes likely.
  float scale = 0;
  pelage::Solver solver = pelage::Solver::kExact;
  /// kHead: what its hair collides with.
  sample::HeadCollider headCollider = sample::HeadCollider::kCapsules;
};

/// How it is drawn and moved; may change at any time.
struct StageLook {
  pelage::Transparency transparency = pelage::Transparency::kWindowed;
  pelage::HairShadow shadow = pelage::HairShadow::kDeep;
  pelage::CharacterMotion motion = pelage::CharacterMotion::kAll;
  pelage::Float3 wind = {};  ///< [m/s]
  float strandShare = 1;     ///< of the strands that are drawn, wider where it is less: 0.02..1
  bool showsContacts = false;
  bool operator==(const StageLook&) const = default;
};

/// A ball that a user drags through the hair.
struct StageBall {
  bool present = false;
  pelage::Float3 center;  ///< [m]
  float radius = 0.05f;   ///< [m], > 0
};

/// What of a device the stage has to know.
struct StageDevice {
  pelage::Tier tier = pelage::Tier::kWide;
  uint64_t maxBufferBytes = uint64_t{128} << 20;
};

class Stage {
 public:
  Stage() = default;

  /// Shows something else. Errors: those of the files; the stage stays as it is then.
  pelage::Result<void> show(const StageSource& source);
  const StageSource& source() const { return source_; }
  /// Meters per unit of the files.
  float scale() const { return loaded_.scale; }
  /// Remarks on the files that show() took, one a line: repaired values, a likely unit.
  const std::vector<std::string>& remarks() const { return loaded_.remarks; }
  /// Units that the files may be in, the likeliest first; empty where they are in meters.
  const std::vector<pelage::UnitGuess>& unitGuesses() const { return loaded_.guesses; }
  /// Mean length of the strands of the files with the scale [m].
  double meanLength() const { return loaded_.meanLength; }

  void setDevice(const StageDevice& device);
  /// Lets transparency take what the device has: for a window that has grown over a smaller cap.
  /// \return whether it had less.
  bool resetMemory();
  /// Gives views the default target, which every device has. \return whether it was another one.
  bool resetTarget();
  /// Makes the next frame: moves the hair and draws it. \param realSeconds since the last one.
  /// \param width, height of the target [pixels]. The stage has something to show.
  pelage::Result<pelage::Frame> makeFrame(double realSeconds, uint32_t width, uint32_t height);
  /// The views of the last makeFrame(), in the order of the frame.
  const std::vector<CanvasView>& views() const { return views_; }
  /// Reads the counters of the chosen side. \param read reads a buffer back: it waits for the
  /// device, so do it every some frames. Errors: those of `read`.
  pelage::Result<StageStatistics> statistics(const pelage::BufferReader& read) const;
  /// Takes what the last frame counted, so that the next one's lists have room, and the hair that
  /// the mouse pulls. \param read reads a buffer back. Cheap where nothing is to be read.
  pelage::Result<void> measure(const pelage::BufferReader& read);

  /// All is in the picture, seen from where the camera is.
  void frameAll(float aspect);
  /// Puts the hair into its bind shape, and the motion to its beginning.
  void reset();
  /// The state of the hair, to go on from when the device is lost.
  pelage::Result<void> takeSnapshot(const pelage::BufferReader& read);
  /// Another device takes over; setDevice() comes after. \return number of objects that go on.
  pelage::Result<uint32_t> recover();

  /// Shows what is there once more, at the right, with a solver; both have the same clock, camera,
  /// ball and look, and settings of their own, which begin as those at the left. Nothing: it goes.
  /// Errors: those of show(); the stage stays as it is then.
  pelage::Result<void> compare(std::optional<pelage::Solver> right);
  /// Number of sides: 1 or 2.
  uint32_t sides() const { return right_ ? 2 : 1; }
  /// The side whose hair, colliders and lights the functions below give: 0 is the left one.
  uint32_t side() const { return side_; }
  void chooseSide(uint32_t side) { side_ = std::min(side, sides() - 1); }
  pelage::Solver solverOf(uint32_t side) const;

  OrbitCamera camera;
  PlayClock clock;
  StageLook look;
  StageBall ball;
  HairPull pull;
  InspectionLook inspection;
  /// Figures of the chosen side, with the look of the last frames.
  const InspectionFigures& inspected() const { return inspections_[side_].figures(); }
  pelage::ContactLook contactLook;    ///< with StageLook::showsContacts
  pelage::ViewSettings viewSettings;  ///< of all views: the canvas has the same target
  pelage::Scene& scene() { return scene_; }
  const pelage::Scene& scene() const { return scene_; }
  const std::vector<pelage::HairId>& hairs() const { return chosen().hairs(); }
  const std::vector<pelage::ColliderId>& colliders() const { return chosen().colliders(); }
  /// How often show() or compare() has changed what is on this side; 0: there is nothing yet.
  uint64_t shown() const { return shown_[side_]; }

  /// The lights of the hair, one at least: none are a black one. The first one also lights the
  /// meshes.
  std::vector<pelage::Light> lights() const { return lightsOf(side_); }
  void setLights(const std::vector<pelage::Light>& lights);
  const pelage::TransparencySettings& transparency() const { return transparency_; }
  /// The method is Stage::look's afterwards, too.
  void setTransparency(const pelage::TransparencySettings& settings);
  /// How hair of the chosen side was made, and making it in another way: those of
  /// sample::DemoScene.
  sample::DemoScene::HairMaking making(size_t hair) const { return chosen().making(hair); }
  pelage::Result<void> makeHairAgain(size_t hair, const sample::DemoScene::HairMaking& making);
  bool hasMotions() const { return source_.kind == StageKind::kCharacter; }

 private:
  pelage::Result<sample::DemoScene> make(const StageSource& source, LoadedFiles& loaded);
  std::vector<pelage::Light> lightsOf(uint32_t side) const;
  void applyLook(uint32_t width, uint32_t height);
  const sample::DemoScene& chosen() const { return side_ == 0 ? *demo_ : *right_; }
  sample::DemoScene& demoOf(uint32_t side) { return side == 0 ? *demo_ : *right_; }
  const sample::DemoScene& demoOf(uint32_t side) const { return side == 0 ? *demo_ : *right_; }
  std::vector<pelage::SceneSettings> settingsOfAll() const;
  pelage::Result<void> takeSettings(const std::vector<pelage::SceneSettings>& left);
  void separateColliders();
  pelage::Result<pelage::TransparencyPlan> planView() const;
  void makeDepthBuffers(uint32_t width, uint32_t height);
  std::vector<bool> showHair(uint32_t side);
  void restoreHair(const std::vector<bool>& visible);
  pelage::Result<void> drawSide(uint32_t side, const pelage::CapsuleCollider* ball,
                                pelage::Frame& frame);
  pelage::Result<void> drawContacts(uint32_t side, const pelage::View& view, pelage::Frame& frame);

  pelage::Scene scene_;
  std::optional<sample::DemoScene> demo_, right_;  // in scene_
  pelage::Solver rightSolver_ = pelage::Solver::kExact;
  uint32_t side_ = 0;  // that is chosen
  std::array<uint64_t, 2> shown_ = {};
  std::array<Inspection, 2> inspections_;
  StageDevice device_;
  StageSource source_;
  LoadedFiles loaded_;
  BallMesh ballMesh_;
  pelage::TransparencySettings transparency_;
  std::optional<StageLook> applied_;  // of the last frame
  InspectionLook inspectionBefore_;
  uint64_t inspectedFrames_ = 0;  // with it
  std::array<pelage::BufferId, 2> depthBuffers_ = {pelage::BufferId::kInvalid,
                                                   pelage::BufferId::kInvalid};
  std::vector<CanvasView> views_;
  uint32_t width_ = 0, height_ = 0;  // of the last frame
  uint64_t frame_ = 0;               // since the last change of what is drawn
  std::optional<pelage::SceneSnapshot> snapshot_;
};

}  // namespace viewer
