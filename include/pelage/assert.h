// PELAGE_ASSERT: misuse by the programmer, reported through a hook that an engine can replace.
#pragma once

#include "pelage/export.h"

namespace pelage {

/// Called when an assertion fails. If it returns, the program continues; the default prints the
/// message to stderr and aborts.
using AssertHandler = void (*)(const char* condition, const char* message, const char* file,
                               int line);

/// Replaces the assertion handler of all threads; nullptr restores the default. May be called on
/// any thread; an assertion that fails meanwhile gets one of the two handlers. A handler may be
/// called on several threads at once.
PELAGE_API void setAssertHandler(AssertHandler handler);

/// Reports a failed assertion to the current handler.
PELAGE_API void reportAssert(const char* condition, const char* message, const char* file,
                             int line);

}  // namespace pelage

#define PELAGE_ASSERT(condition, message)                                \
  do {                                                                   \
    if (!(condition)) [[unlikely]]                                       \
      ::pelage::reportAssert(#condition, (message), __FILE__, __LINE__); \
  } while (false)
