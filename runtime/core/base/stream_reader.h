// Reads a ByteSource; errors name the byte, and the stated size is not trusted.
#pragma once

#include <algorithm>
#include <cstdint>
#include <span>
#include <string_view>
#include <type_traits>
#include <vector>

#include "pelage/result.h"
#include "pelage/stream.h"

namespace pelage::detail {

class StreamReader {
 public:
  /// Both must outlive the reader.
  StreamReader(ByteSource& source, std::string_view name)
      : source_(source), name_(name), size_(source.size()) {}

  uint64_t size() const { return size_; }
  std::string_view name() const { return name_; }

  /// Fills `out`. Error: the source ends before, or reading fails.
  Result<void> read(uint64_t offset, std::span<std::byte> out);

  /// Reads `count` elements. Memory grows with the bytes that arrive.
  template <class T>
  Result<void> readArray(uint64_t offset, uint64_t count, std::vector<T>& out) {
    static_assert(std::is_trivially_copyable_v<T>);
    out.clear();
    if (auto r = checkRange(offset, count, sizeof(T)); !r) return r;
    for (uint64_t done = 0; done < count;) {
      const uint64_t next = std::min(count, std::max(kFirstBytes / sizeof(T), 2 * done));
      out.resize(next);
      if (auto r =
              read(offset + done * sizeof(T), std::as_writable_bytes(std::span(out).subspan(done)));
          !r)
        return r;
      done = next;
    }
    return {};
  }

 private:
  /// Maximum memory that is allocated before bytes have arrived.
  static constexpr uint64_t kFirstBytes = uint64_t{8} << 20;

  Result<void> checkRange(uint64_t offset, uint64_t count, uint64_t elementSize) const;

  ByteSource& source_;
  std::string_view name_;
  uint64_t size_;
};

}  // namespace pelage::detail
