// A device without a window, for samples, tests and benchmarks: it makes its own Vulkan device or
// EGL context, runs pass lists, waits, and reads results back. An engine has no need of it: it
// records with pelage/vulkan.h or pelage/gl.h on a device of its own.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "pelage/export.h"
#include "pelage/frame.h"
#include "pelage/kernel_code.h"
#include "pelage/pass_list.h"
#include "pelage/result.h"
#include "pelage/scene_features.h"
#include "pelage/tier.h"
#include "pelage/transparency.h"
#include "pelage/types.h"

namespace pelage {

enum class Api : uint8_t {
  kVulkan,  ///< Vulkan 1.1 or later
  kGl,      ///< OpenGL core 4.5 through EGL
  kGles,    ///< OpenGL ES 3.2 through EGL
};

/// "vulkan", "gl" or "gles".
PELAGE_API const char* apiName(Api api);

struct HeadlessDef {
  Api api = Api::kVulkan;
  /// Vulkan: the Khronos validation layer with synchronisation validation. GL: a debug context.
  /// Messages are counted and printed to stderr. An error when it is asked for and not there.
  bool validation = false;
  /// Selects one of several devices, in the driver's order; -1 takes a discrete GPU, else an
  /// integrated one, else a software driver.
  int deviceIndex = -1;
  /// Vulkan: the device with this UUID, in place of an index: 32 hexadecimal digits, as
  /// DeviceInfo::uuid has them or with '-' between them; "GPU-" before them, as nvidia-smi writes
  /// it, is left out. Empty: by the index. An error with OpenGL, whose devices have none.
  std::string deviceUuid = {};
  /// The device counts as one of at most this tier; see RuntimeDef::maxTier.
  Tier maxTier = Tier::kWide;
  /// Vulkan: queues that the devices of HeadlessDevice::another() take in turn, so that a GPU can
  /// run work of several at the same time; no more than its queue family has. 0 counts as 1.
  uint32_t queues = 1;
};

struct DeviceInfo {
  Api api = Api::kVulkan;
  std::string name;         ///< of the GPU
  std::string driver;       ///< with its version
  std::string version;      ///< of the API: "1.3.230", "4.5 (Core Profile)"
  std::string uuid;         ///< Vulkan: 32 hexadecimal digits; else empty
  bool software = false;    ///< runs on the CPU (lavapipe, llvmpipe)
  uint32_t maxSamples = 1;  ///< of a 16-bit float colour target with a depth target
  /// The sample counts that such a target can have, as a sum of 1, 2, 4 and 8.
  uint32_t sampleCounts = 1;
  uint64_t maxBufferBytes = 0;  ///< that a kernel can have bound of one storage buffer
  Tier tier = Tier::kWide;      ///< for Scene::setTier()
};

/// GPU time of one pass.
/// The passes of a level run at the same time, and each has an equal part of the level's time
/// (HazardTracker::setLevels(false) gives each pass a level).
struct PassTiming {
  const char* name = "";
  double milliseconds = 0;
};

/// Target of render(): 16-bit float colour (linear, RGBA; 32-bit with float32Color) and 32-bit
/// float depth, cleared first.
struct RenderTargetDef {
  uint32_t width = 0, height = 0;  ///< pixels, 1..16384
  uint32_t samples = 1;            ///< one of DeviceInfo::sampleCounts
  Float4 clearColor = {0, 0, 0, 0};
  float clearDepth = 1;  ///< 1 for standard depth, 0 for reversed depth
  /// Receives the depth of the drawn area, after the draws of list number `depthCopyAfter` and
  /// before the next list: a float a pixel in 0..1 as the kernels see them, row 0 is the top row.
  /// It stands for the depth texture of an engine. The target has one sample then.
  BufferId depthCopy = BufferId::kInvalid;
  uint32_t depthCopyAfter = 0;  ///< index of the list
  /// The viewport: what is drawn to of the target, as View::x, y, width and height have it. All of
  /// the target where it has no pixels. All of the target is cleared.
  PixelArea area = {};
  /// 32-bit float color, for values that are no colors: depth, motion. Some devices lack it with
  /// several samples a pixel, which is an error of render() then.
  bool float32Color = false;
};

enum class TextureShape : uint8_t {
  kArray,  ///< layers of two dimensions: Texture2DArray
  kCube,   ///< six square layers: +x, -x, +y, -y, +z, -z, as in every API: TextureCube
  kPlane,  ///< one layer of two dimensions: Texture2D
};

/// A texture that is written once.
struct TextureDef {
  TextureShape shape = TextureShape::kArray;
  uint32_t width = 0, height = 0;  ///< texels, 1..2048
  uint32_t layers = 1;             ///< 1..256; 6 of a cube, 1 of a plane
  /// 1 or more of a plane, each half as wide and high as the one before, rounded down, and at least
  /// 1; with 4 channels the sampler interpolates between them. 1 of others.
  uint32_t mipLevels = 1;
  /// 1: 32-bit floats, of which the sampler takes the nearest, at the edge beyond 0..1; for depth.
  /// 4: 16-bit floats, which it interpolates linearly; for light. Planes repeat beyond 0..1.
  uint32_t channels = 4;
  /// [mip level][layer][row][column][channel]; row 0 is at v = 0
  std::span<const float> texels = {};
};

/// The result of render(); row 0 is the top row on every API.
struct RenderedImage {
  uint32_t width = 0, height = 0;
  std::vector<Float4> pixels;  ///< width * height, linear, samples averaged
};

/// A device without a window, for samples and tests. It keeps the buffers of one ResourceTable: use
/// another device for another Scene.
///
/// Threads: one thread at a time, and for OpenGL the thread that made it. Two devices may be made
/// and used on two threads, also where one is HeadlessDevice::another() of the other.
class PELAGE_API HeadlessDevice {
 public:
  virtual ~HeadlessDevice() = default;
  HeadlessDevice(const HeadlessDevice&) = delete;
  HeadlessDevice& operator=(const HeadlessDevice&) = delete;

