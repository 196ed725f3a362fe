// The names of what a user chooses from, on the command line and in the panel.
#pragma once

#include <string>
#include <vector>

#include "demo_scene.h"
#include "groom_presets.h"
#include "pelage/demo/character.h"
#include "pelage/simulation_settings.h"
#include "pelage/transparency.h"
#include "pelage/view.h"

namespace viewer {

template <class T>
struct Choice {
  const char* name;
  T value;
};

const std::vector<Choice<sample::GroomPreset>>& grooms();
const std::vector<Choice<pelage::CharacterMotion>>& motions();
const std::vector<Choice<pelage::Solver>>& solvers();
const std::vector<Choice<pelage::Transparency>>& transparencies();
const std::vector<Choice<pelage::HairShadow>>& shadows();
const std::vector<Choice<sample::HeadCollider>>& headColliders();

/// "a, b or c".
template <class T>
std::string namesOf(const std::vector<Choice<T>>& choices) {
  std::string names;
  for (size_t i = 0; i < choices.size(); ++i)
    names += std::string(i == 0 ? "" : i + 1 == choices.size() ? " or " : ", ") + choices[i].name;
  return names;
}

}  // namespace viewer
