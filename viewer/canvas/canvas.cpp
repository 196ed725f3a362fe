#include "canvas/canvas.h"

#include <fmt/format.h>

#include <bit>
#include <cstdlib>
#include <fstream>
#include <iterator>
#include <string>
#include <system_error>

#include "image.h"
#include "viewer_kernels/gpu_structs.h"
#include "viewer_kernels/kernels.h"

namespace viewer {

using pelage::Error;
using pelage::ErrorCode;
using viewer_kernels::PictureConstants;

std::vector<std::byte> readCache(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  if (!file) return {};
  const std::vector<char> bytes((std::istreambuf_iterator<char>(file)), {});
  const auto view = std::as_bytes(std::span(bytes));
  return {view.begin(), view.end()};
}

void writeCache(const std::filesystem::path& path, std::span<const std::byte> bytes) {
  std::error_code error;
  std::filesystem::create_directories(path.parent_path(), error);
  const std::filesystem::path part = path.string() + ".part";
  {
    std::ofstream file(part, std::ios::binary);
    file.write(reinterpret_cast<const char*>(bytes.data()),
               static_cast<std::streamsize>(bytes.size()));
    if (!file.flush()) {
      std::filesystem::remove(part, error);
      return;
    }
  }
  std::filesystem::rename(part, path, error);
}

std::filesystem::path cacheFolder() {
  const char* folder = std::getenv("XDG_CACHE_HOME");
  if (folder != nullptr && folder[0] == '/') return std::filesystem::path(folder) / "pelage";
  const char* home = std::getenv("HOME");
  if (home != nullptr && home[0] == '/') return std::filesystem::path(home) / ".cache" / "pelage";
  return {};
}

pelage::Result<void> checkSamples(const pelage::DeviceInfo& info, uint32_t samples) {
  if (std::has_single_bit(samples) && (info.sampleCounts & samples) != 0) return {};
  std::string counts;
  for (uint32_t count = 1; count <= info.sampleCounts; count *= 2)
    if ((info.sampleCounts & count) != 0)
      counts += (counts.empty() ? "" : ", ") + std::to_string(count);
  return Error{ErrorCode::kUnsupported,
               fmt::format("view.samples is {}, but {} has targets of {} samples a pixel", samples,
                           info.name, counts)};
}

pelage::Result<std::unique_ptr<Canvas>> createCanvas(const CanvasDef& def, Window& window) {
  if (def.api == pelage::Api::kVulkan) {
#ifdef PELAGE_VIEWER_VULKAN
    return createVulkanCanvas(def, window);
#else
    return Error{ErrorCode::kUnsupported,
                 "this viewer was built without Vulkan: configure with -DPELAGE_VULKAN=ON"};
#endif
  }
#ifdef PELAGE_VIEWER_GL
  return createGlCanvas(def, window);
#else
  return Error{ErrorCode::kUnsupported,
               "this viewer was built without OpenGL: configure with -DPELAGE_GL=ON"};
#endif
}

pelage::Result<pelage::PassList> pictureList(pelage::TextureId scene, uint32_t width,
                                             uint32_t height, bool flipsRows, uint32_t coarseness) {
  const sample::Backdrop backdrop;
  PictureConstants constants = {};
  constants.backdropTop = {backdrop.top.x, backdrop.top.y, backdrop.top.z, backdrop.glow};
  constants.backdropBottom = {backdrop.bottom.x, backdrop.bottom.y, backdrop.bottom.z, 0};
  constants.pictureWidth = width;
  constants.pictureHeight = height;
  constants.flipsRows = flipsRows ? 1 : 0;
  constants.coarseness = coarseness;
  pelage::DrawState state;
  state.depthCompare = pelage::DepthCompare::kAlways;
  state.depthWrite = false;
  pelage::PassList list;
  pelage::Result<void> done = pelage::PassBuilder(list)
                                  .draw(viewer_kernels::pictureVertexVariant({}),
                                        viewer_kernels::picturePixelVariant({}), state, 3, 1)
                                  .constants("PictureConstants", constants)
                                  .bind("g_sceneColor", scene)
                                  .finish();
  if (!done) return done.error();
  return list;
}

}  // namespace viewer
