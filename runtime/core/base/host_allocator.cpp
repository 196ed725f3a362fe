#include "pelage/host_allocator.h"

#include <atomic>
#include <cstdint>
#include <new>

#include "pelage/assert.h"

namespace pelage {
namespace {

HostAllocator g_allocator;
// Arrays that have memory: they are freed by what allocated them.
std::atomic<uint64_t> g_arrays{0};

// As std::allocator does it, so that nothing changes where no allocator is set.
bool isOverAligned(size_t alignment) { return alignment > __STDCPP_DEFAULT_NEW_ALIGNMENT__; }
void* newArray(size_t bytes, size_t alignment) {
  return isOverAligned(alignment) ? ::operator new(bytes, std::align_val_t(alignment))
                                  : ::operator new(bytes);
}
void deleteArray(void* memory, size_t alignment) noexcept {
  if (isOverAligned(alignment))
    ::operator delete(memory, std::align_val_t(alignment));
  else
    ::operator delete(memory);
}

}  // namespace

void setHostAllocator(const HostAllocator& allocator) {
  const bool whole = (allocator.allocate != nullptr) == (allocator.free != nullptr);
  const bool first = g_arrays.load() == 0;
  PELAGE_ASSERT(whole, "setHostAllocator(): an allocator has both functions, or none");
  PELAGE_ASSERT(first,
                "setHostAllocator(): there are arrays of another allocator; call it before all "
                "else of pelage");
  if (whole && first) g_allocator = allocator;
}

namespace detail {

void* allocateArray(size_t bytes, size_t alignment) {
  void* memory = g_allocator.allocate != nullptr
                     ? g_allocator.allocate(g_allocator.user, bytes, alignment)
                     : newArray(bytes, alignment);
  if (memory == nullptr) throw std::bad_alloc();
  g_arrays.fetch_add(1, std::memory_order_relaxed);
  return memory;
}

void freeArray(void* memory, size_t bytes, size_t alignment) noexcept {
  g_arrays.fetch_sub(1, std::memory_order_relaxed);
  if (g_allocator.allocate != nullptr)
    g_allocator.free(g_allocator.user, memory, bytes, alignment);
  else
    deleteArray(memory, alignment);
}

}  // namespace detail
}  // namespace pelage
