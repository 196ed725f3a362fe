#include "pelage/kernel_code.h"

#include <fmt/format.h>
#include <zstd.h>

#include <cstring>

namespace pelage {
namespace {

std::string nameOf(const KernelVariant& variant) {
  const std::string name = variant.kernel->name;
  return *variant.key == '\0' ? name : name + " with " + variant.key;
}

}  // namespace

const char* codeFormatName(CodeFormat format) {
  switch (format) {
    case CodeFormat::kSpirv:
      return "SPIR-V";
    case CodeFormat::kGlsl:
      return "GLSL";
    case CodeFormat::kEssl:
      return "ESSL";
    case CodeFormat::kWgsl:
      break;
  }
  return "WGSL";
}

std::vector<CarriedKernel> carriedKernels(KernelCodeList list) {
  std::vector<CarriedKernel> carried;
  for (const KernelCode* code : list) {
    carried.push_back(
        {code->kernel->name, code->format, code->rangeCount, code->packedBytes, code->bytes});
  }
  return carried;
}

void KernelCodes::add(KernelCodeList list) {
  for (const KernelCode* code : list) {
    for (uint32_t i = 0; i < code->rangeCount; ++i)
      places_.try_emplace({code->ranges[i].variant, code->format}, Place{code, i});
  }
}

Result<std::vector<char>> KernelCodes::unpack(const KernelVariant& variant,
                                              CodeFormat format) const {
  const auto found = places_.find({variant.hash, format});
  if (found == places_.end()) {
    return Error{ErrorCode::kUnsupported,
                 fmt::format("no {} is known for kernel {}: add the generated tables of the kernel "
                             "(pelage/kernel_code.h)",
                             codeFormatName(format), nameOf(variant))};
  }
  const KernelCode& code = *found->second.code;
  const KernelCode::Range& range = code.ranges[found->second.range];
  std::vector<char> all(code.bytes);
  const size_t size = ZSTD_decompress(all.data(), all.size(), code.packed, code.packedBytes);
  if (size != all.size() || range.size > size || range.offset > size - range.size) {
    return Error{
        ErrorCode::kInvalidFile,
        fmt::format("the {} of kernel {} is damaged: {}", codeFormatName(format), code.kernel->name,
                    ZSTD_isError(size) != 0 ? ZSTD_getErrorName(size) : "too short")};
  }
  const auto begin = all.begin() + range.offset;
  return std::vector<char>(begin, begin + range.size);
}

Result<std::vector<uint32_t>> KernelCodes::spirv(const KernelVariant& variant) const {
  const Result<std::vector<char>> bytes = unpack(variant, CodeFormat::kSpirv);
  if (!bytes) return bytes.error();
  std::vector<uint32_t> words(bytes->size() / sizeof(uint32_t));
  if (!words.empty()) std::memcpy(words.data(), bytes->data(), words.size() * sizeof(uint32_t));
  return words;
}

Result<std::string> KernelCodes::source(const KernelVariant& variant, CodeFormat format) const {
  const Result<std::vector<char>> bytes = unpack(variant, format);
  if (!bytes) return bytes.error();
  return std::string(bytes->begin(), bytes->end());
}

}  // namespace pelage
