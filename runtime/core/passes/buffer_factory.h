// Buffers that a room makes.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "passes/shared_tables.h"
#include "pelage/pass_list.h"
#include "pelage/types.h"

namespace pelage::detail {

inline constexpr uint64_t kVector = sizeof(Float4);

/// A room's request for one of its buffers.
struct BufferNeed {
  BufferId& buffer;
  const char* name;
  uint64_t bytes;
  uint32_t stride;
  BufferUsage usage = BufferUsage::kStorage;
  std::string_view suffix = {};  ///< of the name
};

/// A buffer that a frame has no use for any more. It goes once the frame has run.
struct RemovedBuffer {
  BufferId buffer = BufferId::kInvalid;
  const void* owner = nullptr;  ///< hair object or collider; nullptr: the scene
};

/// Where rooms make their buffers: the table of a scene, and what is known of accesses to them.
struct BufferFactory {
  ResourceTable& resources;
  HazardTracker& hazards;
  HostArray<RemovedBuffer>* removed = nullptr;  ///< of the frame that is recorded; nullptr: what
                                                ///< is removed goes at once
  const void* owner = nullptr;                  ///< of what is removed
  SharedTables* shared = nullptr;               ///< nullptr: nothing is shared

  uint64_t bytesOf(BufferId buffer) const {
    const BufferDesc* desc = resources.find(buffer);
    return desc != nullptr ? desc->size : 0;
  }
  void remove(BufferId& buffer) const {
    if (buffer == BufferId::kInvalid) return;
    if (shared != nullptr && shared->contains(buffer)) {
      shared->noteRelease();
    } else if (removed != nullptr) {
      removed->push_back({buffer, owner});
    } else {
      resources.remove(buffer);
      hazards.forget(buffer);
    }
    buffer = BufferId::kInvalid;
  }
  BufferId add(std::string name, uint64_t elements, uint32_t stride,
               HostArray<std::byte> initial = {}, BufferUsage usage = BufferUsage::kStorage) const {
    return resources.add({.name = std::move(name),
                          .size = elements * stride,
                          .stride = stride,
                          .usage = usage,
                          .initial = std::move(initial)});
  }
  /// Adds a table that never changes, or finds the one that another object has.
  /// \param what  its kind; the name is "<object>/<what>"
  BufferId share(const std::string& object, const std::string& what, uint32_t stride,
                 HostArray<std::byte> contents, BufferUsage usage = BufferUsage::kStorage) const {
    BufferDesc desc = {
        .name = object + "/" + what, .size = contents.size(), .stride = stride, .usage = usage};
    desc.initial = std::move(contents);
    return shared != nullptr ? shared->add(resources, what, std::move(desc))
                             : resources.add(std::move(desc));
  }
  /// Makes a buffer anew where it is too small. \param exact also where it is too large.
  /// \return true where it did.
  bool ensureCapacity(const BufferNeed& need, bool exact = false) const {
    const uint64_t bytes = bytesOf(need.buffer);
    if (exact ? bytes == need.bytes : bytes >= need.bytes) return false;
    remove(need.buffer);
    need.buffer = resources.add({.name = std::string(need.name).append(need.suffix),
                                 .size = need.bytes,
                                 .stride = need.stride,
                                 .usage = need.usage});
    return true;
  }
};

}  // namespace pelage::detail
