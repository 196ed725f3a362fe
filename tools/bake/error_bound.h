// Sub-steps that keep the error of a shot within a bound.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <nlohmann/json.hpp>
#include <vector>

#include "pelage/headless.h"
#include "pelage/result.h"
#include "shot_scene.h"

namespace pelage::bake {

/// Of a number of sub-steps, against twice as many.
struct SubStepError {
  uint32_t subSteps = 1;
  double error = 0;                  ///< of 99 % of the vertices, at most [m]
  double largest = 0;                ///< of all vertices [m]
  double secondsPerFrame = 0;        ///< of the sample frames
  double secondsPerFrameHalved = 0;  ///< of those with twice as many
};

struct SubStepChoice {
  double bound = 0;                 ///< [m]
  std::vector<SubStepError> tried;  ///< ascending; the last one is chosen
};

using DeviceMaker = std::function<Result<std::unique_ptr<HeadlessDevice>>()>;

/// Frames of a shot that are sampled, as ranges of simulation steps: three of 8 frames, at the
/// beginning, in the middle and at the end; or all of a shorter shot.
std::vector<std::pair<uint64_t, uint64_t>> sampleSteps(uint64_t preRoll, uint64_t frames);

/// The smallest power of two of sub-steps, at most 16, with which 99 % of the vertices are within
/// the bound of where half the step puts them, in the last frame of each sample. Each sample begins
/// in the bind shape. Errors: hair with the classic solver; hair that is not finite; the bound is
/// not reached, with the error that is; those of the device.
Result<SubStepChoice> chooseSubSteps(const ShotInputs& inputs, const Shot& shot,
                                     double framesPerSecond, const DeviceMaker& makeDevice);

/// Compares two lots of positions, as chooseSubSteps() does. Errors: a number that is not finite.
Result<SubStepError> compare(const std::vector<Float3>& positions,
                             const std::vector<Float3>& halved);

nlohmann::json toJson(const SubStepChoice& choice);
/// Errors: JSON that toJson() has not made.
Result<SubStepChoice> subStepsOf(const nlohmann::json& from, const std::string& name);

}  // namespace pelage::bake
