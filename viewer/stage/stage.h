// The stage: a scene with hair, its camera and its clock.
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
#include "hair_pull.h"
#include "mesh_object.h"
#include "pelage/demo/character.h"
#include "pelage/frame.h"
#include "pelage/scene.h"
#include "pelage/settings/scene_settings.h"
#include "pelage/transparency.h"
#include "stage/files.h"
#include "stage/inspection.h"
#include "stage/inspection_look.h"
#include "stage/orbit_camera.h"
#include "stage/statistics.h"

namespace viewer {

enum class StageKind : uint8_t {
  kCharacter,  ///< the generated character with three grooms
  kHead,       ///< a generated head with one groom
  kFiles,
};

/// The source of hair.
struct StageSource {
  StageKind kind = StageKind::kCharacter;
  sample::GroomPreset preset = sample::GroomPreset::kParted;  ///< kHead
  std::vector<std::filesystem::path> files = {};              ///< kFiles
  std::string clip = {};  ///< kFiles: name of the clip that moves bones; empty: the first one
  /// kFiles: meters per unit; 0: 1, or the likeliest unit for the hair's size.
  float scale = 0;
  pelage::Solver solver = pelage::Solver::kExact;
  /// kHead: the collider of its hair.
  sample::HeadCollider headCollider = sample::HeadCollider::kCapsules;
};

/// How hair is drawn and moved; may change at any time.
struct StageLook {
  pelage::Transparency transparency = pelage::Transparency::kWindowed;
  pelage::HairShadow shadow = pelage::HairShadow::kDeep;
  pelage::CharacterMotion motion = pelage::CharacterMotion::kAll;
  pelage::Float3 wind = {};  ///< [m/s]
  float strandShare = 1;     ///< share of strands that are drawn, 0.02..1; fewer ones are wider
  /// Fewer of them where fibers are narrower in the view [pixels], 0..4: Scene::shareForView().
  float detailPixels = pelage::kDetailPixels;
  bool showsContacts = false;
  bool showsGround = false;
  bool operator==(const StageLook&) const = default;
};

/// A ball that a user drags through the hair.
struct StageBall {
  bool present = false;
  pelage::Float3 center;  ///< [m]
  float radius = 0.05f;   ///< [m], > 0
};

/// The mesh of a stage's ball.
class BallMesh {
 public:
  /// Adds the draw of the ball to a list; the first call adds buffers to the table. \param radius >
  /// 0 [m].
  pelage::Result<void> draw(const pelage::Float3& center, float radius, const pelage::View& view,
                            const pelage::Light& light, pelage::ResourceTable& resources,
                            pelage::PassList& list);

 private:
  std::optional<sample::MeshObject> mesh_;
};

/// The ground: squares below all hair and meshes, in the shadow of the hair.
class GroundMesh {
 public:
  /// Adds the draw to a list, after DemoScene::drawOpaque(); the first call adds buffers to the
  /// table.
  pelage::Result<void> draw(const sample::DemoScene& demo, const pelage::View& view,
                            pelage::ResourceTable& resources, pelage::PassList& list);

 private:
  std::optional<sample::MeshObject> mesh_;
};

/// Time on the stage: playing, slow motion, single steps, loops.
struct PlayClock {
  static constexpr double kStep = 1.0 / 60;     ///< [s] of a frame of a fixed clock
  static constexpr double kLongest = 4.0 / 60;  ///< [s] that a frame simulates at most

  bool playing = true;
  bool fixed = false;  ///< each frame takes kStep, however long it really took
  bool loops = true;   ///< the motion starts over at its end; otherwise it stops there
  bool steps = false;  ///< the next frame takes kStep, then time stops
  double speed = 1;    ///< factor on time, 0.01..4
  double time = 0;     ///< [s] of the motion

