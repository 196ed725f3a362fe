// Parameters of the strand simulation, with units, ranges and defaults.
#pragma once

#include <array>
#include <cstdint>

#include "pelage/result.h"
#include "pelage/types.h"

namespace pelage {

/// How strands are simulated. Both take the same settings; what only one of them uses says so.
enum class Solver : uint8_t {
  /// An inextensible elastic rod, implicit in time and solved directly: docs/numerics.md.
  kExact,
  /// Position-based: cheaper, softer, without twist.
  kClassic,
};

/// A uniform wind that swells and fades in time.
struct WindSettings {
  /// Mean velocity of the air in world space [m/s]; 0 leaves the wind out of the kernel.
  Float3 velocity = {};
  /// Relative strength of the gusts, 0..1: the speed varies by this share around the mean.
  float gustStrength = 0.5f;
  /// Mean time from one gust to the next [s], > 0.
  float gustPeriod = 2.5f;
  /// How much every strand has gusts of its own, 0..1; at 0 all feel the same ones.
  float strandVariation = 0.5f;
  bool operator==(const WindSettings&) const = default;
};

/// Factors along a strand, at equal distances of arc length from the root to the tip, linear in
/// between; >= 0.
using ParameterCurve = std::array<float, 8>;
inline constexpr ParameterCurve kConstantCurve = {1, 1, 1, 1, 1, 1, 1, 1};
/// The value of a curve; \param share arc length over the strand's length, 0..1.
float valueAt(const ParameterCurve& curve, float share);

/// What parameters are multiplied with along the strands. Changing one uploads the rest
/// shape again.
struct ParameterCurves {
  ParameterCurve stiffness = kConstantCurve;  ///< against bending and twist; of the local shape
  ParameterCurve globalStiffness = kConstantCurve;  ///< of the spring to the bind pose
  ParameterCurve damping = kConstantCurve;          ///< of the air drag
  bool operator==(const ParameterCurves&) const = default;
};

/// Exact: when hair that does not move is left out of the simulation.
struct SleepSettings {
  bool enabled = true;
  /// A strand rests while all of it is slower than this [m/s], >= 0.
  float speed = 5e-4f;
  /// Strands fall asleep when they and their neighbours have rested this long [s], >= 0.
  float time = 0.5f;
  /// They wake when their root's motion would take the tip this far [m], >= 0, when a collider
  /// moves in their reach, and when a setting changes. Wind with gusts and forces keep all awake.
  float wakeDistance = 2e-4f;
  bool operator==(const SleepSettings&) const = default;
};

/// Exact: how hair touches hair, through a grid of the density and the velocity of an object's own
/// strands: docs/hair_contact.md. Off, it needs no pass and no buffer. It keeps hair awake.
struct HairContactSettings {
  /// How strongly hair spreads where it is denser than in the bind pose, 0..1; 0 for not at all.
  float stiffness = 0.0f;
  /// Share of its velocity relative to the hair around it that hair loses in 1/60 s, 0..1.
  float friction = 0.0f;
  /// Of the grid [m], 1e-3..1: a few times the distance between guides. At most 64 nodes fit an
  /// axis; cells are larger where those would not hold the object.
  float cellSize = 0.015f;
  bool operator==(const HairContactSettings&) const = default;
};

/// Everything an artist sets for a hair object. May change every frame. The 0..1 values are defined
/// for steps of 1/60 s and are converted to the real step, so that the frame rate does not change
/// the hair.
struct SimulationSettings {
  /// Changing it puts the hair back into its bind shape.
  Solver solver = Solver::kExact;
  /// Acceleration in world space [m/s2].
  Float3 gravity = {0, -9.81f, 0};
  /// Share of the velocity that is lost in 1/60 s, 0..1. 1 counts as 0.9999: gravity still
  /// moves hair, by at most 18 mm/s.
  float damping = 0.06f;
  /// Exact: length at which a strand that is held at one end starts to hang under its own weight
  /// [m], 0..10. The bending stiffness over the mass a length is 9.81 bendLength^3. Human hair:
  /// 0.05.
  float bendLength = 0.05f;
  /// Exact: stiffness against twist over that against bending, 0.05..10; hair: 0.6 to 1. Below 0.4
  /// every moving strand takes two passes. Below 0.05 strands whip about for ever, however many
  /// passes they take: nothing holds their twist.
  float twistRatio = 0.75f;
  /// Exact: relaxation time of the inner damping of bending and twist (Kelvin-Voigt) [s], 0..1. 0
  /// leaves it out of the kernel.
  float relaxationTime = 0.0f;
  /// Exact: steps that each step of at most 1/60 s is cut into, 1..32. The error falls with its
  /// power of 1.5 to 1.9, up to 8 (docs/numerics.md).
  uint32_t subSteps = 1;
  /// Classic: how strongly each segment keeps its bind angle to the one before, 0..1; 0 leaves
  /// local shape out of the kernel.
  float localStiffness = 0.9f;
  /// Classic: sweeps of the local shape, 1..16. More make the strand stiffer.
  uint32_t localIterations = 2;
  /// Share of the way back to the bind pose that a vertex goes in 1/60 s, 0..1; 0, or a range of 0,
  /// leaves global shape out of the kernel.
  float globalStiffness = 0.0f;
  /// Share of the strand, from the root, on which global stiffness acts, 0..1.
  float globalRange = 0.3f;
  /// Velocity shock propagation: share of the root's rigid motion that the whole strand takes part
  /// in, 0..1. 0 with an infinite threshold leaves it out of the kernel.
  float vspCoefficient = 0.75f;
  /// Acceleration of the root [m/s2], > 0, at which the strand starts to take part in all of the
  /// root's motion; at twice the value it does.
  float vspThreshold = 200.0f;
  WindSettings wind = {};
  /// Classic: how fast the air takes a segment along, across the segment [1/s], >= 0. (The air of
  /// the exact solver acts through the damping.)
  float airDrag = 2.0f;
  /// Classic: solves of the lengths, 1..16. The first one finds the tensions and is stable alone;
  /// the others are Newton steps. Lengths are exact after it in any case. With 2 to 5, long limp
  /// strands may tremble.
  uint32_t lengthIterations = 1;
  /// Classic: speed limit of a vertex relative to its root [m/s], > 0.
  float maxSpeed = 50.0f;
  ParameterCurves curves = {};
  SleepSettings sleep = {};
  HairContactSettings contact = {};
  /// Factor on the offset of follow strands at their tip, >= 0; 1 keeps them parallel to their
  /// guide, less gathers them, more spreads them.
  float tipSeparation = 1.0f;
  bool operator==(const SimulationSettings&) const = default;
};

/// Names the first parameter that is out of its range or not finite.
Result<void> validate(const SimulationSettings& settings);

}  // namespace pelage
