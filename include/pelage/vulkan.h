// Runs pass lists on a Vulkan 1.1 device that the caller owns. The runtime records into the
// caller's command buffers; it never submits, never waits, and needs no extension.
//
// A frame of an engine:
//
//   auto frame = scene.simulate(seconds);              // and frame->draw() for each view
//   runtime.beginFrame(number, completedNumber);       // what the GPU has finished is reused
//   runtime.record(*frame, commands, targets);         // buffers, dispatches, barriers, draws
//   vkQueueSubmit(...);
//   runtime.submitted();                               // else nothing of the frame counts
//
// All entry points of Vulkan are loaded through RuntimeDef::getInstanceProcAddr, so that an engine
// with a loader of its own (volk, a layer, a wrapper) keeps it. This header needs the types of
// <vulkan/vulkan_core.h> only; with volk, define VK_NO_PROTOTYPES for the whole program.
#pragma once

#include <vulkan/vulkan_core.h>

#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <vector>

#include "pelage/export.h"
#include "pelage/frame.h"
#include "pelage/headless.h"
#include "pelage/kernel.h"
#include "pelage/kernel_code.h"
#include "pelage/layout.h"
#include "pelage/pass_list.h"
#include "pelage/result.h"
#include "pelage/scene_features.h"
#include "pelage/spirv.h"
#include "pelage/tier.h"
#include "pelage/transparency.h"

