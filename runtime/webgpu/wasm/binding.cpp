// WebScene for JavaScript: web_scene.mjs calls these. What returns a number returns 0 for an error,
// whose text pelage_web_error() has.
#include <emscripten.h>

#include <cstdint>
#include <memory>
#include <string>

#include "web_scene.h"

namespace {

using namespace pelage;
using webgpu::WebScene;

std::string lastError;
std::string lastText;
size_t frameBytes = 0;

WebScene* taken(Result<std::unique_ptr<WebScene>> made) {
  if (made) return made->release();
  lastError = made.error().message;
  return nullptr;
}

}  // namespace

extern "C" {

EMSCRIPTEN_KEEPALIVE const char* pelage_web_error() { return lastError.c_str(); }

EMSCRIPTEN_KEEPALIVE WebScene* pelage_web_character() { return taken(WebScene::character()); }

EMSCRIPTEN_KEEPALIVE WebScene* pelage_web_head(uint32_t strands, uint32_t seed) {
  return taken(WebScene::head(strands, seed));
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

EMSCRIPTEN_KEEPALIVE uint32_t pelage_web_positions_buffer(WebScene* scene, uint32_t hair) {
  const uint32_t number = hair < scene->hairs().size() ? scene->positionsBuffer(hair) : 0;
  if (number == 0) lastError = "no frame so far has hair object " + std::to_string(hair);
  return number;
}

EMSCRIPTEN_KEEPALIVE const webgpu::BodyVertex* pelage_web_body(const WebScene* scene) {
  return scene->body().data();
}
EMSCRIPTEN_KEEPALIVE size_t pelage_web_body_vertices(const WebScene* scene) {
  return scene->body().size();
}
EMSCRIPTEN_KEEPALIVE const uint32_t* pelage_web_body_indices(const WebScene* scene) {
  return scene->bodyIndices().data();
}
EMSCRIPTEN_KEEPALIVE size_t pelage_web_body_index_count(const WebScene* scene) {
  return scene->bodyIndices().size();
}

EMSCRIPTEN_KEEPALIVE const char* pelage_web_parameters(WebScene* scene) {
  lastText = scene->parameters();
  return lastText.c_str();
}

EMSCRIPTEN_KEEPALIVE uint32_t pelage_web_set(WebScene* scene, const char* section, const char* path,
                                             const double* values, size_t count) {
  const Result<void> done = scene->set(section, path, {values, count});
  if (!done) lastError = done.error().message;
  return done ? 1 : 0;
}

}  // extern "C"