  /// Advances the time. \param realSeconds since the last frame. \return seconds to simulate:
  /// 0..kLongest.
  double advance(double realSeconds, const pelage::CharacterCycle& cycle);
};

/// The device that draws the stage.
struct StageDevice {
  pelage::Tier tier = pelage::Tier::kWide;
  uint64_t maxBufferBytes = uint64_t{128} << 20;
};

/// The transparency of all views. Its lists and tiles grow by the counters of earlier frames.
class StageTransparency {
 public:
  /// Counters of a frame, with the number of nodes that its lists or tiles had.
  struct Counted {
    pelage::TransparencyCounters counters;
    uint32_t nodeCount = 0;
  };

  const pelage::TransparencySettings& settings() const { return settings_; }
  /// Sets other settings. Stage::look has the method as well: set both.
  void set(const pelage::TransparencySettings& settings);
  /// Sets the size of the device's largest buffer, and the memory as resetMemory() does.
  void setDevice(uint64_t maxBufferBytes);
  /// Raises the caps of memory to the device's, for a window that has grown over smaller ones.
  /// \return whether one was smaller.
  bool resetMemory();

  /// Takes another method, or views of another size.
  void restart(pelage::Transparency method);
  /// Forgets the frames that were drawn: measure() begins anew.
  void forgetFrames() { frame_ = 0; }
  /// Begins a frame. \param width, height of a view [pixels]. \param strandVertices of a view.
  void beginFrame(uint32_t width, uint32_t height, uint64_t strandVertices);
  /// Sets the depth that a view reads; kInvalid: none.
  void setDepth(pelage::BufferId opaqueDepth) { settings_.opaqueDepth = opaqueDepth; }
  /// Reads the counters of the last frame; nothing for methods without lists or tiles. Errors:
  /// those of `read`.
  pelage::Result<std::optional<Counted>> count(const pelage::Scene& scene,
                                               const pelage::BufferReader& read) const;
  /// Gives the lists and tiles of the next frame the size that the last one wanted, every some
  /// frames. Errors: those of `read`.
  pelage::Result<void> measure(const pelage::Scene& scene, const pelage::BufferReader& read);

 private:
  pelage::TransparencySettings settings_;
  uint64_t maxBufferBytes_ = StageDevice().maxBufferBytes;
  uint64_t frame_ = 0;  // since the last restart
  uint32_t width_ = 0, height_ = 0;
  uint64_t strandVertices_ = 0;
};

/// One side of a stage.
struct StageSide {
  std::optional<sample::DemoScene> demo;  ///< in the stage's scene; nothing: the side is not shown
  pelage::Solver solver = pelage::Solver::kExact;
  uint64_t shown = 0;                                   ///< Stage::shown()
  pelage::EnvironmentLight environment;                 ///< Stage::ownEnvironment()
  pelage::BufferId depth = pelage::BufferId::kInvalid;  ///< TransparencySettings::opaqueDepth
  Inspection inspection;
};

/// The look that all hair of a frame has, with the size of the window [pixels].
struct AppliedLook {
  StageLook look;
  uint32_t width = 0, height = 0;
};

class Stage {
 public:
  Stage() = default;

  /// Shows another source. Errors: those of the files; the stage stays as it is then.
  pelage::Result<void> show(const StageSource& source);
  const StageSource& source() const { return source_; }
  /// Returns the files of the source with their remarks, but without assets.
  const LoadedFiles& files() const { return loaded_; }

  void setDevice(const StageDevice& device);
  /// Sets the default target of views, which every device has. \return whether it was another one.
  bool resetTarget();
  /// Makes the next frame: moves the hair and draws it. Call it after a successful show().
  /// \param realSeconds since the last one. \param width, height of the target [pixels].
  pelage::Result<pelage::Frame> makeFrame(double realSeconds, uint32_t width, uint32_t height);
  /// Returns the views of the last makeFrame(), in the order of the frame.
  const std::vector<CanvasView>& views() const { return views_; }
  /// Reads the counters of the chosen side. \param read reads a buffer back. It waits for the
  /// device: do not call it each frame. Errors: those of `read`.
  pelage::Result<StageStatistics> statistics(const pelage::BufferReader& read) const;
  /// Reads the counters of the last frame, from which the next one's lists get their size, and the
  /// hair that the mouse pulls. \param read reads a buffer back. Most frames read nothing. Errors:
  /// those of `read`.
  pelage::Result<void> measure(const pelage::BufferReader& read);