namespace pelage::vulkan {

/// The purpose of a buffer's memory.
enum class MemoryKind : uint8_t {
  kDevice,     ///< device-local; the host does not see it
  kConstants,  ///< mapped, host-coherent, device-local as well where there is such memory
  kStaging,    ///< mapped, host-coherent: source of copies
  kReadback,   ///< mapped, host-coherent, host-cached where there is such memory
};

/// A buffer with its memory bound.
struct AllocatedBuffer {
  VkBuffer buffer = VK_NULL_HANDLE;
  void* mapped = nullptr;      ///< stays mapped; nullptr for kDevice
  void* allocation = nullptr;  ///< the allocator's own
};

/// An engine's own allocator, VMA for instance. Leave `create` null for the runtime's: blocks of
/// 32 MiB, and memory of their own for larger buffers.
struct BufferAllocator {
  void* user = nullptr;  ///< passed back
  /// Makes a buffer, binds memory of the kind to it and fills `out`. `name` is for debuggers.
  VkResult (*create)(void* user, const VkBufferCreateInfo& info, MemoryKind kind, const char* name,
                     AllocatedBuffer& out) = nullptr;
  void (*destroy)(void* user, const AllocatedBuffer& buffer) = nullptr;
};

struct RuntimeDef {
  VkInstance instance = VK_NULL_HANDLE;
  VkPhysicalDevice physicalDevice = VK_NULL_HANDLE;  ///< Vulkan 1.1 or later
  VkDevice device = VK_NULL_HANDLE;
  /// Family of the queue that runs the command buffers: compute, and graphics when there are draws.
  uint32_t queueFamily = 0;
  /// Families of further queues that run some of the command buffers (Runtime::useQueueFamily()):
  /// they compute. Buffers are then made with VK_SHARING_MODE_CONCURRENT for all of these families.
  std::vector<uint32_t> otherQueueFamilies;
  /// The features that the device was created with. A kernel that needs more than this is an error
  /// that names the feature.
  VkPhysicalDeviceFeatures enabledFeatures = {};
  /// Where functions come from; nullptr opens the system's loader (libvulkan.so.1).
  PFN_vkGetInstanceProcAddr getInstanceProcAddr = nullptr;
  /// Must outlive the runtime; nullptr = the driver's.
  const VkAllocationCallbacks* allocationCallbacks = nullptr;
  BufferAllocator allocator;
  /// The engine's pipeline cache; VK_NULL_HANDLE gives the runtime one of its own.
  VkPipelineCache pipelineCache = VK_NULL_HANDLE;
  /// For a cache of its own: what Runtime::pipelineCacheData() gave in an earlier run. Data of
  /// another device or driver version is ignored.
  std::span<const std::byte> pipelineCacheData;
  /// VK_EXT_debug_utils is enabled on the instance: name objects, label passes.
  bool debugUtils = false;
  /// Pipelines that are made at a time, each on a thread; 0: as many as there are processors. The
  /// driver calls allocationCallbacks from these threads.
  uint32_t pipelineThreads = 0;
  /// Frames that may have recorded something and are not known to have completed; 0: any number. A
  /// frame more is refused: an engine that never says what has completed would else use up memory.
  uint32_t maxFramesInFlight = 64;
  /// The device counts as one of at most this tier: kernels that need more are refused. Use it to
  /// test how a program behaves on small devices.
  Tier maxTier = Tier::kWide;
  /// The SPIR-V of all kernels of the lists to come. A program that names its own tables in the
  /// initializer, RuntimeDef{.code = ...}, links those kernels only; `RuntimeDef def;` links all.
  std::vector<KernelCodeList> code = {allSpirv()};
};

/// A buffer of the engine in place of one of the runtime's.
struct ExternalBuffer {
  /// Usage: storage, transfer destination, and index or indirect where the BufferDesc says so. The
  /// engine keeps it alive until the frame after the removal of its id has completed.
  VkBuffer buffer = VK_NULL_HANDLE;
  VkDeviceSize offset = 0;    ///< of the BufferDesc's bytes; a multiple of 4
  bool keepContents = false;  ///< true: update() does not write the BufferDesc's initial data
  /// Bytes from `offset` on that are for this id. VK_WHOLE_SIZE: up to the end of the buffer, which
  /// Vulkan tells the runtime only rounded up to the alignment of its memory.
  VkDeviceSize size = VK_WHOLE_SIZE;
};

/// A texture of the engine, with the sampler that reads it.
struct ExternalTexture {
  /// The view's type is the one that the HLSL declares: VK_IMAGE_VIEW_TYPE_2D_ARRAY for a
  /// Texture2DArray, _CUBE for a TextureCube. A depth image has the aspect
  /// VK_IMAGE_ASPECT_DEPTH_BIT.
  VkImageView view = VK_NULL_HANDLE;
  VkSampler sampler = VK_NULL_HANDLE;  ///< VK_NULL_HANDLE: kernels only load its texels
  /// The image's layout while lists with the texture run.
  VkImageLayout layout = VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL;
};

/// Where a buffer of a ResourceTable lives.
struct BufferRange {
  VkBuffer buffer = VK_NULL_HANDLE;
  VkDeviceSize offset = 0;
  VkDeviceSize size = 0;
};

/// Color attachments behind the first one, at most.
inline constexpr uint32_t kMaxOtherColors = 7;

/// Target of draws. Draws write the first color attachment and the depth, nothing else: stencil
/// and further color attachments (normals, motion vectors) keep what is in them.
struct TargetFormats {
  VkFormat color = VK_FORMAT_R16G16B16A16_SFLOAT;  ///< of the first color attachment
  VkFormat depth =
      VK_FORMAT_D32_SFLOAT;  ///< VK_FORMAT_UNDEFINED: no depth test, whatever a draw says
  VkSampleCountFlagBits samples = VK_SAMPLE_COUNT_1_BIT;
  /// The render pass that the draws run in, or one that is compatible with it. VK_NULL_HANDLE: they
  /// run inside vkCmdBeginRendering (Vulkan 1.3 or VK_KHR_dynamic_rendering, enabled).
  VkRenderPass renderPass = VK_NULL_HANDLE;
  uint32_t subpass = 0;
  /// Dynamic rendering: that of VkRenderingInfo::pStencilAttachment, and then also that of `depth`
  /// where there is one; VK_FORMAT_UNDEFINED without. A render pass knows its own.
  VkFormat stencil = VK_FORMAT_UNDEFINED;
  /// Number of color attachments of the subpass or of VkRenderingInfo behind the first one,
  /// 0..kMaxOtherColors. More than 0 needs the device feature independentBlend.
  uint32_t otherColorCount = 0;
  /// Dynamic rendering: the formats of these; VK_FORMAT_UNDEFINED for one without an image.
  std::array<VkFormat, kMaxOtherColors> otherColors = {};
  bool operator==(const TargetFormats&) const = default;
};

/// Where the draws of a view of a frame go.
struct ViewTarget {
  TargetFormats formats;
  VkRect2D area = {};  ///< the viewport, as View::x, y, width and height have it
  /// Begins the render pass for the draws of a list of the view, and ends it; both are needed. The
  /// first list of the view may clear the target, all others keep what is in it. Called outside of
  /// a render pass.
  std::function<void(const FrameStep& step)> begin;
  std::function<void(const FrameStep& step)> end;
};

/// A command buffer for a queue beside the one that draws.
struct ComputeCommands {
  VkCommandBuffer commands = VK_NULL_HANDLE;
  uint32_t queueFamily = 0;  ///< RuntimeDef::queueFamily or one of otherQueueFamilies
};

/// Device memory that a Runtime uses.
struct MemoryUse {
  uint64_t bufferBytes = 0;  ///< of the table's buffers: Runtime::bufferBytes()
  /// Constants and uploads: those of frames in flight, and those kept for the next ones. Grows with
  /// each frame that is not known to have completed.
  uint64_t frameBytes = 0;
  uint32_t framesInFlight = 0;  ///< that recorded something, and are not known to have completed
};

/// Executes pass lists of one ResourceTable.
///
/// A command buffer that it recorded is to be submitted once, in the frame it was recorded in, and
/// behind those that were recorded before it. What is not submitted is recorded again in a later
/// frame: buffers' contents by update(), lists by their scene. submitted() makes the difference.
///
/// Threads: one thread at a time, which has the command buffer (and its pool) and the tables and
/// lists that it is given to itself. Runtimes share nothing but the device, and may be used on
/// several threads; it calls no function on the queue.
class PELAGE_VULKAN_API Runtime {
 public:
  /// Errors: kInvalidArgument for a missing handle; kUnsupported, naming it, for a function, a
  /// queue capability or a Vulkan version that is not there; kOutOfMemory.
  static Result<Runtime> create(const RuntimeDef& def);

