#include "stage/play_clock.h"

#include <algorithm>
#include <cmath>

namespace viewer {

double PlayClock::advance(double realSeconds, const pelage::CharacterCycle& cycle) {
  double seconds = 0;
  if (steps) {
    playing = false;
    seconds = kStep * std::min(speed, 1.0);
  } else if (playing) {
    seconds = speed * (fixed ? kStep : std::max(realSeconds, 0.0));
  }
  steps = false;
  seconds = std::min(seconds, kLongest);
  time += seconds;
  const double length = cycle.end - cycle.start;
  if (!(length > 0) || time < cycle.end) return seconds;
  if (loops) {
    time = cycle.start + std::fmod(time - cycle.start, length);
  } else {
    seconds = std::max(seconds - (time - cycle.end), 0.0);
    time = cycle.end;
    playing = false;
  }
  return seconds;
}

}  // namespace viewer