  /// Moves the camera so that all hair is in the picture. \param aspect width over height.
  void frameAll(float aspect);
  /// Puts the hair into its bind shape, and the motion to its beginning.
  void reset();
  /// Reads the state of the hair, for recover().
  pelage::Result<void> takeSnapshot(const pelage::BufferReader& read);
  /// Prepares for another device; call setDevice() next. \return number of objects that continue
  /// from takeSnapshot().
  pelage::Result<uint32_t> recover();

  /// Shows the source a second time at the right, with a solver; without one, the right side is
  /// removed. Both sides share clock, camera, ball and look. The right side has settings of its
  /// own, which begin as the left side's. Errors: those of show(); the stage stays as it is then.
  pelage::Result<void> compare(std::optional<pelage::Solver> right);
  /// Returns the number of sides: 1 or 2.
  uint32_t sides() const { return sides_[1].demo ? 2 : 1; }
  /// Returns the chosen side, 0 for left: its hair, colliders and lights are those of the functions
  /// below.
  uint32_t side() const { return side_; }
  void chooseSide(uint32_t side) { side_ = std::min(side, sides() - 1); }
  pelage::Solver solverOf(uint32_t side) const { return sides_[side].solver; }

  OrbitCamera camera;
  PlayClock clock;
  StageLook look;
  StageBall ball;
  sample::HairPull pull;
  StageTransparency transparency;
  InspectionLook inspection;
  /// Returns the figures of the chosen side, measured some frames ago.
  const InspectionFigures& inspected() const { return sides_[side_].inspection.figures(); }
  pelage::ColliderLook colliderLook;  ///< of InspectedValue::kSdfSurface
  pelage::ContactLook contactLook;    ///< with StageLook::showsContacts
  pelage::ViewSettings viewSettings;  ///< of all views: CanvasTarget must match
  pelage::Scene& scene() { return scene_; }
  const pelage::Scene& scene() const { return scene_; }
  const std::vector<pelage::HairId>& hairs() const { return chosen().hairs(); }
  const std::vector<pelage::ColliderId>& colliders() const { return chosen().colliders(); }
  /// Counts the calls of show() or compare() that changed this side; 0: it shows nothing yet.
  uint64_t shown() const { return sides_[side_].shown; }

  /// Lights of the hair, at least one: setLights() makes a black one of an empty list. The first
  /// one also lights the meshes.
  std::vector<pelage::Light> lights() const;
  void setLights(const std::vector<pelage::Light>& lights);
  /// Returns the environment that the first light had when the scene was shown.
  const pelage::EnvironmentLight& ownEnvironment() const { return sides_[side_].environment; }
  /// Functions of sample::DemoScene for the chosen side.
  sample::DemoScene::HairMaking making(size_t hair) const { return chosen().making(hair); }
  pelage::Result<void> makeHairAgain(size_t hair, const sample::DemoScene::HairMaking& making);
  bool hasMotions() const { return source_.kind == StageKind::kCharacter; }

 private:
  const sample::DemoScene& chosen() const { return *sides_[side_].demo; }
  void applyLook(uint32_t width, uint32_t height);
  pelage::Result<void> drawSide(uint32_t index, const pelage::CapsuleCollider* ballShape,
                                pelage::Frame& frame);

  pelage::Scene scene_;
  StageSource source_;
  LoadedFiles loaded_;
  std::array<StageSide, 2> sides_;
  uint32_t side_ = 0;  // the chosen one
  BallMesh ballMesh_;
  GroundMesh groundMesh_;
  std::optional<AppliedLook> applied_;  // of the last frame
  std::vector<CanvasView> views_;
  std::optional<pelage::SceneSnapshot> snapshot_;
};

}  // namespace viewer
