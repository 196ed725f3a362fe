#include "error_bound.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <string>
#include <utility>

namespace pelage::bake {
namespace {

using nlohmann::json;

constexpr uint64_t kSamples = 3, kSampleFrames = 8;
constexpr uint32_t kMaxSubSteps = 16;  // half the step is 32, the most there are
constexpr double kShare = 0.99;

struct Samples {
  std::vector<Float3> positions;
  double secondsPerFrame = 0;
};

Result<Samples> sample(const ShotInputs& inputs, const Shot& shot, double framesPerSecond,
                       uint32_t subSteps, const DeviceMaker& makeDevice) {
  auto scene = ShotScene::create(inputs, shot, framesPerSecond, subSteps);
  if (!scene) return scene.error();
  if (!scene->isExact())
    return Error{ErrorCode::kInvalidArgument,
                 fmt::format("shot '{}': an error bound is for the exact solver, whose steps can "
                             "be halved",
                             shot.name)};
  const auto device = makeDevice();
  if (!device) return device.error();
  Samples samples;
  double seconds = 0;
  uint64_t timed = 0;
  for (const auto& [first, last] : sampleSteps(shot.preRoll, shot.frames.count())) {
    scene->reset();
    for (uint64_t step = first; step <= last; ++step) {
      const auto start = std::chrono::steady_clock::now();
      if (auto done = scene->run(step, **device); !done) return done.error();
      // The first ones of a sample make pipelines and buffers.
      if (step <= first + 1 && last > first + 1) continue;
      seconds += std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
      ++timed;
    }
    for (const BakedHair& hair : scene->hairs()) {
      const auto positions = scene->read(hair, **device);
      if (!positions) return positions.error();
      samples.positions.insert(samples.positions.end(), positions->begin(), positions->end());
    }
  }
  samples.secondsPerFrame = seconds / static_cast<double>(timed);
  return samples;
}

}  // namespace

std::vector<std::pair<uint64_t, uint64_t>> sampleSteps(uint64_t preRoll, uint64_t frames) {
  if (frames <= kSamples * kSampleFrames) return {{preRoll, preRoll + frames - 1}};
  std::vector<std::pair<uint64_t, uint64_t>> samples;
  for (uint64_t i = 0; i < kSamples; ++i) {
    const uint64_t first = preRoll + (frames - kSampleFrames) * i / (kSamples - 1);
    samples.emplace_back(first, first + kSampleFrames - 1);
  }
  return samples;
}

Result<SubStepError> compare(const std::vector<Float3>& positions,
                             const std::vector<Float3>& halved) {
  std::vector<double> errors(positions.size());
  for (size_t i = 0; i < errors.size(); ++i) {
    const Float3 &a = positions[i], &b = halved[i];
    errors[i] = std::hypot(static_cast<double>(a.x) - static_cast<double>(b.x),
                           static_cast<double>(a.y) - static_cast<double>(b.y),
                           static_cast<double>(a.z) - static_cast<double>(b.z));
    if (!std::isfinite(errors[i]))
      return Error{ErrorCode::kInvalidArgument,
                   fmt::format("vertex {} of the sample frames is not finite", i)};
  }
  SubStepError error;
  if (errors.empty()) return error;
  const auto rank = static_cast<size_t>(kShare * static_cast<double>(errors.size() - 1));
  std::nth_element(errors.begin(), errors.begin() + static_cast<ptrdiff_t>(rank), errors.end());
  error.error = errors[rank];
  error.largest = *std::max_element(errors.begin() + static_cast<ptrdiff_t>(rank), errors.end());
  return error;
}

Result<SubStepChoice> chooseSubSteps(const ShotInputs& inputs, const Shot& shot,
                                     double framesPerSecond, const DeviceMaker& makeDevice) {
  SubStepChoice choice;
  choice.bound = *shot.errorBound;
  auto samples = sample(inputs, shot, framesPerSecond, 1, makeDevice);
  if (!samples) return samples.error();
  for (uint32_t subSteps = 1; subSteps <= kMaxSubSteps; subSteps *= 2) {
    auto halved = sample(inputs, shot, framesPerSecond, 2 * subSteps, makeDevice);
    if (!halved) return halved.error();
    auto error = compare(samples->positions, halved->positions);
    if (!error)
      return Error{error.error().code,
                   fmt::format("shot '{}': {}", shot.name, error.error().message)};
    error->subSteps = subSteps;
    error->secondsPerFrame = samples->secondsPerFrame;
    error->secondsPerFrameHalved = halved->secondsPerFrame;
    choice.tried.push_back(*error);
    if (error->error <= choice.bound) return choice;
    samples = std::move(halved);
  }
  std::string errors;
  for (const SubStepError& one : choice.tried)
    errors += fmt::format("{}{:.3g} mm with {}", errors.empty() ? "" : ", ", 1e3 * one.error,
                          one.subSteps);
  return Error{ErrorCode::kInvalidArgument,
               fmt::format("shot '{}': no number of sub-steps keeps the error within {:.3g} mm: it "
                           "is {} sub-steps; raise the bound or the frame rate, or give "
                           "\"subSteps\"",
                           shot.name, 1e3 * choice.bound, errors)};
}

json toJson(const SubStepChoice& choice) {
  json tried = json::array();
  for (const SubStepError& one : choice.tried)
    tried.push_back({{"subSteps", one.subSteps},
                     {"error", one.error},
                     {"largest", one.largest},
                     {"secondsPerFrame", one.secondsPerFrame},
                     {"secondsPerFrameHalved", one.secondsPerFrameHalved}});
  return {{"bound", choice.bound}, {"tried", std::move(tried)}};
}

Result<SubStepChoice> subStepsOf(const json& from, const std::string& name) {
  try {
    SubStepChoice choice;
    choice.bound = from.at("bound").get<double>();
    for (const json& one : from.at("tried"))
      choice.tried.push_back({one.at("subSteps").get<uint32_t>(), one.at("error").get<double>(),
                              one.at("largest").get<double>(),
                              one.at("secondsPerFrame").get<double>(),
                              one.at("secondsPerFrameHalved").get<double>()});
    if (!choice.tried.empty()) return choice;
  } catch (const json::exception&) {  // as below
  }
  return Error{ErrorCode::kInvalidFile, name + ": is damaged: remove it"};
}

}  // namespace pelage::bake
