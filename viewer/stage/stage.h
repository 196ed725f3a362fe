// What is shown: a scene with hair, its camera and its clock.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "demo_scene.h"
#include "pelage/frame.h"
#include "pelage/hair_size.h"
#include "pelage/scene.h"
#include "stage/ball_mesh.h"
#include "stage/files.h"
#include "stage/hair_pull.h"
#include "stage/orbit_camera.h"
#include "stage/play_clock.h"

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
  /// kFiles: meters per unit; 0: 1, or what the hair's size makes likely.
  float scale = 0;
  pelage::Solver solver = pelage::Solver::kExact;
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
  /// Makes the next frame: moves the hair and draws it. \param realSeconds since the last one.
  /// \param width, height of the target [pixels]. The stage has something to show.
  pelage::Result<pelage::Frame> makeFrame(double realSeconds, uint32_t width, uint32_t height);
  /// A buffer for the depth of opaque things, where the method needs it; of the last makeFrame().
  pelage::BufferId depthCopy() const { return depthBuffer_; }
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

  OrbitCamera camera;
  PlayClock clock;
  StageLook look;
  StageBall ball;
  HairPull pull;
  pelage::ContactLook contactLook;  ///< with StageLook::showsContacts
  pelage::Scene& scene() { return scene_; }
  const pelage::Scene& scene() const { return scene_; }
  const std::vector<pelage::HairId>& hairs() const { return demo_->hairs(); }
  const std::vector<pelage::ColliderId>& colliders() const { return demo_->colliders(); }
  /// How often show() has changed what is shown; 0: there is nothing yet.
  uint64_t shown() const { return shown_; }

  /// The lights of the hair, one at least: none are a black one. The first one also lights the
  /// meshes.
  std::vector<pelage::Light> lights() const;
  void setLights(const std::vector<pelage::Light>& lights);
  const pelage::TransparencySettings& transparency() const { return transparency_; }
  /// The method is Stage::look's afterwards, too.
  void setTransparency(const pelage::TransparencySettings& settings);
  /// How hair was made, and making it in another way: those of sample::DemoScene.
  sample::DemoScene::HairMaking making(size_t hair) const { return demo_->making(hair); }
  pelage::Result<void> makeHairAgain(size_t hair, const sample::DemoScene::HairMaking& making) {
    pull.release(scene_);
    return demo_->makeHairAgain(hair, making);
  }
  bool hasMotions() const { return source_.kind == StageKind::kCharacter; }

 private:
  pelage::Result<sample::DemoScene> make(const StageSource& source, LoadedFiles& loaded);
  void applyLook(uint32_t width, uint32_t height);
  pelage::Result<void> drawContacts(const pelage::View& view, pelage::Frame& frame);

  pelage::Scene scene_;
  std::optional<sample::DemoScene> demo_;  // in scene_
  uint64_t shown_ = 0;
  StageDevice device_;
  StageSource source_;
  LoadedFiles loaded_;
  BallMesh ballMesh_;
  pelage::TransparencySettings transparency_;
  std::optional<StageLook> applied_;  // of the last frame
  pelage::BufferId depthBuffer_ = pelage::BufferId::kInvalid;
  uint32_t width_ = 0, height_ = 0;  // of the last frame
  uint64_t frame_ = 0;               // since the last change of what is drawn
  std::optional<pelage::SceneSnapshot> snapshot_;
};

}  // namespace viewer
