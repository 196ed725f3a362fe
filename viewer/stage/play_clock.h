// Time on the stage: playing, slow motion, single steps, loops.
#pragma once

#include "pelage/demo/character.h"

namespace viewer {

struct PlayClock {
  static constexpr double kStep = 1.0 / 60;     ///< [s] of a frame of a fixed clock
  static constexpr double kLongest = 4.0 / 60;  ///< [s] that a frame simulates at most

  bool playing = true;
  bool fixed = false;  ///< frames take kStep, however long they really took
  bool loops = true;   ///< the motion starts over at its end; otherwise it stops there
  bool steps = false;  ///< the next frame takes kStep, and then time stands still
  double speed = 1;    ///< factor on time, 0.01..4
  double time = 0;     ///< [s] of the motion

  /// Advances. \param realSeconds since the last frame. \return seconds to simulate: 0..kLongest.
  double advance(double realSeconds, const pelage::CharacterCycle& cycle);
};

}  // namespace viewer
