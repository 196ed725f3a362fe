// WebScene for JavaScript: web_scene.mjs calls these. What returns a number returns 0 for an error,
// whose text pelage_web_error() has.
#include <emscripten.h>

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>

#include "web_scene.h"

namespace {

using namespace pelage;
using webgpu::WebScene;

std::string lastError;
std::string lastText;
size_t frameBytes = 0;
constexpr uint32_t kOfGroom = 0xffffffff;

WebScene* taken(Result<std::unique_ptr<WebScene>> made) {
  if (made) return made->release();
  lastError = made.error().message;
  return nullptr;
}

uint32_t succeeded(const Result<void>& done) {
  if (!done) lastError = done.error().message;
  return done ? 1 : 0;
}

}  // namespace

extern "C" {

EMSCRIPTEN_KEEPALIVE const char* pelage_web_error() { return lastError.c_str(); }

EMSCRIPTEN_KEEPALIVE WebScene* pelage_web_character() { return taken(WebScene::character()); }

// Numbers that are kOfGroom are those of the groom.
EMSCRIPTEN_KEEPALIVE WebScene* pelage_web_head(uint32_t groom, uint32_t strands, uint32_t follow,
                                               uint32_t seed) {
  const auto given = [](uint32_t number) {
    return number == kOfGroom ? std::nullopt : std::optional(number);
  };
  return taken(WebScene::head({.groom = static_cast<sample::GroomPreset>(groom),
                               .strands = given(strands),
                               .followPerGuide = given(follow),
                               .seed = seed}));
}

EMSCRIPTEN_KEEPALIVE WebScene* pelage_web_hair(const std::byte* tfx, size_t size) {
  return taken(WebScene::hair({tfx, size}, "hair.tfx"));
}

EMSCRIPTEN_KEEPALIVE void pelage_web_free(WebScene* scene) { delete scene; }

EMSCRIPTEN_KEEPALIVE const std::byte* pelage_web_frame(WebScene* scene, float seconds, float eyeX,
                                                       float eyeY, float eyeZ, float targetX,
                                                       float targetY, float targetZ,
                                                       float verticalFov, uint32_t width,
                                                       uint32_t height) {
  const auto frame = scene->frame(seconds, {.eye = {eyeX, eyeY, eyeZ},
                                            .target = {targetX, targetY, targetZ},
                                            .verticalFov = verticalFov,
                                            .width = width,
                                            .height = height});
  if (!frame) {
    lastError = frame.error().message;
    return nullptr;
  }
  frameBytes = frame->size();
  return frame->data();
}

EMSCRIPTEN_KEEPALIVE size_t pelage_web_frame_bytes() { return frameBytes; }

EMSCRIPTEN_KEEPALIVE uint32_t pelage_web_depth_buffer(const WebScene* scene) {
  return scene->depthBuffer();
}

EMSCRIPTEN_KEEPALIVE uint32_t pelage_web_counters_buffer(const WebScene* scene) {
  return scene->countersBuffer();
}

EMSCRIPTEN_KEEPALIVE uint32_t pelage_web_take_counters(WebScene* scene, const std::byte* words,
                                                       size_t size) {
  return succeeded(scene->takeCounters({words, size}));
}

// Its eye, its target and its vertical field of view.
EMSCRIPTEN_KEEPALIVE const float* pelage_web_camera(const WebScene* scene, float aspect) {
  static std::array<float, 7> camera;
  const auto [eye, target, verticalFov, near, far] = scene->camera(aspect);
  camera = {eye.x, eye.y, eye.z, target.x, target.y, target.z, verticalFov};
  return camera.data();
}

EMSCRIPTEN_KEEPALIVE uint32_t pelage_web_hairs(const WebScene* scene) {
  return static_cast<uint32_t>(scene->hairs().size());
}

EMSCRIPTEN_KEEPALIVE uint32_t pelage_web_positions_buffer(WebScene* scene, uint32_t hair) {
  const uint32_t number = hair < scene->hairs().size() ? scene->positionsBuffer(hair) : 0;
  if (number == 0) lastError = "no frame so far has hair object " + std::to_string(hair);
  return number;
}

EMSCRIPTEN_KEEPALIVE size_t pelage_web_guide_bytes(const WebScene* scene, uint32_t hair) {
  return scene->guideBytes(hair);
}

// 1 + whether hair is there.
EMSCRIPTEN_KEEPALIVE uint32_t pelage_web_pull(WebScene* scene, float x, float y,
                                              const std::byte* guides, size_t size) {
  const auto pulled = scene->pull(x, y, {guides, size});
  if (!pulled) lastError = pulled.error().message;
  return pulled ? 1 + *pulled : 0;
}

EMSCRIPTEN_KEEPALIVE void pelage_web_drag_to(WebScene* scene, float x, float y) {
  scene->dragTo(x, y);
}
EMSCRIPTEN_KEEPALIVE void pelage_web_release(WebScene* scene) { scene->release(); }

EMSCRIPTEN_KEEPALIVE const char* pelage_web_presets() {
  lastText = WebScene::presets();
  return lastText.c_str();
}

EMSCRIPTEN_KEEPALIVE uint32_t pelage_web_take_preset(WebScene* scene, const char* name) {
  return succeeded(scene->takePreset(name));
}

EMSCRIPTEN_KEEPALIVE const char* pelage_web_parameters(WebScene* scene) {
  lastText = scene->parameters();
  return lastText.c_str();
}

EMSCRIPTEN_KEEPALIVE uint32_t pelage_web_set(WebScene* scene, const char* section, const char* path,
                                             const double* values, size_t count) {
  return succeeded(scene->set(section, path, {values, count}));
}

}  // extern "C"
