// Finds errors in a pass list before anything of it runs. pelage's runtimes call this for every
// list that they record; an executor of your own calls it as well:
//
//     if (auto checked = checkList(list, resources, limits); !checked) return checked;
//     if (auto ready = checkRun(list, executor); !ready) return ready;
//     ...  // no index, offset or pointer of the list needs another check
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <string_view>

#include "pelage/export.h"
#include "pelage/pass_list.h"
#include "pelage/result.h"
#include "pelage/tier.h"

namespace pelage {

/// Limits of a device for one pass. The defaults hold for every list that PassBuilder makes.
struct DeviceLimits {
  /// Thread groups of a dispatch an axis. Vulkan: maxComputeWorkGroupCount, GL:
  /// GL_MAX_COMPUTE_WORK_GROUP_COUNT.
  uint32_t groups[3] = {65535, 65535, 65535};
  /// Bytes of a constant block. Vulkan: maxUniformBufferRange, GL: GL_MAX_UNIFORM_BLOCK_SIZE.
  uint64_t uniformBytes = UINT64_MAX;
  /// Bytes of a storage buffer that a pass binds. Vulkan: maxStorageBufferRange, GL:
  /// GL_MAX_SHADER_STORAGE_BLOCK_SIZE.
  uint64_t storageBytes = UINT64_MAX;
  /// Offsets of bound storage buffers are multiples of it, > 0. Vulkan:
  /// minStorageBufferOffsetAlignment, GL: GL_SHADER_STORAGE_BUFFER_OFFSET_ALIGNMENT.
  uint64_t storageAlignment = 1;
};

/// A buffer as an executor has it, which may differ from the table's entry: it may be one that the
/// engine registered.
struct KnownBuffer {
  std::string_view name;  ///< for messages
  uint64_t size = 0;      ///< bytes
  BufferUsage usage = BufferUsage::kStorage;
  uint64_t offset = 0;  ///< bytes from the start of the API's buffer; counts for the alignment
};

/// Finds the buffer of an id; nothing for an id that was removed or that the executor has not seen.
using BufferLookup = std::function<std::optional<KnownBuffer>(BufferId)>;

/// The part of a list that is about to run.
enum class ListPart : uint8_t {
  kAll,         ///< everything
  kDispatches,  ///< the uploads, the barriers and the dispatches
  kDraws,       ///< the draws
};

/// "simulate_classic [wind=1]": a permutation in messages.
PELAGE_API std::string variantName(const KernelVariant& variant);

/// Checks what needs neither buffers nor a device: every pass has kernels of the right stages whose
/// layouts fit, its ranges lie in the list's arrays, each binding is an entry of its layouts and
/// bound once, nothing that the kernels use is left out, and dispatches come before draws.
///
/// Errors (kInvalidArgument, kUnsupported for images) name the pass and the resource.
PELAGE_API Result<void> checkPasses(const PassList& list);

/// Checks everything that can be wrong with a list, but for its turn (see checkRun()): what
/// checkPasses() checks; that buffers exist, that bound ranges, uploads, indices and indirect
/// arguments lie inside of them, and that the last two have BufferUsage::kIndex and kIndirect; that
/// constant blocks have their size; and the limits of the device. BufferUsage::kStorage, kUpload
/// and kReadback tell a runtime how a buffer is used most; they are not checked.
///
/// Changes nothing. Allocates only for an error.
///
/// Errors: kInvalidArgument; kUnsupported if the device cannot run the list. They name the pass and
/// the resource, or the upload's buffer. A list that was abandoned has the error of checkRun().
PELAGE_API Result<void> checkList(const PassList& list, const BufferLookup& find,
                                  const DeviceLimits& limits, ListPart part = ListPart::kAll);
/// The same with the buffers of a table, which has to be the list's own (see checkTable()).
PELAGE_API Result<void> checkList(const PassList& list, const ResourceTable& resources,
                                  const DeviceLimits& limits = {}, ListPart part = ListPart::kAll);

/// Checks what the kernels of a pass need of a device: storage buffers of each stage and of both,
/// threads of a group. \param pixel  of a draw, else nullptr. \param device  its name, for
/// messages. Errors: kUnsupported, with the permutation, what it needs and what there is.
PELAGE_API Result<void> checkLimits(const KernelVariant& kernel, const KernelVariant* pixel,
                                    const TierLimits& limits, std::string_view device);

/// Whether the draws of a list go where they were written for: PassList::area. Call it before the
/// draws are recorded. \param area  the viewport that they get. Errors: kInvalidArgument, with both
/// rectangles.
PELAGE_API Result<void> checkArea(const PassList& list, const PixelArea& area);
/// The same for PassList::samples. \param samples  of the target. Errors: kInvalidArgument, with
/// both numbers.
PELAGE_API Result<void> checkSamples(const PassList& list, uint32_t samples);

/// Whether a list is of the table that an executor has the buffers of. Ids of another one may mean
/// other buffers here.
/// \param table  ResourceTable::id(); 0 (not known) goes with every list
PELAGE_API Result<void> checkTable(const PassList& list, uint64_t table);

}  // namespace pelage
