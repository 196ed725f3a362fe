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
constexpr uint32_t kMaxSubSteps = 16;    // half the step is 32, the most there are
constexpr uint32_t kProbedSubSteps = 4;  // of the sensitivity
constexpr float kPush = 1e-5f;           // m/s2: 20 units in the last place of gravity

struct Samples {
  std::vector<Float3> positions;
  double secondsPerFrame = 0;
};

// \param push  added to the acceleration downwards [m/s2]
Result<Samples> sample(const ShotInputs& inputs, const Shot& shot, double framesPerSecond,
                       uint32_t subSteps, float push, const DeviceMaker& makeDevice) {
  auto scene = ShotScene::create(inputs, shot, framesPerSecond, subSteps);
  if (!scene) return scene.error();
  scene->accelerate({0, -push, 0});
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
                             const std::vector<Float3>& halved, const ErrorBound& bound) {
  std::vector<double> errors(positions.size());
  double sum = 0;
  size_t within = 0;
  for (size_t i = 0; i < errors.size(); ++i) {
    const Float3 &a = positions[i], &b = halved[i];
    errors[i] = std::hypot(static_cast<double>(a.x) - static_cast<double>(b.x),
                           static_cast<double>(a.y) - static_cast<double>(b.y),
                           static_cast<double>(a.z) - static_cast<double>(b.z));
    if (!std::isfinite(errors[i]))
      return Error{ErrorCode::kInvalidArgument,
                   fmt::format("vertex {} of the sample frames is not finite", i)};
    sum += errors[i];
    within += errors[i] <= bound.length ? 1 : 0;
  }
  SubStepError error;
  if (errors.empty()) return error;
  const auto count = static_cast<double>(errors.size());
  const auto rank = static_cast<size_t>(bound.share * (count - 1));
  std::nth_element(errors.begin(), errors.begin() + static_cast<ptrdiff_t>(rank), errors.end());
  error.error = errors[rank];
  error.mean = sum / count;
  error.largest = *std::max_element(errors.begin() + static_cast<ptrdiff_t>(rank), errors.end());
  error.within = static_cast<double>(within) / count;
  return error;
}

std::string textOfShare(double share) {
  return fmt::format("{:.4g} % of the vertices", 100 * share);
}

namespace {

// The bound is not reached.
Error unreached(const SubStepChoice& choice, const Shot& shot) {
  std::string errors;
  for (const SubStepError& one : choice.tried)
    errors += fmt::format("{}{:.3g} mm with {}", errors.empty() ? "" : ", ", 1e3 * one.error,
                          one.subSteps);
  const SubStepError& best =
      *std::max_element(choice.tried.begin(), choice.tried.end(),
                        [](const auto& a, const auto& b) { return a.within < b.within; });
  std::string why;
  if (choice.sensitivity && *choice.sensitivity > choice.bound.length)
    why = fmt::format(
        " More were not tried: 1e-5 m/s2 more of gravity alone moves as many by {:.3g} mm, since "
        "the hair's contacts multiply any difference.",
        1e3 * *choice.sensitivity);
  return {ErrorCode::kInvalidArgument,
          fmt::format("shot '{}': {} are not kept within {:.3g} mm: it is {} sub-steps.{} {} are "
                      "within it with {}: ask for a smaller \"errorShare\" or a larger bound, or "
                      "give \"subSteps\"",
                      shot.name, textOfShare(choice.bound.share), 1e3 * choice.bound.length, errors,
                      why, textOfShare(best.within), best.subSteps)};
}

}  // namespace

Result<SubStepChoice> chooseSubSteps(const ShotInputs& inputs, const Shot& shot,
                                     double framesPerSecond, const DeviceMaker& makeDevice) {
  SubStepChoice choice;
  choice.bound = {*shot.errorBound, shot.errorShare};
  const auto sampled = [&](uint32_t subSteps, float push) {
    return sample(inputs, shot, framesPerSecond, subSteps, push, makeDevice);
  };
  const auto compared = [&](const Samples& one, const Samples& other) -> Result<SubStepError> {
    auto error = compare(one.positions, other.positions, choice.bound);
    if (error) return error;
    return Error{error.error().code,
                 fmt::format("shot '{}': {}", shot.name, error.error().message)};
  };
  auto samples = sampled(1, 0);
  if (!samples) return samples.error();
  for (uint32_t subSteps = 1; subSteps <= kMaxSubSteps; subSteps *= 2) {
    if (subSteps == kProbedSubSteps) {
      const auto pushed = sampled(subSteps, kPush);
      if (!pushed) return pushed.error();
      const auto error = compared(*samples, *pushed);
      if (!error) return error.error();
      choice.sensitivity = error->error;
      if (error->error > choice.bound.length) return unreached(choice, shot);
    }
    auto halved = sampled(2 * subSteps, 0);
    if (!halved) return halved.error();
    auto error = compared(*samples, *halved);
    if (!error) return error.error();
    error->subSteps = subSteps;
    error->secondsPerFrame = samples->secondsPerFrame;
    error->secondsPerFrameHalved = halved->secondsPerFrame;
    choice.tried.push_back(*error);
    if (error->error <= choice.bound.length) return choice;
    samples = std::move(halved);
  }
  return unreached(choice, shot);
}

json toJson(const SubStepChoice& choice) {
  json tried = json::array();
  for (const SubStepError& one : choice.tried)
    tried.push_back({{"subSteps", one.subSteps},
                     {"error", one.error},
                     {"mean", one.mean},
                     {"largest", one.largest},
                     {"within", one.within},
                     {"secondsPerFrame", one.secondsPerFrame},
                     {"secondsPerFrameHalved", one.secondsPerFrameHalved}});
  json made = {
      {"bound", choice.bound.length}, {"share", choice.bound.share}, {"tried", std::move(tried)}};
  if (choice.sensitivity) made["sensitivity"] = *choice.sensitivity;
  return made;
}

Result<SubStepChoice> subStepsOf(const json& from, const std::string& name) {
  try {
    SubStepChoice choice;
    choice.bound = {from.at("bound").get<double>(), from.at("share").get<double>()};
    if (from.contains("sensitivity")) choice.sensitivity = from.at("sensitivity").get<double>();
    for (const json& one : from.at("tried"))
      choice.tried.push_back({one.at("subSteps").get<uint32_t>(), one.at("error").get<double>(),
                              one.at("mean").get<double>(), one.at("largest").get<double>(),
                              one.at("within").get<double>(),
                              one.at("secondsPerFrame").get<double>(),
                              one.at("secondsPerFrameHalved").get<double>()});
    if (!choice.tried.empty()) return choice;
  } catch (const json::exception&) {  // as below
  }
  return Error{ErrorCode::kInvalidFile, name + ": is damaged: remove it"};
}

}  // namespace pelage::bake
