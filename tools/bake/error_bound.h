// Sub-steps that keep the error of a shot within a bound.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "pelage/headless.h"
#include "pelage/result.h"
#include "shot_scene.h"

namespace pelage::bake {

/// How much of a shot is to be within a bound.
struct ErrorBound {
  double length = 0;    ///< [m]
  double share = 0.99;  ///< of the vertices, 0..1
};

/// Error of a number of sub-steps against twice as many.
struct SubStepError {
  uint32_t subSteps = 1;
  double error = 0;                  ///< of the share of the vertices, at most [m]
  double mean = 0;                   ///< of all vertices [m]
  double largest = 0;                ///< of all vertices [m]
  double within = 1;                 ///< share of the vertices within the length
  double secondsPerFrame = 0;        ///< of the sample frames
  double secondsPerFrameHalved = 0;  ///< of those with twice as many
};

struct SubStepChoice {
  ErrorBound bound;
  std::vector<SubStepError> tried;    ///< ascending; the last one is chosen
  std::optional<double> sensitivity;  ///< where it was measured: as SubStepError::error [m]
};

using DeviceMaker = std::function<Result<std::unique_ptr<HeadlessDevice>>()>;

/// Frames of a shot that are sampled, as ranges of simulation steps: three of 8 frames, at the
/// beginning, in the middle and at the end; or all of a shorter shot.
std::vector<std::pair<uint64_t, uint64_t>> sampleSteps(uint64_t preRoll, uint64_t frames);

/// The smallest power of two of sub-steps, at most 16, with which a share of the vertices is within
/// a length of where half the step puts it, in the last frame of each sample. Each sample begins in
/// the bind shape.
///
/// Where 2 sub-steps are not enough, the sensitivity is measured: how far 1e-5 m/s2 more of gravity
/// moves the same share. Hair that hits surfaces can multiply such a difference until it is larger
/// than the length; then so does it with the error of any step, and no more sub-steps are tried.
/// Errors: hair with the classic solver; hair that is not finite; the bound is not reached, with
/// the errors and the share that are; those of the device.
Result<SubStepChoice> chooseSubSteps(const ShotInputs& inputs, const Shot& shot,
                                     double framesPerSecond, const DeviceMaker& makeDevice);

/// Compares two lots of positions, as chooseSubSteps() does. Errors: a number that is not finite.
Result<SubStepError> compare(const std::vector<Float3>& positions,
                             const std::vector<Float3>& halved, const ErrorBound& bound);

/// "99 % of the vertices"
std::string textOfShare(double share);

nlohmann::json toJson(const SubStepChoice& choice);
/// Errors: JSON that toJson() has not made.
Result<SubStepChoice> subStepsOf(const nlohmann::json& from, const std::string& name);

}  // namespace pelage::bake