  Runtime(Runtime&&) noexcept;
  Runtime& operator=(Runtime&&) noexcept;
  /// Destroys everything at once: the device must have finished the frames that were recorded.
  ~Runtime();

  /// Adds tables to RuntimeDef::code: of an engine's own kernels, say.
  void addCode(KernelCodeList code);

  /// Starts a frame: numbers rise, from 1. All frames up to `completedFrame` are known to have
  /// finished on the device (their fences were signalled); what they used is reused or destroyed.
  /// RuntimeDef::maxFramesInFlight may be in flight; where they are, update(), record() and
  /// recordDraws() refuse another one, until this or collect() says that some have completed. What
  /// was recorded without submitted() counts as lost. Asserts that frame numbers rise.
  void beginFrame(uint64_t frame, uint64_t completedFrame);
  /// Says that all that was recorded since beginFrame() was submitted, or is sure to be: call it
  /// once vkQueueSubmit() has succeeded, or when another thread has taken the command buffers over.
  /// Without it the frame has not run as far as scenes know, and hair stays in its bind shape.
  void submitted();
  /// Says that what was recorded without submitted() is not going to be submitted. The next
  /// beginFrame() does so, too: call this where Scene::simulate() or finish() may come before that.
  void abandonFrame();
  /// Takes note that frames have finished without starting another one.
  void collect(uint64_t completedFrame);

  /// Makes update() use a buffer of the engine for this id. Call it before the update() that sees
  /// the id first. A second call replaces the first. Asserts on an id that already has a buffer,
  /// and on a null buffer, which changes nothing. update() refuses a buffer that is smaller than
  /// the BufferDesc, by its name.
  void registerBuffer(BufferId id, const ExternalBuffer& buffer);

  /// Says what a texture of newTextureId() is in lists that are recorded from now on; a second call
  /// replaces it, and one without a view forgets it. The engine keeps view and sampler alive until
  /// the frames that used them have completed, and makes the image ready for shaders itself: its
  /// layout, and a barrier behind what wrote it.
  void registerTexture(TextureId id, const ExternalTexture& texture);

  /// Creates the table's new buffers in device memory and records their initial data (or zeros)
  /// with a barrier behind it; removed buffers are destroyed once this frame has completed. Outside
  /// a render pass. On an error nothing was recorded or created. Errors: kOutOfMemory;
  /// kInvalidArgument for an ExternalBuffer that is too small. They name the buffer.
  Result<void> update(const ResourceTable& resources, VkCommandBuffer commands);

  /// The most capable tier that the device has everything of, but not above RuntimeDef::maxTier:
  /// for Scene::setTier() and SceneFeatures.
  Tier tier() const;

  /// Whether the device has what a list needs, without making a pipeline: storage buffers of each
  /// stage, threads, features. For a list that is to run, or that listToPrepare() makes. Errors:
  /// kUnsupported, with the kernel and what is missing; a list that checkPasses() refuses.
  Result<void> supports(const PassList& list) const;
  /// Whether views can be drawn by a transparency method, with Scene::setTier(tier()): what
  /// record() would refuse is known before the first frame. Sizes of buffers are not looked at.
  ///
  ///     if (!runtime.supports({.method = Transparency::kTiles})) method = Transparency::kWindowed;
  ///
  /// \param hair  the features of the hair that is drawn. Errors: as above; those of
  /// planTransparency().
  Result<void> supports(const TransparencySettings& settings, const DrawnFeatures& hair = {}) const;

