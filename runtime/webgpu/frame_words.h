// Frames as flat memory: what crosses to the JavaScript module that runs them on WebGPU.
#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <span>
#include <vector>

#include "pelage/pass_list.h"
#include "pelage/result.h"

namespace pelage::webgpu {

/// First word of a frame. executor.mjs reads frames with the same one only.
inline constexpr uint32_t kFrameVersion = 0x70656c01;

/// Writes frames as 32-bit words, with bytes behind them that words name by their offset.
///
/// Buffers have numbers: 1, 2 and so on in the order in which they came; 0 is none. A frame is
///
///     version, offset of the bytes, number of new buffers, of removed ones, of lists
///     each new buffer: number, size, usage (BufferUsage), offset of its contents or 0
///     each removed buffer: number
///     each list: uploads, passes, offset and size of its constants, x, y, width and height
///       each upload: buffer, offset into it, offset of the bytes, size
///       each pass: kind (PassKind), hash of the kernel (low, high), of the pixel kernel (low,
///       high),
///           groups x, y, z, counts (buffer, offset), vertices (buffer, offset, size), indices
///           (buffer), elements, instances, state, bindings
///         each binding: set, entry, buffer (0: constants), offset, size
///
/// The state is topology + 8 depthCompare + 64 depthWrite + 128 blend + 256 colorWrite.
///
/// Threads: one thread at a time.
class FrameWriter {
 public:
  /// The words and bytes of the buffers that are new or gone since the last frame, and of the
  /// lists. They stay until the next call. Errors: what WebGPU has not: textures, values of
  /// specialization constants, sizes of 4 GiB. The next frame then has what this one lacks.
  Result<std::span<const std::byte>> write(const ResourceTable& resources,
                                           std::span<const PassList* const> lists);
  /// The number of a buffer of the frames so far; 0 if none has had it.
  uint32_t numberOf(BufferId id) const;

 private:
  void add(uint64_t word);
  uint32_t put(std::span<const std::byte> bytes);
  void addBuffers(const ResourceTable& resources);
  Result<void> addList(const PassList& list);
  Result<void> addPass(const PassList& list, const Pass& pass);

  std::map<BufferId, uint32_t> numbers_;
  uint32_t last_ = 0;
  std::vector<uint32_t> words_;
  std::vector<std::byte> bytes_;
  std::vector<std::byte> frame_;
  bool fits_ = true;  // all words of the frame have 32 bits
};

}  // namespace pelage::webgpu
