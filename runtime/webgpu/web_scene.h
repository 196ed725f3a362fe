// A scene for a page: hair and what it grows on, simulated and drawn by tiles, as flat frames.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "camera.h"
#include "demo_scene.h"
#include "frame_words.h"
#include "groom_presets.h"
#include "hair_pull.h"
#include "pelage/hair_asset.h"
#include "pelage/hair_object.h"
#include "pelage/result.h"
#include "pelage/scene.h"
#include "pelage/settings/scene_settings.h"

namespace pelage::webgpu {

struct WebCamera {
  Float3 eye = {0, 0, 1};
  Float3 target = {};
  float verticalFov = 0.6f;            ///< [rad]
  uint32_t width = 640, height = 480;  ///< [pixels]
};

/// Numbers that are not given are those of the groom.
struct WebHead {
  sample::GroomPreset groom = sample::GroomPreset::kParted;
  std::optional<uint32_t> strands;         ///< guides
  std::optional<uint32_t> followPerGuide;  ///< follow hairs
  uint64_t seed = 1;
};

/// Threads: one thread at a time.
class WebScene {
 public:
  /// The list of a frame before which the depth of opaque objects is in depthBuffer(), a float a
  /// pixel: 0 pulls hair, 1 simulates, 2 makes shadow maps and draws the body, 3 and the next ones
  /// draw hair.
  static constexpr uint32_t kDepthList = 3;

  /// The demo's character with three grooms and three SDFs, which walks, shakes its head and jumps.
  static Result<std::unique_ptr<WebScene>> character();
  /// A groom of the gallery on a head with an SDF, which looks around and nods.
  static Result<std::unique_ptr<WebScene>> head(const WebHead& def);
  /// Hair of a .tfx file, without a body. Errors: those of loadTfx(). \param name  for messages
  static Result<std::unique_ptr<WebScene>> hair(std::span<const std::byte> tfx,
                                                std::string_view name);

  /// A camera that sees all of the scene in every pose. \param aspect width over height
  sample::Camera camera(float aspect) const;
  /// Simulates and draws the next frame. Its lists count as run. Errors: those of Scene.
  Result<std::span<const std::byte>> frame(float seconds, const WebCamera& camera);
  /// The same for an executor in C++, which says what it has run: the lists are in lists().
  Result<void> step(float seconds, const WebCamera& camera);
  std::span<const PassList* const> lists() const { return {lists_.data(), lists_.size()}; }
  /// The buffer for the depth of opaque objects, of the last frame: new where the size is another
  /// one, and then far everywhere.
  BufferId depth() const { return depth_; }
  /// Its number in frames.
  uint32_t depthBuffer() const { return writer_.numberOf(depth_); }

  /// Bytes of countersBuffer() that takeCounters() wants.
  static constexpr size_t kCounterBytes = 32;
  /// The number of the buffer that counts the fragments of the last frame; 0 before the first.
  uint32_t countersBuffer() const;
  /// Makes room for as many fragments as a frame of this size had. Errors: fewer than
  /// kCounterBytes.
  Result<void> takeCounters(std::span<const std::byte> words);

  /// The number of the buffer with the positions of a hair object, four floats a vertex: guides
  /// come first.
  uint32_t positionsBuffer(size_t hair) const {
    return writer_.numberOf(scene_.hair(hairs()[hair]).buffers().positions);
  }
  /// Bytes of the guides' positions.
  size_t guideBytes(size_t hair) const;

  /// Takes the lock of hair at a pixel of the last frame, for dragTo(). Errors: `guides` has
  /// another size. \param x, y pixels from the top left. \param guides the first guideBytes() of
  /// the positions of each hair object, one behind the other. \return whether hair is there
  Result<bool> pull(float x, float y, std::span<const std::byte> guides);
  /// Drags the lock to a pixel, at its distance from the camera.
  void dragTo(float x, float y);
  void release() { pull_.release(scene_); }

  /// The parameters of hair and light as JSON: an array of objects with section, path, type, unit,
  /// range, meaning, choices, slider (from, to, whether logarithmic) and value.
  std::string parameters();
  /// Sets a parameter of all hair, or of the light. \param values  as many as its type has: a
  /// choice is one number, and so is a bool. Errors: there is none of this name, or a value out of
  /// range.
  Result<void> set(std::string_view section, std::string_view path, std::span<const double> values);
  /// settingsPresets() as JSON: an array of objects with name and meaning.
  static std::string presets();
  /// Gives all hair the simulation, the material and the follow hairs of a preset; hair is then in
  /// its bind shape. Errors: there is none of this name.
  Result<void> takePreset(std::string_view name);

  Scene& scene() { return scene_; }
  std::span<const HairId> hairs() const;

 private:
  WebScene() = default;
  void pose(double seconds);
  void setArea(uint32_t width, uint32_t height);
  std::vector<void*> objectsOf(std::string_view section);

  Scene scene_;
  FrameWriter writer_;
  std::optional<sample::DemoScene> demo_;
  // Without it.
  std::optional<HairId> hair_;
  std::vector<Float3> points_;
  Light ownLight_;

  double time_ = 0;
  sample::HairPull pull_;
  View view_;
  WebCamera camera_;
  BufferId depth_ = BufferId::kInvalid;
  TransparencySettings settings_;
  PassList pulled_, simulated_;
  std::vector<PassList> drawn_;
  std::vector<const PassList*> lists_;
};

}  // namespace pelage::webgpu
