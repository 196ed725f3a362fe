// Simulates one groom with pelage's kernels and measures it with a kernel of this project, on an
// executor of this project. Exits with 0 when every strand ends up between 0 and its own length.
#include <EGL/egl.h>
#include <EGL/eglext.h>
#include <consumer/glsl.h>
#include <consumer/gpu_structs.h>
#include <consumer/kernels.h>
#include <pelage/glsl.h>
#include <pelage/hair_asset.h>
#include <pelage/scene.h>

#include <cstdio>
#include <utility>

#include "executor.h"

namespace {

constexpr uint32_t kStrands = 70;
constexpr uint32_t kVertices = 12;
constexpr float kSegment = 0.01f;

// Straight strands that stand up from a floor; gravity lets them fall over.
pelage::HairAsset makeAsset() {
  pelage::HairAsset asset;
  asset.strandCount = kStrands;
  asset.verticesPerStrand = kVertices;
  for (uint32_t strand = 0; strand < kStrands; ++strand) {
    for (uint32_t i = 0; i < kVertices; ++i) {
      const float up = kSegment * static_cast<float>(i);
      asset.positions.push_back(
          {0.01f * static_cast<float>(strand) + 0.1f * up, up, 0, i < 2 ? 0.0f : 1.0f});
    }
  }
  return asset;
}

bool makeContext() {
  const auto getDisplay = reinterpret_cast<PFNEGLGETPLATFORMDISPLAYEXTPROC>(
      eglGetProcAddress("eglGetPlatformDisplayEXT"));
  EGLDisplay display = EGL_NO_DISPLAY;
  if (getDisplay != nullptr)
    display = getDisplay(EGL_PLATFORM_SURFACELESS_MESA, EGL_DEFAULT_DISPLAY, nullptr);
  if (display == EGL_NO_DISPLAY || !eglInitialize(display, nullptr, nullptr)) return false;
  eglBindAPI(EGL_OPENGL_API);
  const EGLint attributes[] = {EGL_CONTEXT_MAJOR_VERSION, 4, EGL_CONTEXT_MINOR_VERSION, 5,
                               EGL_NONE};
  const EGLContext context =
      eglCreateContext(display, EGL_NO_CONFIG_KHR, EGL_NO_CONTEXT, attributes);
  return context != EGL_NO_CONTEXT &&
         eglMakeCurrent(display, EGL_NO_SURFACE, EGL_NO_SURFACE, context) == EGL_TRUE;
}

int fail(const char* what) {
  std::fprintf(stderr, "consumer: %s\n", what);
  return 1;
}

}  // namespace

int main() {
  if (!makeContext()) {
    std::puts("consumer: no OpenGL 4.5 without a window here, skipped");
    return 0;
  }
  pelage::HairAsset asset = makeAsset();
  if (const auto processed = asset.process(); !processed)
    return fail(processed.error().message.c_str());
  pelage::Scene scene;
  const auto hair = scene.addHair(asset, {.name = "grass"});
  if (!hair) return fail(hair.error().message.c_str());
  const pelage::HairBuffers& buffers = scene.hair(*hair).buffers();

  const pelage::BufferId extent = scene.resources().add(
      {.name = "extent", .size = kStrands * sizeof(float), .stride = sizeof(float)});

  pelage::KernelCodes code(pelage::allGlsl());
  code.add(consumer::allGlsl());
  Executor executor(std::move(code));
  executor.createBuffers(scene.resources());
  pelage::PassList list;
  for (int frame = 0; frame < 120; ++frame) {
    if (const auto done = scene.simulate(1.0f / 60, list); !done)
      return fail(done.error().message.c_str());
    if (frame == 119) {
      consumer::MeasureConstants constants = {};
      constants.strands = kStrands;
      constants.vertices = kVertices;
      pelage::PassBuilder measure(list);
      const auto added = measure.dispatch(consumer::strandExtentVariant({}), kStrands)
                             .bind("g_hair", buffers.positions, kStrands * kVertices * 16)
                             .bind("g_extent", extent, kStrands * sizeof(float))
                             .constants("MeasureConstants", constants)
                             .finish();
      if (!added) return fail(added.error().message.c_str());
    }
    scene.finish(list);
    executor.run(list, scene.resources());
  }
  const float length = asset.restLengths[0] * (kVertices - 1);
  const std::vector<float> extents = executor.read(extent, kStrands);
  for (const float value : extents) {
    if (!(value > 0.2f * length && value < 1.001f * length))
      return fail("a strand lost its length");
  }
  std::printf("consumer: %u strands, first extent %.4f m of %.4f m\n", kStrands,
              static_cast<double>(extents[0]), static_cast<double>(length));
  return 0;
}
