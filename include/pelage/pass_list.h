// The pass list: what a frame asks of a GPU, as plain data. The core writes it, a runtime (or an
// engine's own executor) loops over it. It names no graphics API.
#pragma once

#include <concepts>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <ranges>
#include <span>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include "pelage/binding.h"
#include "pelage/export.h"
#include "pelage/host_allocator.h"
#include "pelage/kernel.h"
#include "pelage/result.h"

namespace pelage {

namespace detail {
struct ListHold;
struct ListRun;
struct ListSchedule;
struct RunOrder;
struct RunRecord;
}  // namespace detail

/// The state of a PassList's run; shared by its copies and its executor.
using RunHandle = std::shared_ptr<detail::ListRun>;

/// Names a runtime, or an executor of your own: the one whose buffers have the results of lists.
/// See checkRun().
enum class ExecutorId : uint64_t { kUnknown = 0 };
/// A new id, from any thread.
PELAGE_API ExecutorId newExecutorId();

/// The uses of a buffer; a bit set.
enum class BufferUsage : uint8_t {
  kStorage = 1,    ///< shader storage buffer
  kIndex = 2,      ///< uint32 indices of a draw
  kIndirect = 4,   ///< arguments of an indirect dispatch or draw
  kUpload = 8,     ///< written by the host from a pass list (PassList::uploads)
  kReadback = 16,  ///< read by the host
  kVertex = 32,    ///< inputs of vertex kernels (Pass::vertices)
};
constexpr BufferUsage operator|(BufferUsage a, BufferUsage b) {
  return static_cast<BufferUsage>(static_cast<uint8_t>(a) | static_cast<uint8_t>(b));
}
constexpr bool contains(BufferUsage set, BufferUsage bit) {
  return (static_cast<uint8_t>(set) & static_cast<uint8_t>(bit)) != 0;
}

/// Contents of a buffer. Takes those of a std::vector, too, with a copy.
struct BufferContents : HostArray<std::byte> {
  using HostArray<std::byte>::HostArray;
  BufferContents() = default;
  BufferContents(HostArray<std::byte> bytes) : HostArray<std::byte>(std::move(bytes)) {}
  BufferContents(const std::vector<std::byte>& bytes)
      : HostArray<std::byte>(bytes.begin(), bytes.end()) {}
};

/// A buffer that a runtime is to create.
struct BufferDesc {
  std::string name;     ///< for debuggers and error messages: "mohawk/positions"
  uint64_t size = 0;    ///< bytes, > 0, a multiple of 4
  uint32_t stride = 0;  ///< bytes an element
  BufferUsage usage = BufferUsage::kStorage;
  BufferContents initial = {};  ///< empty: zero-filled; else exactly `size` bytes
};

/// The buffers of a scene. An id is given once, so that a runtime notices what is new and what is
/// gone by looking at the ids alone. The slots of the table that they stand for are used again:
/// its size is that of the most buffers there were at a time.
///
/// Threads: as a standard container: several may read while none writes. The ids of tables are
/// given on any thread.
class PELAGE_API ResourceTable {
 public:
  /// Registers a buffer and returns its id. Asserts on size 0, a size that is not a multiple of 4,
  /// or initial data of another size.
  BufferId add(BufferDesc desc);
  /// Registers a buffer with these values in it, which give size, stride and contents. Asserts
  /// as above.
  template <std::ranges::contiguous_range Values>
  BufferId add(std::string name, const Values& values, BufferUsage usage = BufferUsage::kStorage) {
    const auto bytes = std::as_bytes(std::span(values));
    return add({.name = std::move(name),
                .size = bytes.size(),
                .stride = sizeof(*std::ranges::data(values)),
                .usage = usage,
                .initial = {bytes.begin(), bytes.end()}});
  }
  /// Replaces the initial data of a buffer, for runtimes that make it from now on. Asserts on bytes
  /// of another size, and on an id of none.
  void setInitial(BufferId id, std::span<const std::byte> bytes);
  /// Forgets a buffer; its id stays invalid from now on.
  void remove(BufferId id);
  /// nullptr when the id was removed or never existed.
  const BufferDesc* find(BufferId id) const;
  /// All of a buffer; empty when the id was removed or never existed.
  BufferRange whole(BufferId id) const;
  /// Number of slots: iterate 0..end() and find(at()) each.
  uint32_t end() const { return static_cast<uint32_t>(buffers_.size()); }
  /// The id of the buffer in a slot; kInvalid where there is none.
  BufferId at(uint32_t slot) const;
  /// The slot of an id, for arrays beside the table.
  static constexpr uint32_t indexOf(BufferId id) {
    return (static_cast<uint32_t>(id) - 1) & (kMaxBuffers - 1);
  }
  /// Buffers that there can be at a time.
  static constexpr uint32_t kMaxBuffers = 1u << 20;
  /// Sum of the sizes of the live buffers in bytes.
  uint64_t totalBytes() const;
  /// Number of live buffers.
  uint32_t count() const;
  /// Changes whenever a buffer is added or removed: it rises.
  uint64_t version() const { return version_; }
  /// The value of version() right after this buffer was added; 0 if it is not in the table.
  uint64_t versionOf(BufferId id) const;
  /// Names the table for as long as the program runs, > 0. A copy is another table.
  uint64_t id() const { return id_.value; }

