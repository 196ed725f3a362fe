// The table's rows of the simulation.
#include "parameter_row.h"

namespace pelage::settings {
namespace {

constexpr std::string_view kSolvers[] = {"kExact", "kClassic"};

std::vector<Parameter> mainRows() {
  return {
      PELAGE_PARAMETER(SimulationSettings, solver)
          .says("", "kExact, kClassic",
                "An inextensible elastic rod, or points that are cheaper. A change puts the hair "
                "back into its bind shape.")
          .names(kSolvers)
          .pictured(),
      PELAGE_PARAMETER(SimulationSettings, gravity)
          .says("m/s²", "", "Acceleration in world space.")
          .slider(-20, 20)
          .pictured(),
      PELAGE_PARAMETER(SimulationSettings, damping)
          .says("fraction per 1/60 s", "0..1", "Fraction of the velocity that is lost in 1/60 s.")
          .within(0, 1)
          .pictured(),
      PELAGE_PARAMETER(SimulationSettings, bendLength)
          .says("m", "0..10",
                "Length at which a strand that is held at one end starts to hang. Bending "
                "stiffness over mass per length is 9.81 bendLength³.")
          .within(0, 10)
          .logSlider(0, 1)
          .ofSolver("exact")
          .pictured(),
      PELAGE_PARAMETER(SimulationSettings, twistRatio)
          .says("", "0.05..10", "Twist stiffness over bending stiffness.")
          .within(0.05f, 10)
          .log()
          .ofSolver("exact")
          .pictured(),
      PELAGE_PARAMETER(SimulationSettings, relaxationTime)
          .says("s", "0..1", "Inner damping of bending and twist; 0 is off.")
          .within(0, 1)
          .log()
          .ofSolver("exact")
          .pictured(),
      PELAGE_PARAMETER(SimulationSettings, sagCompensation)
          .says("share", "0..1",
                "Share of gravity that the rest shape is bent against: at 1 hair that is not too "
                "limp hangs in its bind shape.")
          .within(0, 1)
          .ofSolver("exact")
          .pictured(),
      PELAGE_PARAMETER(SimulationSettings, subSteps)
          .says("", "1..32",
                "Number of sub-steps per step of at most 1/60 s; the error falls with the power of "
                "1.5 to 1.9 of it, up to 8.")
          .within(1, 32)
          .ofSolver("exact")
          .pictured(),
      PELAGE_PARAMETER(SimulationSettings, maxSubSteps)
          .says(
              "", "1..32",
              "Most sub-steps where colliders move fast against the hair: in a sub-step by more "
              "than two thirds of a capsule's radius, or 1.5 cells of a mesh. At subSteps or less "
              "there are never more than subSteps.")
          .within(1, 32)
          .ofSolver("exact"),
  };
}

std::vector<Parameter> shapeRows() {
  return {
      PELAGE_PARAMETER(SimulationSettings, localStiffness)
          .says("", "0..1",
                "How strongly each segment keeps its bind angle to the previous one; 0 is off.")
          .within(0, 1)
          .ofSolver("classic")
          .pictured(),
      PELAGE_PARAMETER(SimulationSettings, localIterations)
          .says("", "1..16", "Sweeps of the local shape; more make the strand stiffer.")
          .within(1, 16)
          .ofSolver("classic")
          .pictured(),
      PELAGE_PARAMETER(SimulationSettings, globalStiffness)
          .says("fraction per 1/60 s", "0..1",
                "Fraction of its displacement from the bind pose that a vertex loses in 1/60 s; 0 "
                "is off.")
          .within(0, 1)
          .log()
          .pictured(),
      PELAGE_PARAMETER(SimulationSettings, globalRange)
          .says("share of the strand", "0..1",
                "Fraction of the strand, from the root, on which global stiffness acts.")
          .within(0, 1)
          .pictured(),
      PELAGE_PARAMETER(SimulationSettings, vspCoefficient)
          .says("share", "0..1",
                "Velocity shock propagation: fraction of the root's rigid motion that the strand "
                "follows. From 0.75 on gravity, wind and forces fade; at 1 they do not act.")
          .within(0, 1)
          .pictured(),
      PELAGE_PARAMETER(SimulationSettings, vspThreshold)
          .says("m/s²", "> 0",
                "Acceleration of the root from which on the strand follows more of its motion; at "
                "twice the value all of it.")
          .above(0)
          .infinite()
          .logSlider(1, 1000)
          .pictured(),
  };
}

std::vector<Parameter> strandRows() {
  return {
      PELAGE_PARAMETER(SimulationSettings, airDrag)
          .says("1/s", ">= 0", "Rate at which the air drags a segment along, across the segment.")
          .atLeast(0)
          .logSlider(0, 100)
          .ofSolver("classic")
          .pictured(),
      PELAGE_PARAMETER(SimulationSettings, lengthIterations)
          .says("", "1..16",
                "Solves of the lengths: the tensions, then Newton steps. Lengths are exact in any "
                "case.")
          .within(1, 16)
          .ofSolver("classic")
          .pictured(),
      PELAGE_PARAMETER(SimulationSettings, maxSpeed)
          .says("m/s", "> 0", "Speed limit of a vertex relative to its root.")
          .atLeast(1e-6f)
          .logSlider(0.1, 100)
          .ofSolver("classic")
          .pictured(),
      PELAGE_PARAMETER(SimulationSettings, tipSeparation)
          .says("factor", ">= 0",
                "Factor on the offset of follow hairs at their tip: 1 keeps them parallel to their "
                "guide.")
          .atLeast(0)
          .slider(0, 4)
          .pictured(),
  };
}

std::vector<Parameter> windRows() {
  return {
      PELAGE_INNER_PARAMETER(SimulationSettings, wind, WindSettings, velocity)
          .says("m/s", "", "Mean velocity of the air in world space; 0 is off.")
          .slider(-20, 20)
          .pictured(),
      PELAGE_INNER_PARAMETER(SimulationSettings, wind, WindSettings, gustStrength)
          .says("share", "0..1", "The speed varies by this fraction around the mean.")
          .within(0, 1)
          .pictured(),
      PELAGE_INNER_PARAMETER(SimulationSettings, wind, WindSettings, gustPeriod)
          .says("s", "> 0 (1e-3 or more)", "Mean time from one gust to the next.")
          .atLeast(1e-3f)
          .logSlider(0.1, 20),
      PELAGE_INNER_PARAMETER(SimulationSettings, wind, WindSettings, strandVariation)
          .says("share", "0..1", "How much the gusts differ from strand to strand.")
          .within(0, 1)
          .pictured(),
  };
}

std::vector<Parameter> curveRows() {
  return {
      PELAGE_INNER_PARAMETER(SimulationSettings, curves, ParameterCurves, stiffness)
          .says("factor", ">= 0", "Factor on bending, twist and local shape.")
          .atLeast(0)
          .slider(0, 4)
          .pictured(),
      PELAGE_INNER_PARAMETER(SimulationSettings, curves, ParameterCurves, globalStiffness)
          .says("factor", ">= 0", "Factor on the spring to the bind pose.")
          .atLeast(0)
          .slider(0, 4)
          .pictured(),
      PELAGE_INNER_PARAMETER(SimulationSettings, curves, ParameterCurves, damping)
          .says("factor", ">= 0", "Factor on the air drag.")
          .atLeast(0)
          .slider(0, 4)
          .pictured(),
  };
}

std::vector<Parameter> sleepRows() {
  return {
      PELAGE_INNER_PARAMETER(SimulationSettings, sleep, SleepSettings, enabled)
          .says("", "", "Lets hair sleep.")
          .ofSolver("exact"),
      PELAGE_INNER_PARAMETER(SimulationSettings, sleep, SleepSettings, speed)
          .says("m/s", ">= 0",
                "A strand is at rest while all of its vertices are slower than this.")
          .atLeast(0)
          .logSlider(0, 1)
          .ofSolver("exact")
          .pictured(),
      PELAGE_INNER_PARAMETER(SimulationSettings, sleep, SleepSettings, time)
          .says(
              "s", ">= 0",
              "Strands fall asleep when they and their neighbors have been at rest for this long.")
          .atLeast(0)
          .slider(0, 5)
          .ofSolver("exact")
          .pictured(),
      PELAGE_INNER_PARAMETER(SimulationSettings, sleep, SleepSettings, wakeDistance)
          .says("m", ">= 0",
                "Hair wakes when the motion of its root would move the tip by this distance.")
          .atLeast(0)
          .logSlider(0, 0.01)
          .ofSolver("exact"),
  };
}

std::vector<Parameter> contactRows() {
  return {
      PELAGE_INNER_PARAMETER(SimulationSettings, contact, HairContactSettings, stiffness)
          .says("", "0..1",
                "How strongly hair spreads where it is denser than in the bind pose; 0 is off.")
          .within(0, 1)
          .log()
          .ofSolver("exact")
          .pictured(),
      PELAGE_INNER_PARAMETER(SimulationSettings, contact, HairContactSettings, friction)
          .says(
              "fraction per 1/60 s", "0..1",
              "Fraction of its velocity relative to the hair around it that hair loses in 1/60 s.")
          .within(0, 1)
          .ofSolver("exact")
          .pictured(),
      PELAGE_INNER_PARAMETER(SimulationSettings, contact, HairContactSettings, cellSize)
          .says("m", "1e-3..1",
                "Cell size of the grid: a few times the distance between guides. The grid has at "
                "most 64 nodes per axis.")
          .within(1e-3f, 1)
          .logSlider(1e-3f, 0.1)
          .ofSolver("exact")
          .pictured(),
  };
}

}  // namespace

std::vector<Parameter> simulationParameters() {
  std::vector<Parameter> rows = mainRows();
  for (auto* more : {&shapeRows, &strandRows, &windRows, &curveRows, &sleepRows, &contactRows})
    append(rows, (*more)());
  return rows;
}

}  // namespace pelage::settings
