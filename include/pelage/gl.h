// Runs pass lists with OpenGL core 4.5 or OpenGL ES 3.2, on a context that the caller owns. The
// same code serves both; which one it is, is read from the context. No GL library is linked:
// every function is loaded through the caller's getProcAddress.
//
// All calls, the destructors included, need the context current that was current at create(): they
// come from the thread that has it.
//
// The pictures' convention: row 0 of the framebuffer is the top row of the picture, and depth runs
// from 0 to 1 as in HLSL (kernels are translated that way). An engine whose framebuffers have the
// bottom row first draws into a texture of its own and flips it when it samples it.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "pelage/essl.h"
#include "pelage/export.h"
#include "pelage/frame.h"
#include "pelage/glsl.h"
#include "pelage/headless.h"
#include "pelage/kernel.h"
#include "pelage/kernel_code.h"
#include "pelage/pass_list.h"
#include "pelage/result.h"
#include "pelage/scene_features.h"
#include "pelage/tier.h"
#include "pelage/transparency.h"

namespace pelage::gl {

/// Indexed buffer bindings (GL_SHADER_STORAGE_BUFFER, GL_UNIFORM_BUFFER) that pelage may use:
/// 0..kMaxBindings-1. StateGuard saves these.
inline constexpr uint32_t kMaxBindings = 16;

enum class Profile : uint8_t {
  kCore,  ///< OpenGL 4.5 core or later
  kEs,    ///< OpenGL ES 3.2 or later
};

/// Keeps linked programs between runs. The key covers the driver's strings and the whole source,
/// so that another driver or kernel asks for another entry. Either function may be empty.
struct ProgramCache {
  /// The bytes stored under the key; empty when there are none. They may be anything: what is
  /// truncated, corrupt or refused by the driver is compiled again.
  std::function<std::vector<std::byte>(uint64_t key)> load;
  std::function<void(uint64_t key, std::span<const std::byte> bytes)> store;
};

/// A ProgramCache of one file a program in a directory, which is created when it is missing. A
/// directory that cannot be written is no error: programs are compiled then.
PELAGE_GL_API ProgramCache directoryProgramCache(std::string directory);

struct RuntimeDef {
  /// Address of a GL function in the current context: eglGetProcAddress, glXGetProcAddress,
  /// SDL_GL_GetProcAddress. Must know the core functions too.
  std::function<void*(const char* name)> getProcAddress;
  ProgramCache programCache;
  /// Names every object and pass for debuggers (KHR_debug), and checks glGetError after every
  /// recording. Costs a synchronisation with the driver a call.
  bool debug = false;
  /// The context counts as one of at most this tier: Limits are no more than its own, and kernels
  /// that need more are refused. Use it to test how a program behaves on small devices.
  Tier maxTier = Tier::kWide;
  /// The sources of all kernels of the lists to come; OpenGL reads the GLSL, OpenGL ES the ESSL. A
  /// program that names its own tables in the initializer, RuntimeDef{.code = ...}, links those
  /// kernels only; `RuntimeDef def;` links all.
  std::vector<KernelCodeList> code = {allGlsl(), allEssl()};
};

/// Limits of the context; read once in create().
struct Limits {
  uint32_t storageBindings = 0, uniformBindings = 0;  ///< binding points of the context
  uint32_t computeStorageBlocks = 0, vertexStorageBlocks = 0, pixelStorageBlocks = 0;
  uint32_t combinedStorageBlocks = 0;  ///< vertex and pixel stage together
  uint32_t groupCount[3] = {0, 0, 0};  ///< work groups of a dispatch on each axis
  uint32_t groupSize[3] = {0, 0, 0};   ///< threads of a work group on each axis
  uint32_t groupThreads = 0;           ///< threads of a work group
  uint64_t uniformBlockBytes = 0, storageBlockBytes = 0;
  uint32_t uniformAlignment = 0, storageAlignment = 0;  ///< of the offset of a binding [bytes]
  bool timestamps = false;       ///< PassTimer measures; otherwise its times are negative
  bool programBinaries = false;  ///< the driver hands out binaries for the ProgramCache
};

/// Totals since a Runtime was created.
struct Statistics {
  uint32_t programsCompiled = 0;  ///< from source
  uint32_t programsLoaded = 0;    ///< from the ProgramCache
  uint64_t bufferBytes = 0;       ///< of the buffers that it owns now
};

/// Texture units that pelage may use, with their samplers: 0..kMaxTextures-1.
inline constexpr uint32_t kMaxTextures = 16;

/// A texture of the engine, with the sampler that reads it.
struct ExternalTexture {
  uint32_t target = 0;   ///< GL_TEXTURE_2D, GL_TEXTURE_2D_ARRAY, GL_TEXTURE_CUBE_MAP, ...
  uint32_t name = 0;     ///< of glGenTextures(); 0: none
  uint32_t sampler = 0;  ///< of glGenSamplers(); 0: as the texture's own parameters say
};

/// The result of createLayout() for a table: GL has no descriptor sets, so it is the table's
/// binding slots. Owned by the runtime.
struct Layout {
  const LayoutTable* table = nullptr;
  struct Slot {
    uint32_t target = 0;  ///< GL_UNIFORM_BUFFER or GL_SHADER_STORAGE_BUFFER; 0: no buffer
    /// For glBindBufferRange, of a texture its unit; 0 for storage buffers, which each permutation
    /// numbers for itself (VariantBinding::glBinding).
    uint32_t binding = 0;
  };
  std::vector<Slot> slots;  ///< [entry of the table]
};

/// A member of a block as the driver lays it out.
struct DriverMember {
  std::string name;                  ///< as the driver writes it: "RenderConstants.g_eye"
  uint32_t offset = 0;               ///< [bytes]; of the first element where it is an array
  uint32_t type = 0;                 ///< GL_FLOAT_VEC4 and so on
  uint32_t arraySize = 0;            ///< elements; 0 = of the block's length, 1 = no array
  uint32_t arrayStride = 0;          ///< [bytes]; 0 = no array
  uint32_t topLevelArraySize = 0;    ///< buffer variables only; 0 = of the block's length
  uint32_t topLevelArrayStride = 0;  ///< [bytes] an element of the buffer
};

/// A uniform block, a shader storage block or a texture as the driver sees it.
struct DriverBlock {
  std::string name;
  ResourceKind kind = ResourceKind::kUniformBuffer;  ///< or kStorageBuffer, kSampledTexture
  uint32_t binding = 0;                              ///< of a texture: its unit
  uint32_t dataSize = 0;  ///< [bytes]; with one element of an array of the block's length
  std::vector<DriverMember> members;  ///< ascending by offset
};

/// The part of the bound framebuffer that is drawn to [pixels]; row 0 is the top row.
struct DrawTarget {
  uint32_t x = 0, y = 0;
  uint32_t width = 0, height = 0;  ///< 1 or more, at most GL_MAX_VIEWPORT_DIMS
};

/// Where the draws of a view of a frame go.
struct ViewTarget {
  DrawTarget area;  ///< the viewport, as View::x, y, width and height have it
  /// Binds the framebuffer, before the draws of each list of the view. The first list of the view
  /// may clear it, all others keep what is in it.
  std::function<void(const FrameStep& step)> begin;
};

/// The bits for glMemoryBarrier that GL needs for some barriers of a pass list; 0: none. Only what
/// a shader wrote, or a shader writes next, needs one: GL itself orders uploads (glBufferSubData,
/// glBufferData) and reads of indices and indirect arguments after every earlier API write, and
/// uploads after every earlier read (OpenGL 4.5, 7.12.2; OpenGL ES 3.2, 7.11.2).
PELAGE_GL_API uint32_t memoryBarrierBits(std::span<const Barrier> barriers);

class PassTimer;
class StateGuard;

/// Buffers, programs and recording for one context.
///
/// Errors are found before anything is issued: a list that is refused has done nothing. The message
/// names the pass and the resource. Kernel variants are remembered by address and must outlive the
/// runtime (generated tables are static).
///
/// The functions clear GL's error flag and leave none behind. They change the state that StateGuard
/// lists and restore none of it.
///
/// Threads: the one that has the context current. Runtimes on two contexts may be used on two
/// threads, several on one context from one.
class PELAGE_GL_API Runtime {
 public:
  /// Needs a current context. kUnsupported names what the context lacks: its version, a function,
  /// storage buffer bindings, an offset alignment.
  static Result<Runtime> create(RuntimeDef def);

