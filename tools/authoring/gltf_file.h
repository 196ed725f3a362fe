// Shared by the readers of glTF 2.0: the JSON, the buffers and the accessors, each checked before
// it is used.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "pelage/result.h"

namespace pelage::detail {

class GltfFile {
 public:
  /// \param folder of the buffers that the file names; empty: there is none.
  GltfFile(std::span<const std::byte> bytes, std::string_view name, std::filesystem::path folder)
      : bytes_(bytes), name_(name), folder_(std::move(folder)) {}

  /// Takes the file apart; the buffers are read when an accessor needs them.
  Result<void> parse();

  const nlohmann::json& root() const { return root_; }
  /// "name: path: what"; `path` is a place in the JSON, like "accessors[2]".
  Error fail(std::string_view path, std::string_view what) const;

  /// Element `index` of the array `list` of the root; an error when it is not there or no object.
  Result<const nlohmann::json*> element(const char* list, uint64_t index) const;
  /// A member that is a whole number of at least 0; `fallback` when it is missing.
  Result<uint64_t> whole(const nlohmann::json& object, const char* member, std::string_view path,
                         std::optional<uint64_t> fallback = {}) const;

  /// The numbers of an accessor, normalized ones as fractions, one after the other.
  /// \param components that it must have: 1 (SCALAR) to 4 (VEC4). Errors: anything that does not
  /// fit together or leaves the buffer; sparse accessors, and those without data.
  Result<std::vector<float>> floats(uint64_t accessor, uint32_t components);
  /// The same for indices: SCALAR of unsigned integers.
  Result<std::vector<uint32_t>> indices(uint64_t accessor);
  /// 1 for SCALAR to 4 for VEC4, 0 for matrices.
  Result<uint32_t> componentCount(uint64_t accessor) const;

  /// Bytes of the file and of all buffers read so far.
  uint64_t bytesRead() const { return bytesRead_; }

 private:
  struct View {
    std::span<const std::byte> bytes;  // from the first element on
    uint64_t count = 0, stride = 0;
    uint32_t componentType = 0;
    bool normalized = false;
  };

  struct BufferView {
    std::span<const std::byte> bytes;
    uint64_t stride = 0;
  };

  Result<void> parseBinary();
  Result<void> parseJson(std::string_view text, uint64_t offset);
  Result<std::span<const std::byte>> buffer(uint64_t index);
  Result<std::span<const std::byte>> readBuffer(uint64_t index, const nlohmann::json& object);
  Result<View> view(uint64_t accessor, uint32_t components);
  Result<BufferView> bufferView(uint64_t index, uint64_t elementSize);

  std::span<const std::byte> bytes_, chunk_;
  std::string_view name_;
  std::filesystem::path folder_;
  nlohmann::json root_;
  // Buffers by number, and those of a URI, which several may share.
  std::map<uint64_t, std::span<const std::byte>> buffers_;
  std::map<std::string, std::vector<std::byte>> contents_;
  uint64_t bytesRead_ = 0;
};

}  // namespace pelage::detail
