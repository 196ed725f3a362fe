// Uploads that are written where the list has them.
#pragma once

#include <cstdint>
#include <span>
#include <type_traits>

#include "pelage/pass_list.h"

namespace pelage::detail {

/// Adds an upload of zeros. \return them, to be written before anything else adds to the list
template <class T>
std::span<T> uploadOf(PassList& list, BufferId buffer, size_t count, uint64_t offset = 0) {
  static_assert(std::is_trivially_copyable_v<T> && sizeof(T) % 4 == 0);
  if (count == 0) return {};
  const uint64_t first = list.uploadData.size(), bytes = count * sizeof(T);
  list.uploads.push_back({buffer, offset, first, bytes});
  list.uploadData.resize(first + bytes);
  return {reinterpret_cast<T*>(list.uploadData.data() + first), count};
}

}  // namespace pelage::detail