 private:
  struct Slot {
    BufferDesc desc;
    bool live = false;
    uint32_t generation = 0;  ///< buffers that were here before: the upper bits of the id
    uint64_t version = 0;     ///< when it was added
  };
  struct PELAGE_API Id {
    Id();
    Id(const Id& other) : Id() { owner = other.owner; }
    Id(Id&& other) noexcept;
    Id& operator=(const Id&);
    Id& operator=(Id&& other) noexcept;
    ~Id() = default;
    uint64_t value;
    uint32_t owner;  ///< upper half of the ids of its buffers, those of copies too
  };
  BufferId idOf(uint32_t tableIndex, uint32_t generation) const;
  HostArray<Slot> buffers_;
  HostArray<uint32_t> free_;  ///< slots
  uint64_t version_ = 0;
  Id id_;
};

/// Returns an id that no other texture of the program has. A texture belongs to the engine, which
/// tells the runtime what it is: vulkan::Runtime::registerTexture(),
/// gl::Runtime::registerTexture(). It is not in a ResourceTable, and lists have no barriers for it.
/// May be called on any thread.
PELAGE_API TextureId newTextureId();

/// A resource of a pass by the name that it has in HLSL: one of the four is set.
struct NamedResource {
  std::string name = {};
  BufferRange buffer = {};                  ///< a storage buffer
  TextureId texture = TextureId::kInvalid;  ///< a texture; under another name its sampler
  std::vector<std::byte> block = {};        ///< the bytes of a constant block

