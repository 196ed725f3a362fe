#include "passes/handles.h"

#include <mutex>
#include <new>
// Not in older libraries of LLVM, as emscripten's.
#if __has_include(<memory_resource>)
#include <memory_resource>
#endif

namespace pelage::detail {

namespace {

#if !__has_include(<memory_resource>)
struct HeapResource {
  static void* allocate(size_t bytes, size_t alignment) {
    return ::operator new(bytes, std::align_val_t(alignment));
  }
  static void deallocate(void* memory, size_t bytes, size_t alignment) noexcept {
    ::operator delete(memory, bytes, std::align_val_t(alignment));
  }
};
#endif

struct Pool {
  std::mutex mutex;
#if __has_include(<memory_resource>)
  std::pmr::unsynchronized_pool_resource memory;
#else
  HeapResource memory;
#endif
};

// Never destroyed: handles may be as old as the program.
Pool& pool() {
  static Pool& one = *new Pool;
  return one;
}

}  // namespace

void* allocateHandle(size_t bytes, size_t alignment) {
  Pool& own = pool();
  const std::lock_guard lock(own.mutex);
  return own.memory.allocate(bytes, alignment);
}

void freeHandle(void* memory, size_t bytes, size_t alignment) noexcept {
  Pool& own = pool();
  const std::lock_guard lock(own.mutex);
  own.memory.deallocate(memory, bytes, alignment);
}

}  // namespace pelage::detail
