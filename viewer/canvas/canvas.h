// Draws frames of a scene into a window, with a user interface on top, through one graphics API.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <span>
#include <vector>

#include "image.h"
#include "pelage/frame.h"
#include "pelage/headless.h"
#include "pelage/kernel_code.h"
#include "pelage/pass_list.h"
#include "pelage/result.h"
#include "pelage/scene.h"

struct ImDrawData;

namespace viewer {

class Window;

struct CanvasDef {
  pelage::Api api = pelage::Api::kVulkan;  ///< kVulkan or kGl
  bool validation = false;                 ///< as HeadlessDef::validation
  int deviceIndex = -1;                    ///< Vulkan: as HeadlessDef::deviceIndex
  /// Folder for code that the driver has compiled, which the next start reads; empty: none.
  std::filesystem::path cache = {};
  bool vsync = true;
};

/// Memory of the device that a canvas uses [bytes].
struct CanvasMemory {
  uint64_t buffers = 0;  ///< of the scene
  uint64_t frames = 0;   ///< of constants and uploads; 0 with OpenGL
};

/// The target of the scene.
struct CanvasTarget {
  uint32_t width = 0, height = 0;  ///< of the window [pixels], > 0
  uint32_t samples = 1;            ///< per pixel: one of DeviceInfo::sampleCounts
  bool reversedDepth = false;      ///< View::reversedDepth
  bool operator==(const CanvasTarget&) const = default;
};

/// A view of a frame on the canvas.
struct CanvasView {
  pelage::PixelArea area;  ///< within the canvas
  /// Receives the depth of opaque things after the first list of the view:
  /// TransparencySettings::opaqueDepth; kInvalid: none. Such a target has one sample per pixel.
  pelage::BufferId depthCopy = pelage::BufferId::kInvalid;
};

/// A frame for a canvas.
struct CanvasFrame {
  pelage::Frame* frame = nullptr;
  std::span<const CanvasView> views;  ///< all views of the frame
  ImDrawData* interface = nullptr;
  bool captures = false;  ///< captured() has the picture
  /// Edge of a pixel of the scene [pixels of the window], >= 1: the views take the top left of the
  /// target, and the picture magnifies them.
  uint32_t coarseness = 1;
};

/// Owns a device. It draws the scene into a linear target with depth, puts it over a backdrop,
/// encodes it for the screen, and draws the interface on top.  Threads: the main one.
class Canvas {
 public:
  virtual ~Canvas() = default;
  Canvas(const Canvas&) = delete;
  Canvas& operator=(const Canvas&) = delete;

  virtual const pelage::DeviceInfo& info() const = 0;
  /// Checks whether the device can draw views with a method.
  virtual pelage::Result<void> supports(const pelage::TransparencySettings& settings) const = 0;
  /// Makes the runtime again, with code of kernels that replaces the program's own; empty: without.
  /// The scene's buffers are lost: call Scene::recover() next. The code must outlive its use.
  /// Errors: those of making a runtime.
  virtual pelage::Result<void> setCode(pelage::KernelCodeList code) = 0;
  /// Makes the targets of the next frames, unless they exist. Errors: kUnsupported for a number of
  /// samples that the device does not have, with those that it has; the last targets stay then.
  virtual pelage::Result<void> setTarget(const CanvasTarget& target) = 0;
  /// Begins a frame: waits for an earlier one to finish. Call it before Scene::simulate(), and
  /// before the interface is built.
  virtual pelage::Result<void> begin() = 0;
  /// Runs a frame and shows it. Errors: kDeviceLost.
  virtual pelage::Result<void> show(const CanvasFrame& frame) = 0;
  /// Returns the picture of the last frame with `captures`, as the window shows it.
  const sample::ByteImage& captured() const { return captured_; }
  /// Reads a buffer back, after all frames so far: for Scene::takeSnapshot().
  virtual pelage::Result<std::vector<std::byte>> read(pelage::BufferId buffer) = 0;
  /// Returns the GPU times of the newest finished frame; empty without timestamps.
  const std::vector<pelage::PassTiming>& timings() const { return timings_; }
  virtual CanvasMemory memory() const = 0;
  /// Returns the number of validation messages so far.
  virtual uint32_t messageCount() const = 0;
  /// Writes the code that the driver has compiled to CanvasDef::cache.
  virtual void saveCache() = 0;

 protected:
  Canvas() = default;
  sample::ByteImage captured_;
  std::vector<pelage::PassTiming> timings_;
};

// Parts that the canvases of both APIs share.

/// Reads a file of code that a driver has compiled; empty where there is none.
std::vector<std::byte> readCache(const std::filesystem::path& path);
/// Writes the file and its folder, under another name first, so that it is always complete. A
/// folder that cannot be written is no error: the next start compiles again.
void writeCache(const std::filesystem::path& path, std::span<const std::byte> bytes);
/// Folder for the caches of programs: $XDG_CACHE_HOME/pelage, or ~/.cache/pelage; empty without
/// either.
std::filesystem::path cacheFolder();

/// Returns the draw of the last step of a frame, for a view of its own: the scene over a backdrop,
/// encoded for the screen. \param scene the scene's color, registered with the runtime: a 2D array
/// of one layer.
pelage::Result<pelage::PassList> pictureList(pelage::TextureId scene, uint32_t width,
                                             uint32_t height, bool flipsRows, uint32_t coarseness);

/// Checks that a device has targets with so many samples. Error: kUnsupported, with the numbers
/// that it has.
pelage::Result<void> checkSamples(const pelage::DeviceInfo& info, uint32_t samples);

/// Makes a canvas on a window of its API. The ImGui context exists already. Errors: no device, or a
/// device that lacks something; the message names it.
pelage::Result<std::unique_ptr<Canvas>> createCanvas(const CanvasDef& def, Window& window);
pelage::Result<std::unique_ptr<Canvas>> createVulkanCanvas(const CanvasDef& def, Window& window);
pelage::Result<std::unique_ptr<Canvas>> createGlCanvas(const CanvasDef& def, Window& window);

}  // namespace viewer