  static NamedResource constants(std::string name, std::span<const std::byte> bytes) {
    return {.name = std::move(name), .block = {bytes.begin(), bytes.end()}};
  }
  template <class T>
  requires(std::is_trivially_copyable_v<T>) static NamedResource
      constants(std::string name, const T& block) {
    return constants(std::move(name), std::as_bytes(std::span(&block, 1)));
  }
};

/// A resource bound to (set, entry) of a pass.
struct PassBinding {
  uint8_t set = 0;
  uint8_t entry = 0;  ///< index into the layout's entries
  /// Storage buffers: which one. kInvalid for uniform buffers, whose bytes are in
  /// PassList::constants.
  BufferId buffer = BufferId::kInvalid;
  uint64_t offset = 0;  ///< bytes, into the buffer or into PassList::constants
  uint64_t size = 0;    ///< bytes; 0 for textures
  Access access = Access::kNone;
  StageMask stages = 0;
  /// Textures and samplers, which have no buffer: which one.
  TextureId texture = TextureId::kInvalid;
};

enum class PassKind : uint8_t { kDispatch, kDispatchIndirect, kDraw, kDrawIndirect };
constexpr bool isDraw(PassKind kind) {
  return kind == PassKind::kDraw || kind == PassKind::kDrawIndirect;
}

enum class PrimitiveTopology : uint8_t { kTriangleList, kTriangleStrip, kLineList };
enum class DepthCompare : uint8_t { kAlways, kLess, kLessEqual, kGreater, kGreaterEqual, kEqual };
enum class BlendMode : uint8_t { kOpaque, kPremultipliedAlpha };

/// Fixed-function state of a draw. Culling is always off: hair has no back.
struct DrawState {
  PrimitiveTopology topology = PrimitiveTopology::kTriangleList;
  DepthCompare depthCompare = DepthCompare::kLess;
  bool depthWrite = true;
  BlendMode blend = BlendMode::kOpaque;
  bool colorWrite = true;  ///< false: a draw that only writes buffers or depth
  bool operator==(const DrawState&) const = default;
};

/// A dependency that must be met before a pass starts. `before` and `after` hold the accesses on
/// the two sides; host uploads and index, vertex or indirect reads have flags of their own.
struct Barrier {
  BufferId buffer = BufferId::kInvalid;
  Access before = Access::kNone;
  Access after = Access::kNone;
  StageMask beforeStages = 0;
  StageMask afterStages = 0;
  bool beforeUpload = false;    ///< the earlier write came from PassList::uploads
  bool beforeIndirect = false;  ///< the earlier read was of indirect arguments
  bool beforeIndex = false;     ///< the earlier read was of indices
  bool beforeVertex = false;    ///< the earlier read was of vertex inputs
  bool afterUpload = false;     ///< the later write is one
  bool afterIndirect = false;   ///< the later read is of indirect arguments
  bool afterIndex = false;      ///< the later read is of indices
  bool afterVertex = false;     ///< the later read is of vertex inputs
};

/// One dispatch or draw. Ranges index into the arrays of the PassList.
struct Pass {
  const char* name = "";  ///< the kernel's, of a draw the pixel kernel's; also of its timer
  PassKind kind = PassKind::kDispatch;
  const KernelVariant* kernel = nullptr;  ///< compute, or vertex stage of a draw
  const KernelVariant* pixel = nullptr;   ///< draws only
  /// The tables that (set, entry) of the bindings mean: of the stage that has more of them.
  std::span<const LayoutTable* const> layouts() const {
    const auto own = kernel->kernel->layouts;
    return pixel != nullptr && pixel->kernel->layouts.size() > own.size() ? pixel->kernel->layouts
                                                                          : own;
  }
  uint32_t firstBinding = 0, bindingCount = 0;
  uint32_t firstSpecValue = 0, specValueCount = 0;  ///< for both stages
  uint32_t firstBarrier = 0, barrierCount = 0;      ///< dispatches only; see drawBarriers
  uint32_t level = 0;              ///< dispatches only; see HazardTracker::resolve()
  uint32_t groups[3] = {0, 0, 0};  ///< kDispatch: each in 1..65535
  /// kDispatchIndirect: three uint32 at indirectOffset. kDrawIndirect: four, the vertices of an
  /// instance, the instances, 0 and 0; without indices, and with elementCount and instanceCount 0.
  BufferId indirect = BufferId::kInvalid;
  uint64_t indirectOffset = 0;
  BufferId indices = BufferId::kInvalid;  ///< kDraw: kInvalid draws without indices
  BufferRange vertices;                   ///< of kernels with Kernel::vertexInput: what it reads
  uint32_t elementCount = 0;              ///< kDraw: indices or vertices an instance
  uint32_t instanceCount = 0;
  DrawState state;
  uint64_t bytes = 0;  ///< bytes that the pass must move at least, for figures; 0 = not known
};

/// Bytes that the host writes into a buffer before the first pass.
struct Upload {
  BufferId buffer = BufferId::kInvalid;
  uint64_t offset = 0;      ///< into the buffer, multiple of 4
  uint64_t dataOffset = 0;  ///< into PassList::uploadData
  uint64_t size = 0;        ///< multiple of 4
};

/// A rectangle of pixels; row 0 is the top row.
struct PixelArea {
  uint32_t x = 0, y = 0;
  uint32_t width = 0, height = 0;
  bool operator==(const PixelArea&) const = default;
};

/// Everything that one call of a runtime executes, in order: uploads, then dispatches, then draws.
/// Uploads of one list must not overlap. Draws of one list are not ordered against each other: a
/// draw that needs what another one writes to a buffer belongs into a later list.
///
/// A list runs once, behind the lists that got their barriers before it. One that is cleared,
/// destroyed or written again without having run counts as abandoned; so does one whose copies all
/// are. See checkRun().
///
/// Threads: as a standard container. What has become of it (PassList::run) may be asked and said on
/// any thread.
struct PELAGE_API PassList {
  HostArray<Pass> passes;  ///< dispatches first, then draws
  HostArray<PassBinding> bindings;
  HostArray<SpecValue> specValues;
  HostArray<Barrier> barriers;
  HostArray<Barrier> uploadBarriers;  ///< before the uploads
  HostArray<Barrier> drawBarriers;    ///< after the last dispatch, before the first draw
  HostArray<Upload> uploads;
  HostArray<std::byte> uploadData;
  HostArray<std::byte> constants;  ///< blocks at multiples of kConstantAlignment

