// A scene for a page: hair and what it grows on, simulated and drawn by tiles, as flat frames.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "frame_words.h"
#include "pelage/collision_mesh.h"
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

/// A vertex of the body, as a vertex buffer has it.
struct BodyVertex {
  Float3 position = {}, normal = {}, color = {};
};

/// Threads: one thread at a time.
class WebScene {
 public:
  /// The list of a frame before which the depth of opaque objects is in depthBuffer(), a float a
  /// pixel: 0 simulates, 1 makes shadow maps, 2 and the next ones draw.
  static constexpr uint32_t kDepthList = 2;

  /// The demo's character with three grooms and three SDFs, which walks.
  static Result<std::unique_ptr<WebScene>> character();
  /// The demo's groom on a head with an SDF, which turns.
  static Result<std::unique_ptr<WebScene>> head(uint32_t strands, uint64_t seed);
  /// Hair of a .tfx file, without a body. Errors: those of loadTfx(). \param name  for messages
  static Result<std::unique_ptr<WebScene>> hair(std::span<const std::byte> tfx,
                                                std::string_view name);

  /// Simulates and draws the next frame. Its lists count as run. Errors: those of Scene.
  Result<std::span<const std::byte>> frame(float seconds, const WebCamera& camera);
  /// The same for an executor in C++, which says what it has run: the lists are in lists().
  Result<void> step(float seconds, const WebCamera& camera);
  std::span<const PassList* const> lists() const { return {lists_.data(), lists_.size()}; }
  /// The number of the buffer for the depth of opaque objects, of the last frame: new where the
  /// size is another one, and then far everywhere.
  uint32_t depthBuffer() const { return writer_.numberOf(depth_); }

  /// The number of the buffer with the positions of a hair object: four floats a vertex.
  uint32_t positionsBuffer(size_t hair) const {
    return writer_.numberOf(scene_.hair(hairs_[hair]).buffers().positions);
  }

  /// The body as of the last frame; three indices a triangle. Empty without one.
  std::span<const BodyVertex> body() const { return body_; }
  std::span<const uint32_t> bodyIndices() const { return mesh_.indices; }

  /// The parameters of hair and light as JSON: an array of objects with section, path, type, unit,
  /// range, meaning, choices, slider (from, to, whether logarithmic) and value.
  std::string parameters();
  /// Sets a parameter of all hair, or of the light. \param values  as many as its type has: a
  /// choice is one number, and so is a bool. Errors: there is none of this name, or a value out of
  /// range.
  Result<void> set(std::string_view section, std::string_view path, std::span<const double> values);

  Scene& scene() { return scene_; }
  std::span<const HairId> hairs() const { return hairs_; }

 private:
  WebScene() = default;
  Result<void> addHair(HairAsset asset, HairDef def, const FollowDef* follow);
  Result<void> addCollider(const CollisionMesh& mesh, std::string_view name);
  void pose();
  void setArea(uint32_t width, uint32_t height);
  std::vector<void*> objectsOf(std::string_view section);

  Scene scene_;
  FrameWriter writer_;
  std::vector<HairId> hairs_;
  std::vector<ColliderId> colliders_;
  std::function<std::vector<AffineTransform>(double)> motion_;
  double time_ = 0;
  CollisionMesh mesh_;
  std::vector<Float3> colors_;  // [vertex]
  std::vector<BodyVertex> body_;
  std::vector<Light> lights_ = {Light{}};
  BufferId depth_ = BufferId::kInvalid;
  uint32_t width_ = 0, height_ = 0;
  PassList simulated_;
  std::vector<PassList> drawn_;
  std::vector<const PassList*> lists_;
};

}  // namespace pelage::webgpu
