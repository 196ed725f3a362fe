// Draws frames of a scene into a window, with a user interface on top, through one graphics API.
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <span>
#include <vector>

#include "image.h"
#include "pelage/frame.h"
#include "pelage/headless.h"
#include "pelage/kernel_code.h"
#include "pelage/result.h"
#include "pelage/scene.h"

struct ImDrawData;

namespace viewer {

class Window;

struct CanvasDef {
  pelage::Api api = pelage::Api::kVulkan;  ///< kVulkan or kGl
  bool validation = false;                 ///< as HeadlessDef::validation
  int deviceIndex = -1;                    ///< Vulkan: as HeadlessDef::deviceIndex
  /// Folder of what the driver has compiled, for the next start; empty: none.
  std::filesystem::path cache = {};
  bool vsync = true;
};

/// What a canvas takes of the device [bytes].
struct CanvasMemory {
  uint64_t buffers = 0;  ///< of the scene
  uint64_t frames = 0;   ///< of constants and uploads, where the API says so
};

/// What the scene is drawn into.
struct CanvasTarget {
  uint32_t width = 0, height = 0;  ///< of the window [pixels], > 0
  uint32_t samples = 1;            ///< a pixel: one of DeviceInfo::sampleCounts
  bool reversedDepth = false;      ///< depth begins at 0
  bool operator==(const CanvasTarget&) const = default;
};

/// A view of a frame on the canvas.
struct CanvasView {
  pelage::PixelArea area;  ///< within the canvas
  /// Receives the depth of opaque things after the first list of the view:
  /// TransparencySettings::opaqueDepth; kInvalid: nothing does. Targets have one sample then.
  pelage::BufferId depthCopy = pelage::BufferId::kInvalid;
};

/// A frame and what it needs from a canvas.
struct CanvasFrame {
  pelage::Frame* frame = nullptr;
  std::span<const CanvasView> views;  ///< all views of the frame
  ImDrawData* interface = nullptr;
  bool captures = false;  ///< captured() has the picture
};

/// Owns a device. The scene is drawn into a linear target of its own with depth, then put over a
/// backdrop and encoded for the screen, and the interface comes on top.
///
/// Threads: the main one.
class Canvas {
 public:
  virtual ~Canvas() = default;
  Canvas(const Canvas&) = delete;
  Canvas& operator=(const Canvas&) = delete;

  virtual const pelage::DeviceInfo& info() const = 0;
  /// Whether views can be drawn by a method.
  virtual pelage::Result<void> supports(const pelage::TransparencySettings& settings) const = 0;
  /// Makes the runtime again, with code of kernels that goes before the program's own; empty: with
  /// the latter alone. The scene's buffers are lost: Scene::recover() comes next. The code lives as
  /// long as it is used. Errors: those of making a runtime.
  virtual pelage::Result<void> setCode(pelage::KernelCodeList code) = 0;
  /// Makes the targets of the next frames; nothing where they are there. Errors: kUnsupported, with
  /// what the device has, for a number of samples that it has not; the last targets stay then.
  virtual pelage::Result<void> setTarget(const CanvasTarget& target) = 0;
  /// Begins a frame: waits for an earlier one to finish. It comes before Scene::simulate(), and
  /// before the interface is built.
  virtual pelage::Result<void> begin() = 0;
  /// Runs a frame and shows it. Errors: kDeviceLost.
  virtual pelage::Result<void> show(const CanvasFrame& frame) = 0;
  /// The picture of the last frame with `captures`, as the window has it.
  virtual const sample::ByteImage& captured() const = 0;
  /// Reads a buffer back, behind all that has run: Scene::takeSnapshot().
  virtual pelage::Result<std::vector<std::byte>> read(pelage::BufferId buffer) = 0;
  /// GPU times of the newest frame that has finished; empty without timestamps.
  virtual const std::vector<pelage::PassTiming>& timings() const = 0;
  virtual CanvasMemory memory() const = 0;
  /// Validation messages so far.
  virtual uint32_t messageCount() const = 0;
  /// Writes what the driver has compiled into CanvasDef::cache.
  virtual void saveCache() = 0;

 protected:
  Canvas() = default;
};

/// Whether a device has targets with so many samples. Error: kUnsupported, with those that it has.
pelage::Result<void> checkSamples(const pelage::DeviceInfo& info, uint32_t samples);

/// A canvas on a window that was made for its API. The ImGui context exists already. Errors: no
/// device, or one without what it takes; each named.
pelage::Result<std::unique_ptr<Canvas>> createCanvas(const CanvasDef& def, Window& window);
pelage::Result<std::unique_ptr<Canvas>> createVulkanCanvas(const CanvasDef& def, Window& window);
pelage::Result<std::unique_ptr<Canvas>> createGlCanvas(const CanvasDef& def, Window& window);

}  // namespace viewer
