// PELAGE_ASSERT: misuse by the programmer, reported through a hook that an engine can replace.
#pragma once

namespace pelage {

/// Called when an assertion fails. Returning from it continues the program; the default prints the
/// message to stderr and aborts.
using AssertHandler = void (*)(const char* condition, const char* message, const char* file,
                               int line);

/// Replaces the assertion handler; nullptr restores the default. Not thread-safe against running
/// assertions: set it once at start-up.
void setAssertHandler(AssertHandler handler);

/// Reports a failed assertion to the current handler.
void reportAssert(const char* condition, const char* message, const char* file, int line);

}  // namespace pelage

#define PELAGE_ASSERT(condition, message)                                \
  do {                                                                   \
    if (!(condition)) [[unlikely]]                                       \
      ::pelage::reportAssert(#condition, (message), __FILE__, __LINE__); \
  } while (false)