  virtual const DeviceInfo& info() const = 0;
  /// Vulkan: makes a device for another Scene, which shares instance, VkDevice, queues and the
  /// pipelines' cache with this one; either may be destroyed first. Threads: any. Errors:
  /// kUnsupported for OpenGL, where createHeadlessGl() makes another one; those of the device.
  virtual Result<std::unique_ptr<HeadlessDevice>> another() const;
  /// Vulkan: time in which the GPU had work of at least one device that shares it, from submission
  /// to the end of the wait [s]. 0 for OpenGL. Threads: any.
  virtual double busySeconds() const { return 0; }
  /// Whether the device can run all passes of a list; as the runtimes' supports(), with their
  /// errors.
  virtual Result<void> supports(const PassList& list) const = 0;
  /// Whether it can draw views by a method.
  Result<void> supports(const TransparencySettings& settings, const DrawnFeatures& hair = {}) const;
  /// Adds the code of kernels that are not pelage's own, which the device knows.
  virtual void addCode(KernelCodeList code) = 0;
  /// Creates the table's new buffers with their initial data and frees those that were removed.
  virtual Result<void> update(const ResourceTable& resources) = 0;
  /// Makes a texture, which lives as long as the device, and registers it with the runtime. Errors:
  /// a size that is not as TextureDef says; those of the device.
  virtual Result<TextureId> createTexture(const TextureDef& texture) = 0;
  /// Runs uploads and dispatches and waits for them. `timings`, when given, receives one entry a
  /// pass; an entry of a device without timestamps is negative.
  virtual Result<void> execute(const PassList& list,
                               std::vector<PassTiming>* timings = nullptr) = 0;
  /// Clears the target once and runs the lists one after the other, the draws of each into what the
  /// earlier ones have drawn; waits and reads the colours back.
  virtual Result<RenderedImage> render(std::span<const PassList* const> lists,
                                       const RenderTargetDef& target,
                                       std::vector<PassTiming>* timings = nullptr) = 0;
  /// The same with one list.
  Result<RenderedImage> render(const PassList& list, const RenderTargetDef& target,
                               std::vector<PassTiming>* timings = nullptr) {
    const PassList* const lists[] = {&list};
    return render(lists, target, timings);
  }
  /// Runs a frame without views: update(), then execute() of its lists. Errors: those, and a frame
  /// that has views.
  Result<void> run(Frame& frame, std::vector<PassTiming>* timings = nullptr);
  /// Runs a frame with views. \param targets  one for each view; the images come in the same order.
  Result<std::vector<RenderedImage>> render(Frame& frame, std::span<const RenderTargetDef> targets,
                                            std::vector<PassTiming>* timings = nullptr);
  /// Reads a buffer back; size 0 reads from the offset to the end.
  virtual Result<std::vector<std::byte>> read(BufferId buffer, uint64_t offset = 0,
                                              uint64_t size = 0) = 0;
  /// Bytes of the tables' buffers that the device holds now; those that were removed count until
  /// the GPU has done with them.
  virtual uint64_t bufferBytes() const = 0;
  /// Validation or debug messages of at least warning severity so far, of all devices that share
  /// it.
  virtual uint32_t messageCount() const = 0;

 protected:
  HeadlessDevice() = default;
  /// RenderTargetDef::area, or all of the target. Error: it leaves the target.
  static Result<PixelArea> drawArea(const RenderTargetDef& target);
  /// The texels as the device takes them. Error: one of createTexture()'s.
  static Result<std::vector<std::byte>> textureBytes(const TextureDef& texture);
  /// Width or height of a mip level [texels].
  static uint32_t sizeOfLevel(uint32_t size, uint32_t level) { return std::max(size >> level, 1u); }
  /// Whether RenderTargetDef::depthCopy can be done; `bytes` of the buffer, 0 when there is none.
  static Result<void> checkDepthCopy(const RenderTargetDef& target, size_t lists, uint64_t bytes);
};

/// In pelage::vulkan. Errors: no loader, no device, a missing feature; each named.
PELAGE_VULKAN_API Result<std::unique_ptr<HeadlessDevice>> createHeadlessVulkan(
    const HeadlessDef& def);
/// In pelage::gl, for Api::kGl and Api::kGles.
PELAGE_GL_API Result<std::unique_ptr<HeadlessDevice>> createHeadlessGl(const HeadlessDef& def);

}  // namespace pelage