  Runtime(Runtime&&) noexcept;
  Runtime& operator=(Runtime&&) noexcept;
  ~Runtime();

  /// Adds tables to RuntimeDef::code: of an engine's own kernels, say.
  void addCode(KernelCodeList code);

  Profile profile() const;
  const Limits& limits() const;
  const Statistics& statistics() const;

  /// Creates the table's new buffers with their initial data, or zeros, and frees those that were
  /// removed. One runtime serves one table. kOutOfMemory names the buffer.
  Result<void> update(const ResourceTable& resources);

  /// Uses the engine's buffer for an id: update() then neither creates, fills nor frees it. Call it
  /// before update(), or later to replace a buffer. The engine keeps it alive and at least as large
  /// as the table says (checked when it is used). Its initial data is the engine's business.
  Result<void> registerBuffer(BufferId id, uint32_t glName);

  /// Says what a texture of newTextureId() is in lists that are recorded from now on; a second call
  /// replaces it, and one without a name forgets it. The engine keeps texture and sampler alive as
  /// long as lists with the id are recorded, and puts a glMemoryBarrier() behind its own image
  /// stores, if it writes the texture so. Lists with textures change the active texture unit and
  /// what is bound to units and samplers 0..kMaxTextures-1.
  void registerTexture(TextureId id, const ExternalTexture& texture);

