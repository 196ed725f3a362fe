// Undo and redo of settings.
#pragma once

#include <cstddef>
#include <vector>

#include "pelage/settings/scene_settings.h"

namespace viewer {

/// The states that a user went through. Plain value. Buffers and tables of a renderer in the
/// settings (Light::opaque, TransparencySettings) are part of a state: set them in a copy for each
/// draw.
class EditHistory {
 public:
  /// States that are kept; the oldest ones are forgotten.
  static constexpr size_t kMaxStates = 256;

  /// Begins with a state that undo() does not go behind.
  explicit EditHistory(const pelage::SceneSettings& first) : states_{first} {}

  /// Adds a state, for one finished edit. States that were undone are forgotten. One with the
  /// settings of the current state adds nothing.
  void add(const pelage::SceneSettings& settings);
  bool canUndo() const { return current_ > 0; }
  bool canRedo() const { return current_ + 1 < states_.size(); }
  /// Goes to the state before, or stays where there is none.
  void undo() { current_ -= canUndo() ? 1 : 0; }
  /// Goes to the state that was undone last, or stays where there is none.
  void redo() { current_ += canRedo() ? 1 : 0; }
  const pelage::SceneSettings& current() const { return states_[current_]; }

 private:
  std::vector<pelage::SceneSettings> states_;
  size_t current_ = 0;
};

}  // namespace viewer
