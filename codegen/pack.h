// Compression of the code of kernels.
#pragma once

#include <string>
#include <string_view>

namespace pelage::codegen {

/// One frame of zstd, as a program unpacks it; the same bytes for the same input and version. Empty
/// only when memory runs out.
std::string pack(std::string_view bytes);

/// "zstd 1.5.4" and the settings that change the bytes.
std::string packVersion();

}  // namespace pelage::codegen
