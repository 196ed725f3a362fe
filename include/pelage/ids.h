// Ids of the objects in a scene.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <utility>
#include <vector>

#include "pelage/export.h"

namespace pelage {

/// A hair object of a scene. For this and the other ids: zero is invalid, ids are never reused, and
/// an id is valid in its own scene only.
enum class HairId : uint64_t { kInvalid = 0 };
/// A mesh collider of a scene.
enum class ColliderId : uint64_t { kInvalid = 0 };
/// A skeleton of a scene.
enum class SkeletonId : uint64_t { kInvalid = 0 };

namespace detail {

/// Returns a different number at every call, from 1 on.
PELAGE_API uint32_t nextOwner();

/// Owns objects by id. Bits 0..15 of an id are a slot, from 1 on; bits 16..31 count the objects
/// that were in the slot before; bits 32..63 are the owner, which is unique.
///
/// Threads: one thread at a time.
template <class Id, class T>
class Slots {
 public:
  /// Maximum number of objects at a time.
  static constexpr size_t kMost = 0xffff;

  Slots() : owner_(nextOwner()) {}
  /// The moved-from owner has no objects.
  Slots(Slots&& other) noexcept
      : owner_(std::exchange(other.owner_, nextOwner())),
        held_(std::move(other.held_)),
        generations_(std::move(other.generations_)) {}
  Slots& operator=(Slots&& other) noexcept {
    owner_ = std::exchange(other.owner_, nextOwner());
    held_ = std::move(other.held_);
    generations_ = std::move(other.generations_);
    return *this;
  }
  ~Slots() = default;

  bool isFull() const { return freeIndex() == kMost; }
  /// Call only if not isFull().
  Id add(std::unique_ptr<T> value) {
    const size_t index = freeIndex();
    if (index == held_.size()) {
      generations_.push_back(0);
      held_.emplace_back();
    }
    held_[index] = std::move(value);
    return idOf(index);
  }
  void remove(Id id) {
    const size_t index = indexOf(id);
    held_[index].reset();
    ++generations_[index];
  }
  /// Returns why find() fails, for messages, to follow "the id".
  const char* whyNot(Id id) const {
    if (id == Id{}) return "is zero, which is invalid";
    if (static_cast<uint64_t>(id) >> 32 != owner_) return "belongs to another scene";
    return "belongs to a removed object";
  }
  /// Returns nullptr if there is no object with this id.
  T* find(Id id) const {
    const size_t index = indexOf(id);
    return index < held_.size() && idOf(index) == id ? held_[index].get() : nullptr;
  }
  Id idOf(size_t index) const {
    return static_cast<Id>(uint64_t{owner_} << 32 | generations_[index] << 16 | (index + 1));
  }

  // By slot; nullptr if the slot is empty.
  size_t size() const { return held_.size(); }
  T* operator[](size_t index) const { return held_[index].get(); }
  auto begin() const { return held_.begin(); }
  auto end() const { return held_.end(); }

 private:
  static size_t indexOf(Id id) { return ((static_cast<uint64_t>(id) & 0xffffu) - 1) & 0xffffu; }
  // A slot whose count has reached its maximum is not used again.
  size_t freeIndex() const {
    for (size_t index = 0; index < held_.size(); ++index)
      if (held_[index] == nullptr && generations_[index] < 0xffff) return index;
    return held_.size() < kMost ? held_.size() : kMost;
  }

  uint32_t owner_;
  std::vector<std::unique_ptr<T>> held_;
  std::vector<uint32_t> generations_;
};

}  // namespace detail
}  // namespace pelage
