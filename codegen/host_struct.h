// C++ structs with the offsets of the GPU.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "codegen/diagnostics.h"
#include "codegen/reflect.h"
#include "codegen/unit.h"

namespace pelage::codegen {

struct HostField {
  std::string type;  ///< C++ type of one element
  std::string name;
  uint32_t arraySize = 0;  ///< 0: not an array
  uint32_t offset = 0;
  uint32_t size = 0;  ///< with all elements
  bool isPadding = false;
};

struct HostStruct {
  std::string name;
  uint32_t size = 0;
  std::vector<HostField> fields;
};

/// Lays out the C++ struct. Layouts that C++ cannot express go into the diagnostics, at `where`.
std::optional<HostStruct> makeHostStruct(const StructLayout& layout, const SourceLocation& where,
                                         Diagnostics& diagnostics);

}  // namespace pelage::codegen
