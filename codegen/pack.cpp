#include "codegen/pack.h"

#include <zstd.h>

#include <memory>

namespace pelage::codegen {
namespace {

// Permutations of a kernel are nearly the same and lie one behind the other: the window spans all
// of them (16 MiB), so that each costs little more than its differences.
constexpr int kLevel = 19;
constexpr int kWindowLog = 24;

}  // namespace

std::string pack(std::string_view bytes) {
  const std::unique_ptr<ZSTD_CCtx, decltype(&ZSTD_freeCCtx)> context(ZSTD_createCCtx(),
                                                                     &ZSTD_freeCCtx);
  if (!context) return {};
  ZSTD_CCtx_setParameter(context.get(), ZSTD_c_compressionLevel, kLevel);
  ZSTD_CCtx_setParameter(context.get(), ZSTD_c_windowLog, kWindowLog);
  ZSTD_CCtx_setParameter(context.get(), ZSTD_c_checksumFlag, 1);
  std::string packed(ZSTD_compressBound(bytes.size()), '\0');
  const size_t size =
      ZSTD_compress2(context.get(), packed.data(), packed.size(), bytes.data(), bytes.size());
  if (ZSTD_isError(size) != 0) return {};
  packed.resize(size);
  return packed;
}

std::string packVersion() {
  return std::string("zstd ") + ZSTD_versionString() + " level " + std::to_string(kLevel) + "/" +
         std::to_string(kWindowLog);
}

}  // namespace pelage::codegen
