// Names of what is in a scene.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <utility>
#include <vector>

namespace pelage {

/// A hair object of a scene. As for the other ids, zero names nothing, an id is never given twice,
/// and it names nothing in another scene.
enum class HairId : uint64_t { kInvalid = 0 };
/// A mesh collider of a scene.
enum class ColliderId : uint64_t { kInvalid = 0 };
/// A skeleton of a scene.
enum class SkeletonId : uint64_t { kInvalid = 0 };

namespace detail {

/// Another number at every call, from 1 on.
uint32_t nextOwner();

/// Owns things by id. Bits 0..15 of an id are a slot, from 1 on; bits 16..31 count the things that
/// were in the slot before; bits 32..63 are the owner, which no two of these share.
template <class Id, class T>
class Slots {
 public:
  /// Things that there can be at a time.
  static constexpr size_t kMost = 0xffff;

  Slots() : owner_(nextOwner()) {}
  /// What was moved away leaves an owner without ids.
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

  bool isFull() const { return freePlace() == kMost; }
  /// Not when isFull().
  Id add(std::unique_ptr<T> value) {
    const size_t place = freePlace();
    if (place == held_.size()) {
      generations_.push_back(0);
      held_.emplace_back();
    }
    held_[place] = std::move(value);
    return idOf(place);
  }
  void remove(Id id) {
    const size_t place = placeOf(id);
    held_[place].reset();
    ++generations_[place];
  }
  /// Why find() has nothing: for messages, behind "the id".
  const char* whyNot(Id id) const {
    if (id == Id{}) return "is zero, which names nothing";
    if (static_cast<uint64_t>(id) >> 32 != owner_) return "is of another scene";
    return "is of what was removed";
  }
  /// nullptr where there is none of this id.
  T* find(Id id) const {
    const size_t place = placeOf(id);
    return place < held_.size() && idOf(place) == id ? held_[place].get() : nullptr;
  }
  Id idOf(size_t place) const {
    return static_cast<Id>(uint64_t{owner_} << 32 | generations_[place] << 16 | (place + 1));
  }

  // By place; nullptr where there is nothing.
  size_t size() const { return held_.size(); }
  T* operator[](size_t place) const { return held_[place].get(); }
  auto begin() const { return held_.begin(); }
  auto end() const { return held_.end(); }

 private:
  static size_t placeOf(Id id) { return ((static_cast<uint64_t>(id) & 0xffffu) - 1) & 0xffffu; }
  // A place whose count has come to its end is not used again.
  size_t freePlace() const {
    for (size_t place = 0; place < held_.size(); ++place)
      if (held_[place] == nullptr && generations_[place] < 0xffff) return place;
    return held_.size() < kMost ? held_.size() : kMost;
  }

  uint32_t owner_;
  std::vector<std::unique_ptr<T>> held_;
  std::vector<uint32_t> generations_;
};

}  // namespace detail
}  // namespace pelage
