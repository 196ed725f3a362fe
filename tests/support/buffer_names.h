// Buffers by their names, for those that a scene keeps to itself.
#pragma once

#include <cstdint>
#include <string_view>

#include "pelage/pass_list.h"

namespace pelage::test {

/// "<object>/<buffer>"; nullptr where there is none.
inline const BufferDesc* bufferNamed(const ResourceTable& table, std::string_view name) {
  for (uint32_t slot = 0; slot < table.end(); ++slot) {
    const BufferDesc* desc = table.find(table.at(slot));
    if (desc != nullptr && desc->name == name) return desc;
  }
  return nullptr;
}

}  // namespace pelage::test
