#include "edit_history.h"

namespace viewer {

void EditHistory::add(const pelage::SceneSettings& settings) {
  if (haveSameSettings(settings, current())) return;
  states_.resize(current_ + 1);
  states_.push_back(settings);
  if (states_.size() > kMaxStates) states_.erase(states_.begin());
  current_ = states_.size() - 1;
}

}  // namespace viewer