  /// The GL name of a buffer; 0 when there is none.
  uint32_t bufferName(BufferId id) const;

  /// The slots of a layout, made when they are first asked for; record() asks for those that it
  /// needs. kUnsupported when a binding point is beyond the context's.
  Result<const Layout*> createLayout(const LayoutTable& table);

  /// The most capable tier that the context has everything of, but not above RuntimeDef::maxTier:
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

  /// Makes the programs of a list, without running it: while loading, with listToPrepare(). Its
  /// buffers need not exist. Drivers with GL_KHR_parallel_shader_compile make several at a time.
  Result<void> prepare(const PassList& list);

  /// Issues the list's uploads and dispatches; its draws are left out.
  Result<void> record(const PassList& list, PassTimer* timer = nullptr);

  /// Issues the list's draws into the framebuffer that the caller has bound. Follows record() of
  /// the same list.
  Result<void> recordDraws(const PassList& list, const DrawTarget& target,
                           PassTimer* timer = nullptr);

  /// Runs a frame: update(), then record() and recordDraws() of its lists. \param targets  one for
  /// each view of the frame. Errors: those of the calls; another number of targets, or an area that
  /// is not the View's, before anything is issued.
  Result<void> record(Frame& frame, std::span<const ViewTarget> targets = {});

  /// The time that each program took, in the order in which they were done.
  std::vector<PipelineTime> pipelineTimes() const;

  /// Waits for the GPU and reads a buffer; size 0 reads from the offset to the end.
  Result<std::vector<std::byte>> read(BufferId id, uint64_t offset = 0, uint64_t size = 0);

  /// The blocks of a variant as the driver lays them out (glGetProgramResourceiv), and its
  /// textures, ascending by kind and binding. Storage images are left out.
  Result<std::vector<DriverBlock>> reflectProgram(const KernelVariant& variant);

 private:
  friend class PassTimer;
  friend class StateGuard;
  struct Impl;
  explicit Runtime(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

/// GPU times of recorded passes. Results come when the GPU gets there: an engine keeps two or three
/// timers and reads the oldest.
///
/// Threads: as its Runtime.
class PELAGE_GL_API PassTimer {
 public:
  explicit PassTimer(const Runtime& runtime);
  PassTimer(PassTimer&&) noexcept;
  PassTimer& operator=(PassTimer&&) noexcept;
  ~PassTimer();

  /// True when read() would not wait.
  bool ready() const;
  /// One entry for each pass that was recorded with this timer since the last read(), in order;
  /// waits where it has to. Negative where the context has no timestamps (OpenGL ES without
  /// GL_EXT_disjoint_timer_query) or the GPU's clock jumped in between.
  std::vector<PassTiming> read();

 private:
  friend class Runtime;
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

/// Saves, for its lifetime, the GL state that a Runtime changes:
///  - always: current program; indexed bindings 0..kMaxBindings-1 and the generic binding of
///    GL_UNIFORM_BUFFER and GL_SHADER_STORAGE_BUFFER; GL_COPY_READ_BUFFER, GL_COPY_WRITE_BUFFER,
///    GL_DISPATCH_INDIRECT_BUFFER, GL_DRAW_INDIRECT_BUFFER
///  - where a texture is registered: the active texture unit; what units 0..kMaxTextures-1 have of
///    the registered targets, and their samplers
///  - of recordDraws(): vertex array; viewport and depth range 0; scissor test 0; clip control and
///    polygon mode (core); depth test, function, mask; blending and colour mask of every draw
///    buffer; stencil test, face culling, polygon offset, rasterizer discard, primitive restart,
///    alpha to coverage, sample coverage and mask; depth clamp, logic operation, sRGB and
///    multisampling are left as they are.
/// It costs some hundred queries; an engine that sets its own state before each pass has no need
/// of it.
///
/// Threads: as its Runtime.
class PELAGE_GL_API StateGuard {
 public:
  explicit StateGuard(const Runtime& runtime);
  ~StateGuard();
  StateGuard(const StateGuard&) = delete;
  StateGuard& operator=(const StateGuard&) = delete;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace pelage::gl
