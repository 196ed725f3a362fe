// Parameters of the strand simulation, with units, ranges and defaults.
#pragma once

#include <array>
#include <cstdint>

#include "pelage/export.h"
#include "pelage/result.h"
#include "pelage/types.h"

namespace pelage {

/// How strands are simulated. Both solvers take the same settings; a setting that only one of them
/// uses begins with "Exact:" or "Classic:".
enum class Solver : uint8_t {
  /// An inextensible elastic rod, implicit in time and solved directly: docs/numerics.md.
  kExact,
  /// Position-based: cheaper, softer, without twist.
  kClassic,
};

/// A uniform wind whose speed varies in time.
struct WindSettings {
  /// Mean velocity of the air in world space [m/s]; at 0 the kernel skips the wind.
  Float3 velocity = {};
  /// Relative strength of the gusts, 0..1: the speed varies by this fraction around the mean.
  float gustStrength = 0.5f;
  /// Mean time from one gust to the next [s], > 0.
  float gustPeriod = 2.5f;
  /// How much the gusts differ from strand to strand, 0..1; at 0 all strands feel the same gusts.
  float strandVariation = 0.5f;
  bool operator==(const WindSettings&) const = default;
};

/// Factors along a strand, >= 0, at equal distances of arc length from the root to the tip; linear
/// in between.
using ParameterCurve = std::array<float, 8>;
inline constexpr ParameterCurve kConstantCurve = {1, 1, 1, 1, 1, 1, 1, 1};
/// Returns the value of a curve. \param share arc length over the strand's length, 0..1.
PELAGE_API float valueAt(const ParameterCurve& curve, float share);

/// Factors on parameters along the strands. Changing one uploads the rest shape again.
struct ParameterCurves {
  ParameterCurve stiffness = kConstantCurve;        ///< on bending, twist and local shape
  ParameterCurve globalStiffness = kConstantCurve;  ///< on the spring to the bind pose
  ParameterCurve damping = kConstantCurve;          ///< on the air drag
  bool operator==(const ParameterCurves&) const = default;
};

/// Exact: when hair at rest is left out of the simulation.
struct SleepSettings {
  bool enabled = true;
  /// A strand is at rest while all of its vertices are slower than this [m/s], >= 0.
  float speed = 5e-4f;
  /// Strands fall asleep when they and their neighbors have been at rest for this long [s], >= 0.
  float time = 0.5f;
  /// They wake when the motion of their root would move the tip by this distance [m], >= 0, when a
  /// collider moves within their range, and when a setting changes, but for subSteps. Wind with
  /// gusts and forces keep all strands awake.
  float wakeDistance = 2e-4f;
  bool operator==(const SleepSettings&) const = default;
};

/// Exact: hair-hair contact, through a grid of the density and the velocity of the object's own
/// strands: docs/contact_hair.md. It keeps hair awake. With stiffness and friction at 0 it has no
/// pass and no buffer.
struct HairContactSettings {
  /// How strongly hair spreads where it is denser than in the bind pose, 0..1; 0 turns this off.
  float stiffness = 0.0f;
  /// Fraction of its velocity relative to the surrounding hair that hair loses in 1/60 s, 0..1.
  float friction = 0.0f;
  /// Cell size of the grid [m], 1e-3..1: a few times the distance between guides. The grid has at
  /// most 64 nodes per axis; cells are larger if these would not cover the object.
  float cellSize = 0.015f;
  bool operator==(const HairContactSettings&) const = default;
};

/// Factors on the parameters of one strand, >= 0.
struct StrandFactors {
  float stiffness = 1;        ///< on bending and twist
  float globalStiffness = 1;  ///< on the spring to the bind pose
  float damping = 1;          ///< on the air drag
};

/// The settings of a hair object. They may change every frame. Values of 0..1 are defined for steps
/// of 1/60 s and are converted to the actual step, so hair does not depend on the frame rate.
struct SimulationSettings {
  /// A change puts the hair back into its bind shape.
  Solver solver = Solver::kExact;
  /// Acceleration in world space [m/s2].
  Float3 gravity = {0, -9.81f, 0};
  /// Fraction of the velocity that is lost in 1/60 s, 0..1. 1 counts as 0.9999: gravity still moves
  /// hair, by at most 18 mm/s.
  float damping = 0.06f;
  /// Exact: length at which a strand that is held at one end starts to hang under its own weight
  /// [m], 0..10. The bending stiffness over the mass per length is 9.81 bendLength^3. Human hair:
  /// 0.05.
  float bendLength = 0.05f;
  /// Exact: twist stiffness over bending stiffness, 0.05..10; hair: 0.6 to 1. Below 0.4 every
  /// moving strand takes two passes. Below 0.05 nothing holds the twist of strands, and they never
  /// come to rest, however many passes they take.
  float twistRatio = 0.75f;
  /// Exact: relaxation time of the inner damping of bending and twist (Kelvin-Voigt) [s], 0..1. At
  /// 0 the kernel skips it.
  float relaxationTime = 0.0f;
  /// Exact: share of the sag that the rest shape makes up for, 0..1: it is bent against this share
  /// of gravity. At 0 the bind shape is the rest shape, and hair falls when it is loaded; at 1 hair
  /// hangs in its bind shape from the first frame on. Gravity is that of these settings, in the
  /// axes of the bind pose: as it acts while bones do not rotate it. On a head that bows, hair
  /// hangs from there as it should. Strands that are too limp to hold their bind shape take the
  /// largest share that they can: reachableSagCompensation() (sag_compensation.h) names them. Wind
  /// and forces are not balanced. A change of this, gravity, bendLength, twistRatio, the global
  /// shape or curves.stiffness computes the rest shape again on the host (0.5 us a vertex, more for
  /// limp strands) and uploads it; hair goes on from where it is, and comes to rest for the new
  /// values.
  float sagCompensation = 0.0f;
  /// Exact: number of sub-steps per step of at most 1/60 s, 1..32. The error falls with the power
  /// of 1.5 to 1.9 of this number, up to 8 (docs/numerics.md). The cost is proportional to it.
  uint32_t subSteps = 1;
  /// Exact: most sub-steps of a step in which colliders move fast against the hair, 1..32. Where
  /// a capsule in reach moves by more than two thirds of its radius in a sub-step, or a mesh by
  /// more than 1.5 cells, there are as many as it takes for half a radius or cell each: thin things
  /// would else go through hair. What moves with the middle of the roots, or with a bone of the
  /// hair, counts as still. At subSteps or less there are never more than subSteps.
  uint32_t maxSubSteps = 16;
  /// Classic: how strongly each segment keeps its bind angle to the previous one, 0..1; at 0 the
  /// kernel skips the local shape.
  float localStiffness = 0.9f;
  /// Classic: sweeps of the local shape, 1..16. More sweeps make the strand stiffer.
  uint32_t localIterations = 2;
  /// Fraction of its displacement from the bind pose that a vertex loses in 1/60 s, 0..1. At 0, or
  /// with a range of 0, the kernel skips the global shape.
  float globalStiffness = 0.0f;
  /// Fraction of the strand, from the root, on which global stiffness acts, 0..1.
  float globalRange = 0.3f;
  /// Velocity shock propagation: fraction of the root's rigid motion that the whole strand follows,
  /// 0..1. At 0, with an infinite threshold, the kernel skips it. Up to 0.75 gravity, wind and
  /// forces act in full; from there their share falls linearly to 0 at 1, where hair moves rigidly
  /// with its root in its bind shape. Hair that has another shape returns to the bind shape by its
  /// stiffness, and colliders still push it.
  float vspCoefficient = 0.75f;
  /// Acceleration of the root [m/s2], > 0, from which on the strand follows more of the root's
  /// motion; at twice this value it follows all of it. Gravity, wind and forces act meanwhile.
  float vspThreshold = 200.0f;
  WindSettings wind = {};
  /// Classic: rate at which the air drags a segment along, across the segment [1/s], >= 0. (In the
  /// exact solver the damping acts as air drag.)
  float airDrag = 2.0f;
  /// Classic: solves of the lengths, 1..16. The first solve finds the tensions and is stable alone;
  /// the others are Newton steps. Lengths are exact in any case. With 2 to 5, long limp strands may
  /// tremble.
  uint32_t lengthIterations = 1;
  /// Classic: speed limit of a vertex relative to its root [m/s], > 0.
  float maxSpeed = 50.0f;
  ParameterCurves curves = {};
  SleepSettings sleep = {};
  HairContactSettings contact = {};
  /// Factor on the offset of follow hairs at their tip, >= 0: 1 keeps them parallel to their guide,
  /// less gathers them, more spreads them.
  float tipSeparation = 1.0f;
  bool operator==(const SimulationSettings&) const = default;
};

/// Checks all parameters. Error: names the first parameter that is out of range or not finite.
PELAGE_API Result<void> validate(const SimulationSettings& settings);

}  // namespace pelage
