// Counts and limits the calls of operator new of a test program: included by one source of it.
// Shared libraries that the program loads take its operator new, too.
#pragma once

#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <new>

namespace pelage::test {
/// Calls of operator new on this thread.
inline thread_local uint64_t g_newCount = 0;
/// Allocations of this thread, after which there is no memory; below 0: there always is.
inline thread_local int64_t g_allocationsLeft = -1;
}  // namespace pelage::test

// GCC warns where it inlines one of them alone, as it does under the sanitizers.
#if defined(__GNUC__) && !defined(__clang__)
#pragma GCC diagnostic ignored "-Wmismatched-new-delete"
#endif
void* operator new(size_t size, const std::nothrow_t& /*tag*/) noexcept {
  if (pelage::test::g_allocationsLeft == 0) return nullptr;
  if (pelage::test::g_allocationsLeft > 0) --pelage::test::g_allocationsLeft;
  ++pelage::test::g_newCount;
  return std::malloc(size == 0 ? 1 : size);
}
void* operator new(size_t size) {
  if (void* memory = ::operator new(size, std::nothrow)) return memory;
  throw std::bad_alloc();
}
void operator delete(void* memory) noexcept { std::free(memory); }
void operator delete(void* memory, size_t) noexcept { std::free(memory); }
void operator delete(void* memory, const std::nothrow_t& /*tag*/) noexcept { std::free(memory); }