  /// Makes the pipelines of a list ahead of its first frame, several at a time: of one that is to
  /// run, or of listToPrepare(). Its buffers need not exist. With a target: those of its draws too.
  /// Without it, record() and recordDraws() do so when a list needs one.
  Result<void> prepare(const PassList& list, const TargetFormats* target = nullptr);

  /// Records uploads and dispatches with the list's barriers, and those in front of its draws.
  /// Outside a render pass. Leaves the command buffer's compute state changed. The whole list is
  /// checked first: on an error nothing was recorded. Errors name the pass and the resource. A
  /// frame may have several lists: each goes through here and recordDraws() before the next one.
  Result<void> record(const PassList& list, VkCommandBuffer commands);

  /// Records the list's draws, inside the caller's render pass; record() comes before. Sets
  /// viewport and scissor to `area` with a negative height: clip space has y up, row 0 is the top.
  /// Leaves them changed, and the pipeline, descriptor sets, vertex and index buffer of graphics.
  Result<void> recordDraws(const PassList& list, VkCommandBuffer commands,
                           const TargetFormats& target, const VkRect2D& area);

  /// Records a frame: update(), then record() and recordDraws() of its lists, with the render
  /// passes of the engine around the draws. \param targets  one for each view of the frame. Errors:
  /// those of the calls; another number of targets, one without begin or end, an area or samples
  /// that are not the View's, before anything is recorded.
  Result<void> record(Frame& frame, VkCommandBuffer commands,
                      std::span<const ViewTarget> targets = {});
  /// The same for two queues: update() and what comes before the first view (simulation, shadow
  /// maps of castShadows(), lists of yours) goes into `compute`, the rest into `commands`, which
  /// are of RuntimeDef::queueFamily. The engine orders the queues with semaphores: `commands` wait
  /// for `compute` of the same frame, and `compute` waits for `commands` of the frame before, both
  /// at VK_PIPELINE_STAGE_ALL_COMMANDS_BIT. Errors: those above, and of useQueueFamily().
  Result<void> record(Frame& frame, const ComputeCommands& compute, VkCommandBuffer commands,
                      std::span<const ViewTarget> targets = {});

  /// Says of which family the command buffers of the next calls are; at first
  /// RuntimeDef::queueFamily. On a family that only computes, barriers leave out what draws do:
  /// semaphores order queues, as record() for two of them says. Errors: kInvalidArgument for a
  /// family that RuntimeDef does not name; nothing has changed then.
  Result<void> useQueueFamily(uint32_t family);

  /// The layout manager of the generated Create*Layout templates: makes the descriptor set layout
  /// of a table when it is first asked for. Uniform buffers are dynamic ones. The runtime owns it.
  /// `table` must have static lifetime, as the generated ones have.
  Result<VkDescriptorSetLayout> createLayout(const LayoutTable& table);

  /// The buffer behind an id, for an engine that reads it itself; empty when there is none.
  BufferRange buffer(BufferId id) const;
  /// Bytes of the buffers that update() has made and that are not destroyed yet: those that were
  /// removed count until their frame is known to have finished. Without what the engine owns.
  uint64_t bufferBytes() const;
  /// All that it has allocated, apart from pipelines and descriptor sets.
  MemoryUse memoryUse() const;

  /// Drops the pipelines made for a render pass that is about to be destroyed; its frames must have
  /// completed.
  void forget(VkRenderPass renderPass);

  /// Whether lists recorded from now on measure each pass; off by default.
  void setTimestamps(bool enabled);
  /// Times of a completed frame in the order of recording: one entry a recorded pass, negative when
  /// the queue family has no timestamps. They are kept for the 8 newest completed frames. Draws
  /// are timed for the first recordDraws() of a list after its record(). Empty when nothing was
  /// measured.
  std::vector<PassTiming> timings(uint64_t frame) const;

  /// The time that each pipeline took, in the order in which they were made.
  std::vector<PipelineTime> pipelineTimes() const;

  /// Contents of the pipeline cache, to be stored for the next run.
  Result<std::vector<std::byte>> pipelineCacheData() const;

 private:
  struct Impl;
  explicit Runtime(std::unique_ptr<Impl> impl);
  Result<void> recordFrame(Frame& frame, const ComputeCommands& before,
                           const ComputeCommands& views, std::span<const ViewTarget> targets);
  std::unique_ptr<Impl> impl_;
};

}  // namespace pelage::vulkan
