// The rows of the simulation's settings.
#include <cmath>
#include <numbers>

#include "groups.h"

namespace sample {

using pelage::AffineTransform;
using pelage::Float3;
using pelage::ParameterCurve;
using pelage::SimulationSettings;
using pelage::Solver;

namespace {

// Sets a field of the simulation's settings.
template <class T>
auto setting(T SimulationSettings::*field) {
  return [field](Setup& setup, const T& value) { setup.hair.settings.*field = value; };
}

SimulationSettings& settings(Setup& setup) { return setup.hair.settings; }

// The lock some time after it was let go.
Setup falling(uint32_t frames) {
  Setup setup = lockSetup();
  setup.frames = frames;
  return setup;
}

Setup classic(Setup setup) {
  settings(setup).solver = Solver::kClassic;
  return setup;
}

// A lock that hangs.
Setup hanging() {
  Setup setup = lockSetup();
  setup.lock.direction = {0, -1, 0};
  setup.center = {0, -0.09f, 0};
  setup.frames = 200;
  return setup;
}

Setup curly() {
  Setup setup = hanging();
  setup.lock.curlRadius = 0.012f;
  setup.lock.vertices = 48;
  setup.lock.length = 0.2f;
  setup.lock.fan = 0.05f;
  setup.center = {0, -0.11f, 0};
  setup.extent = 0.29f;
  return setup;
}

// The ball is pulled to the right, faster and faster: m/s2.
Setup pulled(float acceleration) {
  constexpr float kTravel = 0.13f;  // m
  Setup setup = hanging();
  const double frames = std::sqrt(2.0 * kTravel / acceleration) * 60;
  setup.frames = static_cast<uint32_t>(frames);
  setup.motion = [acceleration](double seconds) {
    const auto t = static_cast<float>(seconds);
    return pelage::rigidTransform({0, 0, 0, 1}, {0.5f * acceleration * t * t, 0, 0});
  };
  setup.center = {0.07f, -0.08f, 0};
  setup.extent = 0.3f;
  return setup;
}

Setup windy(float speed) {
  Setup setup = hanging();
  settings(setup).wind = {.velocity = {speed, 0, 0}, .gustStrength = 0};
  setup.frames = 190;
  setup.lock.fan = 0.2f;
  setup.center = {0.06f, -0.07f, 0};
  return setup;
}

// Hair that stands up in all directions and falls together.
Setup bushy() {
  Setup setup = hanging();
  setup.lock.fan = 0.75f;
  setup.lock.guides = 120;
  setup.follow.countPerGuide = 4;
  setup.center = {0, -0.08f, 0};
  settings(setup).bendLength = 0.02f;
  return setup;
}

ParameterCurve ramp(float root, float tip) {
  ParameterCurve curve;
  for (size_t i = 0; i < curve.size(); ++i)
    curve[i] = root + (tip - root) * static_cast<float>(i) / static_cast<float>(curve.size() - 1);
  return curve;
}

std::vector<Parameter> mainRows() {
  const auto damped = [](Setup& s) { settings(s).damping = 0; };
  return {
      tuned("SimulationSettings", "solver",
            show(lockSetup(), std::vector{Solver::kExact, Solver::kClassic},
                 setting(&SimulationSettings::solver),
                 "At rest: the rod is bent by its weight; the classic solver's local shape alone "
                 "does not support it.")),
      tuned(
          "SimulationSettings", "gravity",
          show(lockSetup(), std::vector<Float3>{{0, -1, 0}, {0, -9.81f, 0}, {0, 4, 0}},
               setting(&SimulationSettings::gravity), "At rest: weak, as on earth, and upwards.")),
      tuned("SimulationSettings", "damping",
            show(falling(22), std::vector{0.0f, 0.06f, 0.5f}, setting(&SimulationSettings::damping),
                 "0.37 s after the lock was released.")),
      tuned("SimulationSettings", "bendLength",
            show(lockSetup(), std::vector{0.01f, 0.05f, 0.12f},
                 setting(&SimulationSettings::bendLength),
                 "At rest: soft, like human hair, and stiff.")),
      tuned("SimulationSettings", "twistRatio",
            show(with(curly(), [](Setup& s) { settings(s).bendLength = 0.03f; }),
                 std::vector{0.05f, 0.75f, 10.0f}, setting(&SimulationSettings::twistRatio),
                 "Curls at rest: a strand that twists easily is pulled straight by its weight.")),
      tuned("SimulationSettings", "relaxationTime",
            show(with(falling(34), damped), std::vector{0.0f, 0.05f, 0.5f},
                 setting(&SimulationSettings::relaxationTime),
                 "0.57 s after the lock was released, without other damping.")),
      tuned(
          "SimulationSettings", "sagCompensation",
          show(with(lockSetup(), [](Setup& s) { settings(s).bendLength = 0.08f; }),
               std::vector{0.0f, 0.5f, 1.0f}, setting(&SimulationSettings::sagCompensation),
               "At rest, with a bendLength of 0.08: the lock was groomed as it is on the right.")),
      tuned("SimulationSettings", "subSteps",
            show(with(falling(40), damped), std::vector{1u, 4u, 16u},
                 setting(&SimulationSettings::subSteps),
                 "0.67 s after the lock was released, undamped: one step damps the swing.")),
      tuned("SimulationSettings", "maxSubSteps"),
  };
}

std::vector<Parameter> poseRows() {
  return {
      tuned("SimulationSettings", "localStiffness",
            show(classic(curly()), std::vector{0.0f, 0.9f, 1.0f},
                 setting(&SimulationSettings::localStiffness),
                 "Curls at rest: without local shape they hang straight.")),
      tuned("SimulationSettings", "localIterations",
            show(classic(curly()), std::vector{1u, 2u, 12u},
                 setting(&SimulationSettings::localIterations),
                 "Curls at rest: more sweeps keep more of them.")),
      tuned("SimulationSettings", "globalStiffness",
            show(with(lockSetup(), [](Setup& s) { settings(s).globalRange = 1; }),
                 std::vector{0.0f, 0.01f, 0.1f}, setting(&SimulationSettings::globalStiffness),
                 "At rest, with a globalRange of 1: the bind pose stands out to the right.")),
      tuned("SimulationSettings", "globalRange",
            show(with(lockSetup(), [](Setup& s) { settings(s).globalStiffness = 0.2f; }),
                 std::vector{0.3f, 0.6f, 1.0f}, setting(&SimulationSettings::globalRange),
                 "At rest, with a globalStiffness of 0.2.")),
      tuned("SimulationSettings", "vspCoefficient",
            show(pulled(12), std::vector{0.0f, 0.75f, 1.0f},
                 setting(&SimulationSettings::vspCoefficient),
                 "The ball is pulled to the right at 12 m/s².")),
      tuned("SimulationSettings", "vspThreshold",
            show(with(pulled(12), [](Setup& s) { settings(s).vspCoefficient = 0; }),
                 std::vector{5.0f, 9.0f, 200.0f}, setting(&SimulationSettings::vspThreshold),
                 "The same pull at 12 m/s² with a coefficient of 0: more than twice the threshold, "
                 "between, and below it.")),
  };
}

std::vector<Parameter> motionRows() {
  return {
      {PELAGE_FIELD(SimulationSettings, wind), "", "see WindSettings", "A wind with gusts.", {}},
      tuned("SimulationSettings", "airDrag",
            show(classic(windy(3)), std::vector{0.2f, 2.0f, 10.0f},
                 setting(&SimulationSettings::airDrag), "In a wind of 3 m/s from the left.")),
      tuned("SimulationSettings", "lengthIterations",
            show(with(classic(pulled(60)),
                      [](Setup& s) {
                        settings(s).vspCoefficient = 0;
                        settings(s).localStiffness = 0;
                      }),
                 std::vector{1u, 4u, 16u}, setting(&SimulationSettings::lengthIterations),
                 "The ball is pulled to the right at 60 m/s².")),
      tuned("SimulationSettings", "maxSpeed",
            show(classic(falling(20)), std::vector{0.2f, 0.6f, 50.0f},
                 setting(&SimulationSettings::maxSpeed), "0.33 s after the lock was released.")),
      {PELAGE_FIELD(SimulationSettings, curves),
       "",
       "see ParameterCurves",
       "Factors along the strands.",
       {}},
      {PELAGE_FIELD(SimulationSettings, sleep),
       "",
       "see SleepSettings",
       "When hair at rest is left out of the simulation.",
       {},
       "exact"},
      {PELAGE_FIELD(SimulationSettings, contact),
       "",
       "see HairContactSettings",
       "Hair-hair contact.",
       {},
       "exact"},
      tuned("SimulationSettings", "tipSeparation",
            show(with(lockSetup(),
                      [](Setup& s) {
                        s.lock.guides = 5;
                        s.follow = {.countPerGuide = 40, .maxRadius = 0.008f};
                        settings(s).bendLength = 0.1f;
                        s.extent = 0.2f;
                        s.center = {0.085f, -0.03f, 0};
                      }),
                 std::vector{0.0f, 1.0f, 3.0f}, setting(&SimulationSettings::tipSeparation),
                 "Five guides with 40 follow hairs each: gathered, parallel, spread.")),
  };
}

std::vector<Parameter> windRows() {
  return {
      tuned("WindSettings", "velocity",
            show(
                windy(0), std::vector<Float3>{{0, 0, 0}, {1.5f, 0, 0}, {5, 0, 0}},
                [](Setup& s, const Float3& v) { settings(s).wind.velocity = v; },
                "A steady wind from the left.")),
      tuned("WindSettings", "gustStrength",
            show(
                windy(2.5f), std::vector{0.0f, 0.5f, 1.0f},
                [](Setup& s, float v) { settings(s).wind.gustStrength = v; },
                "The same moment of a wind of 2.5 m/s.")),
      tuned("WindSettings", "gustPeriod"),
      tuned(
          "WindSettings", "strandVariation",
          show(
              with(windy(2.5f), [](Setup& s) { settings(s).wind.gustStrength = 1; }),
              std::vector{0.0f, 0.5f, 1.0f},
              [](Setup& s, float v) { settings(s).wind.strandVariation = v; }, "The same moment.")),
  };
}

std::vector<Parameter> curveRows() {
  const std::vector<ParameterCurve> curves = {ramp(4, 0), ramp(1, 1), ramp(0, 4)};
  return {
      tuned("ParameterCurves", "stiffness",
            show(
                lockSetup(), curves,
                [](Setup& s, const ParameterCurve& v) { settings(s).curves.stiffness = v; },
                "At rest.")),
      tuned("ParameterCurves", "globalStiffness",
            show(
                with(lockSetup(),
                     [](Setup& s) {
                       settings(s).globalStiffness = 0.03f;
                       settings(s).globalRange = 1;
                       settings(s).bendLength = 0.02f;
                     }),
                curves,
                [](Setup& s, const ParameterCurve& v) { settings(s).curves.globalStiffness = v; },
                "At rest, with a globalStiffness of 0.03 on the whole strand.")),
      tuned("ParameterCurves", "damping",
            show(
                with(falling(26),
                     [](Setup& s) {
                       settings(s).damping = 0.2f;
                       settings(s).bendLength = 0.02f;
                     }),
                curves, [](Setup& s, const ParameterCurve& v) { settings(s).curves.damping = v; },
                "0.43 s after the lock was released.")),
  };
}

std::vector<Parameter> sleepRows() {
  return {
      tuned("SleepSettings", "enabled"),
      tuned("SleepSettings", "speed",
            show(
                with(falling(150),
                     [](Setup& s) {
                       settings(s).damping = 0.4f;
                       settings(s).sleep.time = 0.1f;
                     }),
                std::vector{5e-4f, 0.25f, 1.0f},
                [](Setup& s, float v) { settings(s).sleep.speed = v; },
                "2.5 s after the lock was released, with a time of 0.1 s: too high a speed lets it "
                "sleep while it moves.")),
      tuned(
          "SleepSettings", "time",
          show(
              with(falling(150),
                   [](Setup& s) {
                     settings(s).damping = 0.4f;
                     settings(s).sleep.speed = 1;
                   }),
              std::vector{0.1f, 0.25f, 0.5f}, [](Setup& s, float v) { settings(s).sleep.time = v; },
              "The same with a speed of 1 m/s, much too high.")),
      tuned("SleepSettings", "wakeDistance"),
  };
}

std::vector<Parameter> contactRows() {
  return {
      tuned("HairContactSettings", "stiffness",
            show(
                bushy(), std::vector{0.0f, 0.002f, 1.0f},
                [](Setup& s, float v) { settings(s).contact.stiffness = v; },
                "A wide brush in its bind pose, at rest: contact keeps its volume.")),
      tuned("HairContactSettings", "friction",
            show(
                with(bushy(),
                     [](Setup& s) {
                       settings(s).damping = 0.01f;
                       s.lock.variation = 0.6f;
                       s.frames = 48;
                     }),
                std::vector{0.0f, 0.1f, 0.8f},
                [](Setup& s, float v) { settings(s).contact.friction = v; },
                "0.8 s after hair of different lengths was released.")),
      tuned("HairContactSettings", "cellSize",
            show(
                with(bushy(), [](Setup& s) { settings(s).contact.stiffness = 1; }),
                std::vector{0.005f, 0.015f, 0.06f},
                [](Setup& s, float v) { settings(s).contact.cellSize = v; },
                "At rest with a stiffness of 1: a coarse grid evens the hair out over its cells.")),
  };
}

}  // namespace

std::vector<ParameterGroup> simulationGroups() {
  const std::string header = "pelage/simulation_settings.h";
  return {
      {"SimulationSettings", header,
       "HairObject::settings; all may change in every frame. [simulation.md](simulation.md)",
       joined(mainRows(), poseRows(), motionRows())},
      {"WindSettings", header, "SimulationSettings::wind", windRows()},
      {"ParameterCurves", header,
       "SimulationSettings::curves: eight factors at equal distances from the root to the tip.",
       curveRows()},
      {"SleepSettings", header, "SimulationSettings::sleep", sleepRows()},
      {"HairContactSettings", header,
       "SimulationSettings::contact. [contact_hair.md](contact_hair.md)", contactRows()},
  };
}

}  // namespace sample
