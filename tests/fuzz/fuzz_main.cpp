// One target as a program of libFuzzer: PELAGE_FUZZ_TARGET is its function in targets.h.
#include <cstdint>
#include <cstdio>
#include <cstdlib>

#include "targets.h"

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  const auto outcome =
      pelage::fuzz::PELAGE_FUZZ_TARGET({reinterpret_cast<const std::byte*>(data), size});
  if (!outcome.fault.empty()) {
    std::fprintf(stderr, "%s\n", outcome.fault.c_str());
    std::abort();
  }
  return 0;
}