  uint64_t frame = 0;  ///< Scene::simulate() that wrote it; 0: none
  uint64_t table = 0;  ///< ResourceTable::id() of its buffers; 0: not known
  /// The viewport that its draws are written for: View::x, y, width and height of Scene::draw().
  /// Runtimes refuse to draw the list into another one. Without pixels: any.
  PixelArea area;
  /// The samples of a pixel that its draws are written for: View::samples. 0: any.
  uint32_t samples = 0;
  /// The state of its run; from HazardTracker::resolve() or Scene::finish() on. Copies share it.
  RunHandle run;
  /// The buffers of the view that it draws, until it has run; from Scene::draw(). Copies share it.
  std::shared_ptr<detail::ListHold> hold;

  /// Offset alignment of constant blocks: the largest that Vulkan and GL devices may ask for.
  static constexpr uint64_t kConstantAlignment = 256;

  void clear();
  std::span<const PassBinding> bindingsOf(const Pass& pass) const {
    return {bindings.data() + pass.firstBinding, pass.bindingCount};
  }
  std::span<const SpecValue> specValuesOf(const Pass& pass) const {
    return {specValues.data() + pass.firstSpecValue, pass.specValueCount};
  }
  std::span<const Barrier> barriersOf(const Pass& pass) const {
    return {barriers.data() + pass.firstBarrier, pass.barrierCount};
  }
};

/// Whether the dispatch at an index is the last one of its level.
PELAGE_API bool isLastOfLevel(const PassList& list, size_t dispatch);

/// Adds passes to a PassList: picks from what is bound those resources that the permutation really
/// uses, so that a caller may bind everything it has. Passes of kernels that are known at build
/// time give the generated structs of their layouts to finish(), which allocates nothing for them:
///
///     PassBuilder(list).dispatch(variant, threads).finish(exactPosTan, exact);
///
/// Kernels that are not known before the program runs are bound by the names in HLSL; see bind().
///
/// Threads: the one that uses its list.
class PELAGE_API PassBuilder {
 public:
  explicit PassBuilder(PassList& list) : list_(list) {}

