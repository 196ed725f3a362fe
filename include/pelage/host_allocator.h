// Memory on the host: an engine's allocator for the arrays of pass lists, buffers and objects.
#pragma once

#include <cstddef>
#include <vector>

#include "pelage/export.h"

namespace pelage {

/// An engine's own memory for every HostArray: docs/scene.md says what these are. Leave `allocate`
/// null for the global operator new. Both functions are called on any thread, on several at once.
struct HostAllocator {
  void* user = nullptr;  ///< passed back
  /// Returns memory, or nullptr where there is none: what happens then is what happens where
  /// operator new has none. \param bytes > 0. \param alignment  a power of two
  void* (*allocate)(void* user, size_t bytes, size_t alignment) = nullptr;
  /// Frees what allocate() returned for this size and alignment; never nullptr.
  void (*free)(void* user, void* memory, size_t bytes, size_t alignment) = nullptr;
};

/// Sets the allocator of the whole program. Call it before all else of pelage, on one thread.
/// Asserts that there is no array yet, whose memory another allocator would free, and that either
/// both functions are there or none; nothing has changed then.
PELAGE_API void setHostAllocator(const HostAllocator& allocator);

namespace detail {
PELAGE_API void* allocateArray(size_t bytes, size_t alignment);
PELAGE_API void freeArray(void* memory, size_t bytes, size_t alignment) noexcept;
}  // namespace detail

/// The allocator of standard containers whose memory is the HostAllocator's. It has no state.
template <class T>
struct HostArrayAllocator {
  using value_type = T;
  HostArrayAllocator() = default;
  template <class U>
  constexpr HostArrayAllocator(const HostArrayAllocator<U>& /*other*/) noexcept {}
  T* allocate(size_t count) {
    // A container asks for at most max_size() elements: the product is in range.
    return static_cast<T*>(detail::allocateArray(count * sizeof(T), alignof(T)));
  }
  void deallocate(T* memory, size_t count) noexcept {
    detail::freeArray(memory, count * sizeof(T), alignof(T));
  }
  friend constexpr bool operator==(const HostArrayAllocator& /*a*/,
                                   const HostArrayAllocator& /*b*/) noexcept {
    return true;
  }
};

/// A std::vector in the memory of the HostAllocator.
template <class T>
using HostArray = std::vector<T, HostArrayAllocator<T>>;

}  // namespace pelage
