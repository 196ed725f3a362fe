// Memory of the small objects that lists share with those who ask what became of them: one that
// goes leaves it to the next one.
#pragma once

#include <cstddef>
#include <memory>
#include <vector>

namespace pelage::detail {

/// From any thread.
void* allocateHandle(size_t bytes, size_t alignment);
void freeHandle(void* memory, size_t bytes, size_t alignment) noexcept;

template <class T>
struct HandleAllocator {
  using value_type = T;
  HandleAllocator() = default;
  template <class U>
  constexpr HandleAllocator(const HandleAllocator<U>& /*other*/) noexcept {}
  T* allocate(size_t count) {
    return static_cast<T*>(allocateHandle(count * sizeof(T), alignof(T)));
  }
  void deallocate(T* memory, size_t count) noexcept {
    freeHandle(memory, count * sizeof(T), alignof(T));
  }
  friend constexpr bool operator==(const HandleAllocator& /*a*/,
                                   const HandleAllocator& /*b*/) noexcept {
    return true;
  }
};

template <class T>
std::shared_ptr<T> makeHandle() {
  return std::allocate_shared<T>(HandleAllocator<T>());
}

template <class T>
using HandleArray = std::vector<std::shared_ptr<T>, HandleAllocator<std::shared_ptr<T>>>;

}  // namespace pelage::detail