  /// Starts a dispatch; groups are rounded up from `threads` by the variant's group size. A count
  /// of 0 threads adds no pass (finish() then does nothing).
  PassBuilder& dispatch(const KernelVariant& variant, uint32_t threadsX, uint32_t threadsY = 1,
                        uint32_t threadsZ = 1);
  /// Starts a dispatch whose numbers of groups, three uint32, a buffer has at `offset` bytes.
  PassBuilder& dispatchIndirect(const KernelVariant& variant, BufferId arguments,
                                uint64_t offset = 0);
  /// Starts a draw. Of the two kernels' layouts, those of one are the first ones of the other's.
  PassBuilder& draw(const KernelVariant& vertex, const KernelVariant& pixel, const DrawState& state,
                    uint32_t elementCount, uint32_t instanceCount,
                    BufferId indices = BufferId::kInvalid);
  /// Starts a draw whose counts a buffer has at `offset` bytes; see Pass::indirect. A dispatch of
  /// the same list may have written them.
  PassBuilder& drawIndirect(const KernelVariant& vertex, const KernelVariant& pixel,
                            const DrawState& state, BufferId arguments, uint64_t offset = 0);
  /// Sets the buffer that Kernel::vertexInput reads; finish() is an error without it.
  PassBuilder& vertices(BufferRange range);
  /// Offers a storage buffer under the name it has in HLSL. Nothing notices a wrong name that no
  /// kernel needs.
  PassBuilder& bind(std::string_view name, BufferId buffer, uint64_t size, uint64_t offset = 0);
  /// Offers the bytes of a uniform block under the name it has in HLSL.
  PassBuilder& constants(std::string_view name, std::span<const std::byte> bytes);
  template <class T>
  PassBuilder& constants(std::string_view name, const T& block) {
    return constants(name, std::as_bytes(std::span(&block, 1)));
  }
  /// Offers a texture, or its sampler, under the name it has in HLSL.
  PassBuilder& bind(std::string_view name, TextureId texture);
  /// Offers all of these. Copies them.
  PassBuilder& offer(std::span<const NamedResource> resources);
  PassBuilder& spec(std::span<const SpecValue> values);
  PassBuilder& bytes(uint64_t bytes);
  /// Adds the pass with the bindings of its layouts, in any order. A struct of a layout with the
  /// same name from another manifest does as well: its resources are found by their names. Errors:
  /// a resource that the permutation needs is not bound (the message has its name), a struct is of
  /// a layout that the pass does not have, or two are of one, or an axis exceeds 65535 groups. Then
  /// the list stays as it was.
  template <class... Bindings>
  requires(sizeof...(Bindings) > 0 && (std::convertible_to<const Bindings&, LayoutBindings> &&
                                       ...)) Result<void> finish(const Bindings&... bindings) {
    const LayoutBindings all[] = {bindings...};
    return finish(std::span<const LayoutBindings>(all));
  }
  Result<void> finish(std::span<const LayoutBindings> bindings);
  /// Adds the pass with the resources that were offered by name.
  Result<void> finish() { return finish(std::span<const LayoutBindings>()); }

 private:
  Result<void> checkLayouts(std::span<const LayoutBindings> bindings) const;
  Result<BoundResource> find(const KernelVariant& variant, const VariantBinding& use,
                             std::span<const LayoutBindings> bindings) const;
  uint64_t addBlock(std::span<const std::byte> block);
  Result<void> addBindings(const KernelVariant& variant, std::span<const LayoutBindings> bindings);
  PassList& list_;
  Pass pass_;
  uint64_t threads_[3] = {0, 0, 0};
  std::vector<NamedResource> offers_;
};

/// Appends host data to a list's uploads.
PELAGE_API void addUpload(PassList& list, BufferId buffer, std::span<const std::byte> bytes,
                          uint64_t offset = 0);

/// Calls for executors of lists: pelage's runtimes make them, and so does one of your own. They may
/// come from any thread; one list is used by one thread at a time.
///
///     if (auto checked = checkList(list, resources); !checked) return checked;  // list_check.h
///     if (auto ready = checkRun(list, executor); !ready) return ready;  // newExecutorId()
///     ...                      // uploads, dispatches
///     setDelivered(list.run, executor);  // or setRecorded(), and this once it is submitted
///
/// Executors without an id, kUnknown, are not told from others.
///
/// A list that nobody calls setDelivered() for has not run: the scene writes all of its frame
/// again. Without a handle (a list that needs no barriers) the calls do nothing.

/// Whether a list may run now. Errors: it has no barriers, or passes or uploads that were added
/// behind them; it has run; it was abandoned; a list that got its barriers before has not run yet,
/// or one that got them after has; those before ran on another executor, which has their results.
PELAGE_API Result<void> checkRun(const PassList& list, ExecutorId executor = ExecutorId::kUnknown);
/// Whether its draws may be recorded: behind checkRun() and setRecorded() or setDelivered().
PELAGE_API Result<void> checkDraws(const PassList& list);
/// Says that a list is in a command buffer, behind those that are there already.
PELAGE_API void setRecorded(const RunHandle& run, ExecutorId executor = ExecutorId::kUnknown);
/// Says that a list has run, or is sure to: its command buffer was submitted.
PELAGE_API void setDelivered(const RunHandle& run, ExecutorId executor = ExecutorId::kUnknown);
/// Says that a list does not run, nor any that got its barriers after it. Scene::abandon() is this
/// for lists of a scene.
PELAGE_API void abandon(const RunHandle& run);

/// Computes the barriers of pass lists from the accesses that reflection found. Keeps the last
/// accesses between lists: pass the lists in the order in which they will run.
///
/// Threads: one thread at a time.
class PELAGE_API HazardTracker {
 public:
  HazardTracker() = default;
  HazardTracker(HazardTracker&&) noexcept = default;
  HazardTracker& operator=(HazardTracker&&) noexcept = default;
  ~HazardTracker() = default;
  HazardTracker(const HazardTracker&) = delete;
  HazardTracker& operator=(const HazardTracker&) = delete;

