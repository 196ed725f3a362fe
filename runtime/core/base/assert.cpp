#include "pelage/assert.h"

#include <atomic>
#include <cstdio>
#include <cstdlib>

namespace pelage {
namespace {

void abortOnAssert(const char* condition, const char* message, const char* file, int line) {
  std::fprintf(stderr, "%s:%d: assertion failed: %s (%s)\n", file, line, message, condition);
  std::abort();
}

std::atomic<AssertHandler> g_handler{abortOnAssert};

}  // namespace

void setAssertHandler(AssertHandler handler) {
  g_handler.store(handler != nullptr ? handler : abortOnAssert);
}

void reportAssert(const char* condition, const char* message, const char* file, int line) {
  g_handler.load()(condition, message, file, line);
}

}  // namespace pelage
