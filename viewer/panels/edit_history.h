// Undo and redo of settings.
#pragma once

#include <cstddef>
#include <vector>

#include "pelage/settings/scene_settings.h"

namespace viewer {

/// The states of the settings that a user edits. A plain value. A state includes buffers and tables
/// of a renderer (Light::opaque, TransparencySettings): set these in a copy for each draw.
class EditHistory {
 public:
  /// Maximum number of states; the oldest one is forgotten.
  static constexpr size_t kMaxStates = 256;

  /// Begins with a state that cannot be undone.
  explicit EditHistory(const pelage::SceneSettings& first) : states_{first} {}

  /// Adds the state after an edit, and forgets states that were undone. Settings equal to the
  /// current state's add nothing.
  void add(const pelage::SceneSettings& settings) {
    if (haveSameSettings(settings, current())) return;
    states_.resize(current_ + 1);
    states_.push_back(settings);
    if (states_.size() > kMaxStates) states_.erase(states_.begin());
    current_ = states_.size() - 1;
  }
  bool canUndo() const { return current_ > 0; }
  bool canRedo() const { return current_ + 1 < states_.size(); }
  /// Goes to the previous state, if there is one.
  void undo() { current_ -= canUndo() ? 1 : 0; }
  /// Goes to the state that was undone last, if there is one.
  void redo() { current_ += canRedo() ? 1 : 0; }
  const pelage::SceneSettings& current() const { return states_[current_]; }

 private:
  std::vector<pelage::SceneSettings> states_;
  size_t current_ = 0;
};

}  // namespace viewer