  /// Sorts the dispatches of the list into levels, and fills barriers, uploadBarriers and
  /// drawBarriers. A dispatch is one level behind the last earlier one that it conflicts with: that
  /// writes a range of a buffer that it reads or writes, or reads one that it writes
  /// (Kernel::commutes are exceptions). Dispatches of a level keep their order and may run at the
  /// same time: the first of them has the barriers of all. A read after a write, a write after a
  /// read and a write after a write get a barrier; a read after a read gets none. After lists that
  /// were abandoned, barriers are right whether these ran or not. Takes time in proportion to the
  /// number of dispatches. A list that has run stays as it is, and checkRun() refuses it: clear()
  /// it first.
  void resolve(PassList& list);
  /// Whether resolve() sorts dispatches into levels (default). Off, they stay in the order in which
  /// they were added, each a level of its own: for debugging.
  void setLevels(bool on) { levels_ = on; }
  /// Forgets a buffer that was removed.
  void forget(BufferId buffer);
  /// Abandons all lists that were resolved and not recorded yet.
  void abandonOpen();
  /// Lets any executor run the next lists, as before the first one. Scene::recover() calls it.
  void forgetExecutor();

 private:
  struct State {
    BufferId buffer = BufferId::kInvalid;  ///< what it is of; nothing is known of another one
    StageMask readStages = 0;
    StageMask writeStages = 0;
    bool uploadWrite = false;
    bool indexRead = false;
    bool vertexRead = false;
    bool indirectRead = false;
    /// Stages (and fixed-function reads) to which the last write has been made visible already.
    StageMask visibleStages = 0;
    bool visibleIndex = false;
    bool visibleVertex = false;
    bool visibleIndirect = false;
  };
  /// A list that may still be abandoned.
  struct Open {
    std::shared_ptr<detail::RunRecord> record;
    size_t firstChange = 0;  ///< index into changes_
  };
  /// The state of a buffer before a list that uses it.
  struct Change {
    uint32_t tableIndex = 0;
    State before;
  };
  State& state(BufferId buffer);
  bool begin(uint32_t tableIndex);
  void settle();
  void mergeFrom(size_t firstChange);
  HostArray<State> states_;    ///< [table index]
  HostArray<uint64_t> marks_;  ///< [table index] last value of mark_ that touched it
  uint64_t mark_ = 0;          ///< rises with each list
  HostArray<Change> changes_;  ///< by the open lists, in their order
  std::shared_ptr<detail::RunOrder> order_;
  HostArray<Open> open_;  ///< in the order in which they run
  std::shared_ptr<detail::ListSchedule> schedule_;
  bool levels_ = true;
};

}  // namespace pelage
