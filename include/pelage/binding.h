// Types behind the generated binding structs (pelage/bindings.h, and the header that
// pelage_add_kernels() makes for an engine's own HLSL). There is one struct a layout, with a member
// for each buffer and each constant block:
//
//     ShiftPositionsBindings bindings{.shiftPositionsConstants = constants};
//     bindings.shiftedPositions = {positions, count * sizeof(Float4)};
//     PassBuilder(list).dispatch(shiftPositionsVariant({}), count).finish(bindings);
#pragma once

#include <concepts>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

#include "pelage/layout.h"

namespace pelage {

/// A buffer of a ResourceTable, and of its copies. Other tables do not have it.
enum class BufferId : uint64_t { kInvalid = 0 };

/// A texture of the engine with the sampler that reads it; see newTextureId().
enum class TextureId : uint32_t { kInvalid = 0 };

/// A part of a buffer. Without a buffer it is empty: nothing is bound.
struct BufferRange {
  BufferId buffer = BufferId::kInvalid;
  uint64_t size = 0;    ///< bytes
  uint64_t offset = 0;  ///< bytes

  bool isBound() const { return buffer != BufferId::kInvalid; }
  bool operator==(const BufferRange&) const = default;
};

/// The value of one entry of a layout: a buffer, a texture or its sampler, the bytes of a constant
/// block, or nothing.
struct BoundResource {
  BoundResource() = default;
  explicit BoundResource(const BufferRange& bound) : range(bound) {}
  template <class Block>
  explicit BoundResource(const std::optional<Block>& bound) {
    if (bound) block = std::as_bytes(std::span(&*bound, 1));
  }

  BufferRange range;
  TextureId texture = TextureId::kInvalid;
  std::span<const std::byte> block;

  bool isBound() const {
    return range.isBound() || texture != TextureId::kInvalid || !block.empty();
  }
};

/// A struct with the bindings of a layout, as pelage-codegen makes them.
template <class T>
concept BindingsOfLayout = requires(const T& bindings, uint8_t entry) {
  { layoutOf(bindings) } -> std::same_as<const LayoutTable&>;
  { boundTo(bindings, entry) } -> std::same_as<BoundResource>;
};

/// A view of any such struct, which has to outlive it.
///
/// Threads: as the struct that it looks at.
class LayoutBindings {
 public:
  template <BindingsOfLayout T>
  LayoutBindings(const T& bindings)
      : layout_(&layoutOf(bindings)), bindings_(&bindings), at_(&boundToAny<T>) {}

  const LayoutTable& layout() const { return *layout_; }
  /// \param entry  index into layout().entries
  BoundResource at(uint8_t entry) const { return at_(bindings_, entry); }

 private:
  template <class T>
  static BoundResource boundToAny(const void* bindings, uint8_t entry) {
    return boundTo(*static_cast<const T*>(bindings), entry);
  }

  const LayoutTable* layout_;
  const void* bindings_;
  BoundResource (*at_)(const void* bindings, uint8_t entry);
};

}  // namespace pelage
