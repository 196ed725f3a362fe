// Names of what is in a scene.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <utility>
#include <vector>

namespace pelage {

/// A hair object of a scene. Like the other ids: what was removed leaves one that names nothing,
/// whatever is added later.
enum class HairId : uint32_t { kInvalid = 0xffffffffu };
/// A mesh collider of a scene.
enum class ColliderId : uint32_t { kInvalid = 0xffffffffu };
/// A skeleton of a scene.
enum class SkeletonId : uint32_t { kInvalid = 0xffffffffu };

namespace detail {

/// Owns things by id. The lower 16 bits of an id are a place; the upper ones count the things that
/// were there before, so that places are used again and ids are not.
template <class Id, class T>
class Slots {
 public:
  /// Things that there can be at a time.
  static constexpr size_t kMost = 0xffff;

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
  /// nullptr where there is none of this id.
  T* find(Id id) const {
    const size_t place = placeOf(id);
    return place < held_.size() && idOf(place) == id ? held_[place].get() : nullptr;
  }
  Id idOf(size_t place) const {
    return static_cast<Id>(generations_[place] << 16 | static_cast<uint32_t>(place));
  }

  // By place; nullptr where there is nothing.
  size_t size() const { return held_.size(); }
  T* operator[](size_t place) const { return held_[place].get(); }
  auto begin() const { return held_.begin(); }
  auto end() const { return held_.end(); }

 private:
  static size_t placeOf(Id id) { return static_cast<uint32_t>(id) & 0xffffu; }
  // A place whose count has come to its end is not used again.
  size_t freePlace() const {
    for (size_t place = 0; place < held_.size(); ++place)
      if (held_[place] == nullptr && generations_[place] < 0xffff) return place;
    return held_.size() < kMost ? held_.size() : kMost;
  }

  std::vector<std::unique_ptr<T>> held_;
  std::vector<uint32_t> generations_;
};

}  // namespace detail
}  // namespace pelage
