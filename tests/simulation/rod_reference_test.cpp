// The exact strand solver against independent references, in single precision as on a GPU. Every
// test prints the figures that it holds the solver to: "[ FIGURE ] what: measured (at most limit)".
#include <gtest/gtest.h>

#include <cstdio>
#include <cstdlib>
#include <functional>
#include <numbers>
#include <string>
#include <string_view>
#include <vector>

#include "../reference/rod/exact_rod.h"
#include "../reference/rod/planar_chain.h"
#include "../reference/rod/rod_fuzz.h"
#include "../reference/rod/static_rod.h"
#include "support/extremes.h"
#include "support/full_stress.h"
#include "support/strand_run.h"

namespace pelage::rod {
namespace {

using std::numbers::pi;
using Motion = std::function<RootPose(double)>;
using Points = std::vector<Vector3d>;

constexpr double kFrame = 1 / 60.0;

// Long tests run in full length in optimised builds; in others they find crashes and NaN.
#ifdef NDEBUG
constexpr int kEnergyFrames = 2000, kFuzzStrands = 3000;
constexpr double kCalmSeconds = 3;
#else
constexpr int kEnergyFrames = 100, kFuzzStrands = 150;
constexpr double kCalmSeconds = 0.1;
#endif

using test::fullStress;

void expectAtMost(const std::string& what, double measured, double limit) {
  std::printf("[ FIGURE ] %s: %.4g (at most %.4g)\n", what.c_str(), measured, limit);
  EXPECT_LE(measured, limit) << what;
}

/// As std::printf() would print it.
template <class... Values>
std::string text(const char* format, Values... values) {
  char result[160];
  std::snprintf(result, sizeof result, format, values...);
  return result;
}

RootPose still(double) { return {}; }

/// Root on a circle of 0.1 m, to 720 degrees/s within 0.3 s, stopped at 1.5 s.
RootPose spun(double time) {
  const double t = std::min(time, 1.5);
  const double angle = t < 0.3 ? 4 * pi * t * t / 0.6 : 4 * pi * (t - 0.15);
  const Quaterniond rotation = axisAngle(Vector3d(0, 1, 0), angle);
  return {rotation, rotate(rotation, Vector3d(0.1, 0, 0))};
}

/// Side to side without turning, as a head that passes over a sphere.
RootPose swayed(double time) {
  return {Quaterniond(), Vector3d(0.1 * std::sin(4 * time), 0, 0.05 * std::sin(3 * time))};
}

double maxStretch(const ExactRod<float>& rod) {
  double largest = 0;
  for (int j = 1; j + 1 < rod.size(); ++j) {
    const double size = length(Vector3d(rod.position(j + 1)) - Vector3d(rod.position(j)));
    test::keepLargest(largest, std::abs(size / rod.rest().lengths[j] - 1));
  }
  return largest;
}

/// Positions of all frames; the strand settles at the motion's start first. Every frame has `parts`
/// steps, with the root where the motion has it at each of them.
template <class Real>
std::vector<Points> trajectory(const RestStrand& rest, const RodSettings& settings,
                               const Motion& motion, int settleFrames, int frames, int parts) {
  ExactRod<Real> rod(rest, motion(0));
  for (int f = 0; f < settleFrames; ++f) rod.step(kFrame, motion(0), settings);
  std::vector<Points> result;
  for (int f = 0; f < frames; ++f) {
    for (int k = 1; k <= parts; ++k) {
      const double time = (f + static_cast<double>(k) / parts) * kFrame;
      rod.step(kFrame / parts, motion(time), settings);
    }
    result.push_back(rod.positions());
  }
  return result;
}

/// Root mean square distance of all vertices in all frames, in percent of the strand's length.
double errorPercent(const std::vector<Points>& a, const std::vector<Points>& b, double size) {
  double sum = 0;
  size_t count = 0;
  for (size_t f = 0; f < a.size(); ++f) {
    for (size_t i = 0; i < a[f].size(); ++i) {
      const Vector3d d = a[f][i] - b[f][i];
      sum += dot(d, d);
      ++count;
    }
  }
  return 100 * std::sqrt(sum / static_cast<double>(count)) / size;
}

RodSettings converged() {
  RodSettings settings;
  settings.maxPasses = 4;
  settings.passTolerance = 0;
  return settings;
}

/// Hair with the sub-steps and the tolerance of the second pass that the runtime has for it.
/// \param bendLength [m]
/// \param damping    of the air in 1/60 s
RodSettings hair(double bendLength, double damping, int subSteps = 1, double twistRatio = 0.75) {
  RodSettings settings;
  const double bend = 9.81 * bendLength * bendLength * bendLength;
  settings.material = {
      .bend = bend, .twist = twistRatio * bend, .airDrag = -60 * std::log(1 - damping)};
  settings.subSteps = subSteps;
  settings.passTolerance =
      RodTuning<float>::passTolerance(kFrame / subSteps, settings.material.airDrag, twistRatio);
  return settings;
}

// ---- the references themselves

TEST(PlanarChain, KeepsItsEnergyWithoutDrag) {
  const RestStrand rest(straightPoints(16, 0.3, Vector3d(std::cos(1.0), -std::sin(1.0), 0)));
  PlanarChain chain(rest, 1e-4, 0, 9.81);
  const double before = chain.energy();
  for (int k = 0; k < 2000; ++k) chain.step(1 / 6000.0);
  expectAtMost("drift of the chain's energy over mgL", std::abs(chain.energy() - before) / 0.8829,
               1e-9);
}

TEST(StaticRod, BendsUnderASmallLoadAsABeamDoes) {
  StaticRod rod;
  rod.length = 0.2;
  rod.bend = rod.twist = 1;
  rod.gravity = Vector3d(0, -0.1, 0);
  rod.curls = [](double) { return Vector3d(); };
  const auto curve = rod.solve();
  ASSERT_TRUE(curve.has_value());
  // Uniformly loaded cantilever: w L^4 / (8 B).
  const double beam = 0.1 * std::pow(0.2, 4) / 8;
  EXPECT_NEAR(-curve->back().y, beam, 1e-5 * beam);
}

// ---- at rest

TEST(ExactRod, StaysInItsRestShapeWithoutGravity) {
  for (const auto& points : {straightPoints(32, 0.3, Vector3d(0.6, -0.8, 0)),
                             helixPoints(32, 0.008, 0.06, 4), helixPoints(128, 0.004, 0.02, 8)}) {
    const RestStrand rest(points);
    RodSettings settings = {.material = {.airDrag = 1}, .gravity = Vector3d()};
    ExactRod<float> rod(rest, {});
    for (int f = 0; f < 600; ++f) rod.step(kFrame, {}, settings);
    double drift = 0;
    for (int i = 0; i < rod.size(); ++i) {
      test::keepLargest(drift, length(Vector3d(rod.position(i)) - rest.positions[i]));
    }
    expectAtMost("drift from the rest shape in 10 s, % of L", 100 * drift / rest.length(), 1e-3);
  }
}

/// A strand of 0.2 m that leaves its root at an angle, straight or curled, with edges whose lengths
/// go up or down by a factor along it.
struct ClampedStrand {
  double angle = 0;  ///< above the horizontal [rad]
  bool curled = false;
  double grading = 1;    ///< length of the last edge over that of the first one
  double tipFactor = 1;  ///< stiffness at the tip over that at the root
};

/// Frenet frame of the curl at its root, turned by the angle: x the tangent, y the normal.
Quaterniond curlFrame(double radius, double rise, const Quaterniond& tilt) {
  const Vector3d tangent = Vector3d(rise, 0, radius) * (1 / std::hypot(radius, rise));
  const Vector3d normal(0, -1, 0);
  const Quaterniond toTangent = rotationBetween(Vector3d(1, 0, 0), tangent);
  const Vector3d y = rotate(toTangent, Vector3d(0, 1, 0));
  const double roll = std::atan2(dot(cross(y, normal), tangent), dot(y, normal));
  return tilt * (axisAngle(tangent, roll) * toTangent);
}

/// Distance of the settled tip from that of the continuous rod, which is clamped at the root, in
/// percent of L.
double clampedTipError(const ClampedStrand& strand, int n) {
  const double size = 0.2, bend = 9.81 * 1e-3, radius = 0.008, rise = 0.03 / (2 * pi);
  const double speed = std::hypot(radius, rise);
  const Quaterniond tilt = axisAngle(Vector3d(0, 0, 1), strand.angle);
  const auto stiffness = [&](double s) { return 1 + (strand.tipFactor - 1) * s / size; };
  StaticRod rod;
  rod.length = size;
  rod.bend = strand.curled ? 0.1 * bend : bend;
  rod.twist = 0.75 * rod.bend;
  rod.stiffness = stiffness;
  rod.clamp = strand.curled ? curlFrame(radius, rise, tilt) : tilt;
  const Vector3d darboux(rise / (speed * speed), 0, radius / (speed * speed));
  rod.curls = [&](double) { return strand.curled ? darboux : Vector3d(); };
  const auto curve = rod.solve(20);
  EXPECT_TRUE(curve.has_value());
  if (!curve) return 1e9;

  std::vector<double> arcs = {0};
  for (int i = 0; i + 1 < n; ++i)
    arcs.push_back(arcs.back() + std::pow(strand.grading, i / (n - 2.0)));
  const double scale = size / arcs.back();
  Points points;
  for (const double arc : arcs) {
    const double rotation = arc * scale / speed;
    const Vector3d curl(rise * rotation, radius * std::cos(rotation) - radius,
                        radius * std::sin(rotation));
    points.push_back(rotate(tilt, strand.curled ? curl : Vector3d(arc * scale, 0, 0)));
  }
  RestStrand rest(points);
  for (int i = 0; i < n; ++i) rest.stiffness[i] = stiffness(arcs[i] * scale);
  RodSettings settings = {.material = {.bend = rod.bend, .twist = rod.twist, .airDrag = 5}};
  ExactRod<float> exact(rest, {});
  for (int f = 0; f < 1200; ++f) exact.step(kFrame, {}, settings);
  return 100 * length(Vector3d(exact.position(n - 1)) - curve->back()) / size;
}

TEST(ExactRod, IsClampedAtItsRoot) {
  for (const double degrees : {0.0, 30.0, 60.0}) {
    for (const double tipFactor : {1.0, 0.25}) {
      const ClampedStrand strand = {.angle = degrees * pi / 180, .tipFactor = tipFactor};
      const double few = clampedTipError(strand, 8), some = clampedTipError(strand, 16),
                   many = clampedTipError(strand, 32);
      const auto figure = [&](const char* which, double value, double limit) {
        expectAtMost(
            text("clamped at %.0f degrees, tip factor %.2f: %s", degrees, tipFactor, which), value,
            limit);
      };
      figure("n = 8, % of L", few, 4);
      figure("n = 32, % of L", many, 0.25);
      figure("4 / (error at n = 16 over 32)", 4 * many / some, 1.2);
    }
  }
}

TEST(ExactRod, IsClampedAtItsRootWithUnevenEdgesAndCurls) {
  for (const double degrees : {0.0, 30.0, 60.0}) {
    for (const double grading : {0.1, 1.0, 10.0}) {
      for (const bool curled : {false, true}) {
        if (!curled && grading == 1) continue;  // above
        const ClampedStrand strand = {
            .angle = degrees * pi / 180, .curled = curled, .grading = grading};
        const double some = clampedTipError(strand, 32), many = clampedTipError(strand, 64);
        const std::string what = text("%s at %.0f degrees, last edge %g of the first",
                                      curled ? "curl" : "straight", degrees, grading);
        // Long edges at the root have most of the error; curls, that chords are shorter than arcs.
        const double limit = grading < 1 ? 2.5 : 0.4;
        std::printf("[ FIGURE ] %s: %.3f %% of L at n = 32\n", what.c_str(), some);
        expectAtMost(what + ", n = 64, % of L", many, limit);
        expectAtMost(what + ", 4 / (error at n = 32 over 64)", 4 * many / some, 1.4);
      }
    }
  }
}

/// Error of a helix that sags under its weight against the continuous rod, in percent of L.
double helixSagError(int n) {
  const double radius = 0.008, pitch = 0.03, rotations = 3, bend = 1e-3, twist = 0.75e-3;
  const double rise = pitch / (2 * pi), speed = std::hypot(radius, rise);
  const double size = 2 * pi * rotations * speed;
  StaticRod continuous;
  continuous.length = size;
  continuous.bend = bend;
  continuous.twist = twist;
  // Frenet frame: x the tangent, y the inward normal, z the binormal.
  const Vector3d tangent = Vector3d(0, -rise, radius) * (1 / speed);
  const Quaterniond toTangent = rotationBetween(Vector3d(1, 0, 0), tangent);
  const Vector3d y = rotate(toTangent, Vector3d(0, 1, 0)), normal(-1, 0, 0);
  const double roll = std::atan2(dot(cross(y, normal), tangent), dot(y, normal));
  continuous.clamp = axisAngle(tangent, roll) * toTangent;
  const Vector3d darboux(-rise / (speed * speed) * -1, 0, radius / (speed * speed));
  continuous.curls = [darboux](double) { return darboux; };
  const auto curve = continuous.solve();
  EXPECT_TRUE(curve.has_value());
  if (!curve) return 1e9;
  RodSettings settings = {.material = {.bend = bend, .twist = twist, .airDrag = 8}};
  ExactRod<float> rod(RestStrand(helixPoints(n, radius, pitch, rotations)), {});
  for (int f = 0; f < 1200; ++f) rod.step(kFrame, {}, settings);
  double sum = 0;
  for (int i = 2; i < n; ++i) {
    const Vector3d d = Vector3d(rod.position(i)) - pointAt(*curve, i / (n - 1.0));
    sum += dot(d, d);
  }
  return 100 * std::sqrt(sum / (n - 2)) / size;
}

TEST(ExactRod, SagsAsAHelicalKirchhoffRodDoesAndConvergesInSecondOrder) {
  const double coarse = helixSagError(32), middle = helixSagError(64), fine = helixSagError(128);
  expectAtMost("helix, rms error, n = 64, % of L", middle, 0.08);
  expectAtMost("helix, 4 / (error at n = 32 over 64)", 4 * middle / coarse, 1.25);
  expectAtMost("helix, 4 / (error at n = 64 over 128)", 4 * fine / middle, 1.25);
}

TEST(ExactRod, SettlesInOneShapeAtEveryFrameRate) {
  double largest = 0, fastest = 0;
  for (const auto& points : {straightPoints(32, 0.25, Vector3d(1, 0, 0)),
                             straightPoints(32, 0.25, Vector3d(0.5, 0.866, 0)),
                             helixPoints(32, 0.008, 0.06, 4), helixPoints(48, 0.02, 0.05, 2)}) {
    const RestStrand rest(points);
    RodSettings settings = {.material = {.airDrag = 5}};
    const auto settled = [&](double rate) {
      ExactRod<float> rod(rest, {});
      for (int f = 0; f < 12 * rate; ++f) rod.step(1 / rate, {}, settings);
      for (int i = 0; rate == 60 && i < rod.size(); ++i) {
        test::keepLargest(fastest, static_cast<double>(length(rod.velocity(i))));
      }
      return rod.positions();
    };
    const Points usual = settled(60);
    for (const double rate : {15.0, 30.0, 120.0, 240.0}) {
      const Points other = settled(rate);
      for (size_t i = 0; i < usual.size(); ++i) {
        test::keepLargest(largest, 100 * length(other[i] - usual[i]) / rest.length());
      }
    }
  }
  expectAtMost("speed of a settled strand at 60 Hz [m/s]", fastest, 1e-4);
  expectAtMost("settled shape at 15 to 240 Hz against 60 Hz, largest, % of L", largest, 0.05);
}

TEST(ExactRod, HangsInACatenaryWhenItsTipIsHeld) {
  const int n = 64;
  const double size = 0.3, span = 0.2, sag = std::sqrt(size * size - span * span) / 2;
  Points points;
  for (int i = 0; i < n; ++i) {
    const double s = static_cast<double>(i) / (n - 1);
    points.emplace_back(span * s, -sag * (1 - std::abs(2 * s - 1)), 0);
  }
  const RestStrand rest(points);
  RodSettings settings = {.material = {.bend = 1e-8, .twist = 1e-8, .airDrag = 4}, .holdTip = true};
  ExactRod<float> rod(rest, {});
  for (int f = 0; f < 1800; ++f) rod.step(kFrame, {}, settings);
  const Points x = rod.positions();
  const double held = length(x.back() - rest.positions.back());
  // y = a cosh(x / a) through vertex 1 and the tip, with the arc length between them.
  const double wide = x.back().x - x[1].x, high = x.back().y - x[1].y;
  const double arc = rest.length() - rest.lengths[0];
  double low = 1e-3, top = 1;
  for (int k = 0; k < 200; ++k) {
    const double a = (low + top) / 2;
    (2 * a * std::sinh(wide / (2 * a)) > std::sqrt(arc * arc - high * high) ? low : top) = a;
  }
  const double a = low, middle = wide / 2 - a * std::atanh(high / arc);
  double error = 0;
  for (int i = 1; i < n; ++i) {
    const double y =
        x[1].y + a * (std::cosh((x[i].x - x[1].x - middle) / a) - std::cosh(middle / a));
    test::keepLargest(error, std::abs(x[i].y - y));
  }
  expectAtMost("catenary, n = 64, largest error, % of L", 100 * error / size, 0.3);
  expectAtMost("held tip, distance [m]", held, 1e-3);
}

TEST(ExactRod, SettlesAtTheSameGlobalShapeAtEveryFrameRate) {
  const RestStrand rest(straightPoints(32, 0.2, Vector3d(1, 0, 0)));
  RodSettings settings = {.material = {.bend = 1e-8, .twist = 1e-8, .airDrag = 5},
                          .globalStiffness = 0.05};
  const auto tip = [&](double rate) {
    ExactRod<float> rod(rest, {});
    for (int f = 0; f < 10 * rate; ++f) rod.step(1 / rate, {}, settings);
    return Vector3d(rod.position(31));
  };
  const Vector3d usual = tip(60);
  double largest = 0;
  for (const double rate : {15.0, 30.0, 240.0}) {
    test::keepLargest(largest, length(tip(rate) - usual));
  }
  expectAtMost("global shape, tip at 15 to 240 Hz against 60 Hz, % of L", 100 * largest / 0.2,
               0.05);
  // The weight of a vertex against its spring: g / k if nothing else held it, and less with the
  // rest.
  EXPECT_LT(usual.y, -0.2 * 9.81 / (0.05 / 0.95 * 3600));
}

// ---- in motion

TEST(ExactRod, SwingsAsARungeKuttaChainDoes) {
  const double angle = -60 * pi / 180;
  const RestStrand rest(straightPoints(32, 0.3, Vector3d(std::cos(angle), std::sin(angle), 0)));
  const double limits[2][3] = {{1, 0.35, 0.12}, {1, 0.35, 0.12}};
  for (int stiff = 0; stiff < 2; ++stiff) {
    RodSettings settings;
    settings.material.bend = settings.material.twist = stiff ? 1e-3 : 0;
    PlanarChain chain(rest, settings.material.bend, 0, 9.81);
    std::vector<Points> reference;
    for (int f = 0; f < 60; ++f) {
      for (int k = 0; k < 100; ++k) chain.step(kFrame / 100);
      reference.push_back(chain.positions());
    }
    for (int k = 0; k < 3; ++k) {
      const auto moved = trajectory<float>(rest, settings, still, 0, 60, 1 << k);
      expectAtMost(text("%s swing of 1 s, %d sub-steps, rms error, %% of L",
                        stiff ? "stiff" : "limp", 1 << k),
                   errorPercent(moved, reference, 0.3), limits[stiff][k]);
    }
  }
}

TEST(ExactRod, FollowsAHeadWithACurlAsItselfInDoubleDoesAtManySubSteps) {
  const RestStrand rest(helixPoints(32, 0.008, 0.06, 4));
  const RodMaterial material = {.bend = 1e-3, .twist = 1e-3, .airDrag = 3};
  RodSettings exact = converged(), settings;
  exact.material = settings.material = material;
  const auto reference = trajectory<double>(rest, exact, shakenHead, 400, 120, 128);
  const double limits[4] = {3, 1.6, 0.7, 0.3};
  for (int k = 0; k < 4; ++k) {
    settings.subSteps = 1 << k;
    const auto moved = trajectory<float>(rest, settings, shakenHead, 400, 120, 1);
    expectAtMost(text("curl with head motion, %d sub-steps, rms error, %% of L", 1 << k),
                 errorPercent(moved, reference, rest.length()), limits[k]);
  }
}

TEST(ExactRod, NeedsOnePassForACurlInAirThatFollowsAHead) {
  const double drag = -60 * std::log(0.96);
  long passes = 0, steps = 0;
  const Points curls[2] = {helixPoints(32, 0.008, 0.06, 4), helixPoints(32, 0.012, 0.12, 4)};
  const double limits[2] = {3.7, 1.4};
  for (int k = 0; k < 2; ++k) {
    const RestStrand rest(curls[k]);
    RodSettings exact = converged(), settings;
    exact.material = settings.material = {.bend = 1e-3, .twist = 0.75e-3, .airDrag = drag};
    settings.passTolerance = RodTuning<float>::passTolerance(kFrame, drag, 0.75);
    const auto reference = trajectory<double>(rest, exact, shakenHead, 400, 120, 64);
    ExactRod<float> rod(rest, shakenHead(0));
    for (int f = 0; f < 400; ++f) rod.step(kFrame, shakenHead(0), settings);
    std::vector<Points> moved;
    for (int f = 1; f <= 120; ++f) {
      rod.step(kFrame, shakenHead(f * kFrame), settings);
      moved.push_back(rod.positions());
    }
    passes += rod.statistics().passes;
    steps += rod.statistics().steps;
    expectAtMost("curl in air with head motion, one pass, rms error, % of L",
                 errorPercent(moved, reference, rest.length()), limits[k]);
  }
  expectAtMost("its mean Newton passes", static_cast<double>(passes) / static_cast<double>(steps),
               1.01);
}

TEST(ExactRod, SpinsAsItselfInDoubleDoesAtManySubSteps) {
  const RestStrand rest(straightPoints(32, 0.3, Vector3d(0.3, -0.9539, 0)));
  RodSettings exact = converged(), settings;
  exact.material = settings.material = {.bend = 1e-3, .twist = 0.75e-3, .airDrag = 2};
  const auto reference = trajectory<double>(rest, exact, spun, 0, 90, 64);
  const double limits[3] = {12, 4, 1.5};
  for (int k = 0; k < 3; ++k) {
    const auto moved = trajectory<float>(rest, settings, spun, 0, 90, 1 << k);
    expectAtMost(text("spin of 720 degrees/s, %d sub-steps, rms error, %% of L", 1 << k),
                 errorPercent(moved, reference, 0.3), limits[k]);
  }
}

TEST(ExactRod, SwingsWithThePeriodOfARungeKuttaChain) {
  const double angle = -85 * pi / 180;
  const RestStrand rest(straightPoints(32, 0.3, Vector3d(std::cos(angle), std::sin(angle), 0)));
  // Mean time between the tip's crossings of the vertical through vertex 1.
  const auto periodOf = [](const std::function<double()>& nextOffset) {
    double before = nextOffset(), first = 0, last = 0;
    int crossings = 0;
    for (int f = 2; f <= 600; ++f) {
      const double offset = nextOffset();
      if (before * offset < 0) {
        last = (f - 1 + before / (before - offset)) * kFrame;
        if (crossings++ == 0) first = last;
      }
      before = offset;
    }
    return 2 * (last - first) / (crossings - 1);
  };
  PlanarChain chain(rest, 0, 0, 9.81);
  const double truth = periodOf([&] {
    for (int k = 0; k < 50; ++k) chain.step(kFrame / 50);
    const Points x = chain.positions();
    return x[31].x - x[1].x;
  });
  RodSettings settings;
  settings.material.bend = settings.material.twist = 1e-9;
  ExactRod<float> rod(rest, {});
  const double period = periodOf([&] {
    rod.step(kFrame, {}, settings);
    return static_cast<double>(rod.position(31).x - rod.position(1).x);
  });
  // 2 pi / (1.2024 sqrt(g / L)): the first zero of the Bessel function J0, over two.
  EXPECT_NEAR(truth, 2 * pi / (1.20241 * std::sqrt(9.81 / (0.3 * 30 / 31))), 0.01 * truth);
  expectAtMost("period of a limp strand, error in %", 100 * std::abs(period / truth - 1), 1);
}

TEST(ExactRod, LosesItsSwingAtTheSameRateAtEveryFrameRate) {
  const RestStrand rest(straightPoints(32, 0.3, Vector3d(1, 0, 0)));
  RodSettings settings = {
      .material = {.bend = 1e-6, .twist = 1e-6, .airDrag = -60 * std::log(0.92)}};
  // Largest angle from the vertical after 1 s, between two turning points.
  const auto amplitude = [&](double rate) {
    ExactRod<float> rod(rest, {});
    double largest = 0;
    for (int f = 1; f <= 1.6 * rate; ++f) {
      rod.step(1 / rate, {}, settings);
      const Vector3d arm = Vector3d(rod.position(31)) - Vector3d(rod.position(1));
      if (f >= rate) test::keepLargest(largest, std::abs(std::atan2(arm.x, -arm.y)));
    }
    return largest * 180 / pi;
  };
  const double usual = amplitude(60);
  for (const double rate : {30.0, 120.0, 240.0}) {
    expectAtMost(text("swing after 1 s at %.0f Hz against %.2f degrees at 60 Hz, %%", rate, usual),
                 100 * std::abs(amplitude(rate) / usual - 1), 10);
  }
}

TEST(ExactRod, DampsBendingAsAKelvinVoigtRodDoes) {
  const double size = 0.1, bend = 1e-2, rate = 960;
  const RestStrand rest(straightPoints(32, size, Vector3d(1, 0, 0)));
  for (const double tau : {0.002, 0.005}) {
    RodSettings settings = {
        .material = {.bend = bend, .twist = 0.75 * bend, .airDrag = 50, .relaxation = tau},
        .gravity = Vector3d(0, -1, 0)};
    ExactRod<double> rod(rest, {});
    for (int f = 0; f < 2 * rate; ++f) rod.step(1 / rate, {}, settings);
    settings.gravity = Vector3d();
    settings.material.airDrag = 0;
    std::vector<double> peaks;
    double before = 0, earlier = 0;
    for (int f = 0; f < 1.2 * rate; ++f) {
      rod.step(1 / rate, {}, settings);
      const double height = std::abs(rod.position(31).y);
      if (before > earlier && before > height) peaks.push_back(before);
      earlier = before;
      before = height;
    }
    ASSERT_GT(peaks.size(), 4u);
    const double ratio = std::log(peaks[0] / peaks[4]) / (4 * pi);
    // First mode of a cantilever, clamped at the root; damping ratio omega tau / 2.
    const double theory = 3.516 * std::sqrt(bend) / (size * size) * tau / 2;
    expectAtMost("Kelvin-Voigt damping ratio, error in %", 100 * std::abs(ratio / theory - 1), 5);
  }
}

TEST(ExactRod, MovesWithItsRootWhenTheRootIsTeleported) {
  const RestStrand rest(straightPoints(32, 0.3, Vector3d(0.3, -0.9539, 0)));
  const auto fastestAfter = [&](double threshold, int subSteps) {
    RodSettings settings = {.material = {.bend = 1e-3, .twist = 0.75e-3, .airDrag = 2},
                            .transportThreshold = threshold,
                            .subSteps = subSteps};
    ExactRod<float> rod(rest, {});
    double fastest = 0;
    for (int f = 1; f <= 200; ++f) {
      const RootPose away = {axisAngle(Vector3d(0, 1, 0), 2.0), Vector3d(1, 0, 0)};
      rod.step(kFrame, f > 30 ? away : RootPose(), settings);
      for (int i = 2; f > 31 && i < 32; ++i) {
        test::keepLargest(fastest, static_cast<double>(length(rod.velocity(i))));
      }
    }
    return fastest;
  };
  const double never = std::numeric_limits<double>::infinity();
  EXPECT_GT(fastestAfter(never, 1), 5);
  expectAtMost("speed after a teleport of 1 m and 115 degrees [m/s]", fastestAfter(200, 1), 0.5);
  expectAtMost("the same with 4 sub-steps [m/s]", fastestAfter(200, 4), 0.5);
}

TEST(ExactRod, SubStepsAStepAsTheCallerWouldWithInterpolatedPoses) {
  const RestStrand rest(helixPoints(24, 0.01, 0.05, 2));
  RodSettings whole, part;
  whole.subSteps = 3;
  ExactRod<float> a(rest, shakenHead(0)), b(rest, shakenHead(0));
  for (int f = 1; f <= 60; ++f) {
    const RootPose from = shakenHead((f - 1) * kFrame), to = shakenHead(f * kFrame);
    a.step(kFrame, to, whole);
    for (int k = 1; k <= 3; ++k) {
      const RootPose pose = k == 3 ? to : interpolatePoses(from, to, k / 3.0, rest.positions[0]);
      b.step(kFrame / 3, pose, part);
    }
  }
  // Not bit by bit: the caller's poses have another rounding.
  for (int i = 0; i < 24; ++i) EXPECT_LT(length(a.position(i) - b.position(i)), 1e-5) << i;
}

TEST(ExactRod, IsAsGoodAsNewAfterAReset) {
  const RestStrand rest(helixPoints(24, 0.01, 0.05, 2));
  const RodSettings settings;
  ExactRod<float> used(rest, {}), fresh(rest, shakenHead(1));
  for (int f = 0; f < 30; ++f) used.step(kFrame, shakenHead(f * kFrame), settings);
  used.reset(shakenHead(1));
  for (int f = 0; f < 30; ++f) {
    used.step(kFrame, shakenHead(1 + f * kFrame), settings);
    fresh.step(kFrame, shakenHead(1 + f * kFrame), settings);
  }
  for (int i = 0; i < 24; ++i) EXPECT_EQ(length(used.position(i) - fresh.position(i)), 0) << i;
}

TEST(ExactRod, OfTwoVerticesFollowsItsRoot) {
  const RestStrand rest(straightPoints(2, 0.05, Vector3d(0, -1, 0)));
  ExactRod<float> rod(rest, shakenHead(0));
  for (int f = 1; f <= 100; ++f) rod.step(kFrame, shakenHead(f * kFrame), {});
  const RootPose pose = shakenHead(100 * kFrame);
  for (int i = 0; i < 2; ++i) {
    EXPECT_LT(length(Vector3d(rod.position(i)) - pose.apply(rest.positions[i])), 1e-7);
  }
}

// ---- what must never happen

TEST(ExactRod, KeepsEverySegmentsLength) {
  double largest = 0;
  for (const int n : {3, 4, 8, 16, 32, 64, 128}) {
    for (const auto& points :
         {straightPoints(n, 0.3, Vector3d(0.3, -0.9539, 0)), helixPoints(n, 0.008, 0.06, 4)}) {
      RodSettings settings = {.material = {.airDrag = 2}};
      ExactRod<float> rod(RestStrand(points), shakenHead(0));
      for (int f = 1; f <= 300; ++f) {
        rod.step(kFrame, shakenHead(f * kFrame), settings);
        test::keepLargest(largest, maxStretch(rod));
      }
    }
  }
  expectAtMost("largest stretch, n = 3 to 128, head motion, %", 100 * largest, 1e-3);
}

TEST(ExactRod, NeverGainsEnergyWithoutDamping) {
  double worst = 0;
  long passes = 0, steps = 0, count = 0;
  for (const int n : {4, 8, 16, 32, 64, 128}) {
    // Three quarters of the time go to the two largest: the ends of the range will do for them.
    const std::vector<double> rates =
        n > 32 && !fullStress() ? std::vector{30., 240.} : std::vector{30., 60., 120., 240.};
    const Points strands[4] = {straightPoints(n, 0.25, Vector3d(1, 0, 0)),
                               helixPoints(n, 0.008, 0.2, 1), helixPoints(n, 0.008, 0.05, 4),
                               helixPoints(n, 0.004, 0.02, 8)};
    for (int curl = 0; curl < 4; ++curl) {
      const RestStrand rest(strands[curl]);
      for (const double bend : {0., 1e-7, 1e-6, 1e-5, 1e-4, 1e-3, 1e-2, 1.}) {
        for (const double rate : rates) {
          ++count;
          RodSettings settings = {.material = {.bend = bend, .twist = 0.75 * bend}};
          if (curl > 0) settings.gravity = Vector3d(9.81, 0, 0);
          ExactRod<float> rod(rest, {});
          const double before = rod.energy(settings), scale = 9.81 * rest.length() * rest.length();
          double most = before;
          for (int f = 0; f < kEnergyFrames; ++f) {
            rod.step(1 / rate, {}, settings);
            if (f % 4 == 3) test::keepLargest(most, rod.energy(settings));
          }
          ASSERT_TRUE(std::isfinite(most));
          test::keepLargest(worst, 100 * (most - before) / scale);
          passes += rod.statistics().passes;
          steps += rod.statistics().steps;
        }
      }
    }
  }
  expectAtMost(text("growth of energy, %ld undamped strands, %% of mgL", count), worst, 1);
  // The start of a whip takes more passes than its course: a short run has a limit of its own.
  const double mostPasses = kEnergyFrames < 2000 ? 1.7 : 1.3;
  expectAtMost("mean Newton passes", static_cast<double>(passes) / static_cast<double>(steps),
               mostPasses);
}

/// Largest speed in the eleventh second after a strand was shaken and turned for 2 s [m/s].
double speedAfterAShake(const RestStrand& rest, const RodSettings& settings) {
  ExactRod<float> rod(rest, {});
  double fastest = 0;
  for (int f = 1; f <= 780; ++f) {
    const double time = f * kFrame;
    const double strength = std::clamp(std::min(time, 2 - time) / 0.3, 0.0, 1.0);
    const Quaterniond rotation =
        axisAngle(Vector3d(0, 1, 0), strength * 0.8 * std::sin(2 * pi * 1.2 * time)) *
        axisAngle(Vector3d(0, 0, 1), strength * 0.5 * std::sin(2 * pi * 1.9 * time));
    const Vector3d shift =
        Vector3d(0.05 * std::sin(9 * time), 0, 0.03 * std::sin(7 * time)) * strength;
    rod.step(kFrame, {rotation, rotate(rotation, Vector3d(0.1, 0, 0)) + shift}, settings);
    for (int i = 2; f > 720 && i < rod.size(); ++i) {
      const auto speed = static_cast<double>(length(rod.velocity(i)));
      fastest = std::isfinite(speed) ? std::max(fastest, speed) : 1e9;
    }
  }
  return fastest;
}

TEST(ExactRod, ComesToRestAfterAShakeHoweverEasilyItTwists) {
  double worst = 0;
  for (const Points& points :
       {straightPoints(32, 0.3, Vector3d(0, -1, 0)), straightPoints(24, 0.25, Vector3d(.8, .6, 0)),
        helixPoints(32, 0.006, 0.04, 5)}) {
    const RestStrand rest(points);
    for (const double bendLength : {0.03, 0.06, 0.1, 0.14, 0.2}) {
      for (const double twistRatio : {0.05, 0.1, 0.25, 0.4, 0.75, 10.0}) {
        for (const double damping : {0.06, 0.2}) {
          for (const int subSteps : {1, 4}) {
            const RodSettings settings = hair(bendLength, damping, subSteps, twistRatio);
            test::keepLargest(worst, speedAfterAShake(rest, settings));
          }
        }
      }
    }
  }
  expectAtMost("speed 10 s after a shake, 360 strands, twist ratio 0.05 to 10 [m/s]", worst, 5e-4);
}

TEST(ExactRod, NeverGainsEnergyWithDragAndTheToleranceThatGoesWithIt) {
  double worst = -1e9;
  long passes = 0, steps = 0;
  for (const double drag : {0.3, 1.0, 3.0}) {
    for (const double bend : {1e-6, 1e-4, 1e-2}) {
      for (const Points& points :
           {straightPoints(24, 0.25, Vector3d(1, 0, 0)),
            straightPoints(64, 0.25, Vector3d(0.3, 0.9539, 0)), helixPoints(32, 0.008, 0.05, 4)}) {
        const RestStrand rest(points);
        RodSettings settings = {
            .material = {.bend = bend, .twist = 0.75 * bend, .airDrag = drag},
            .passTolerance = RodTuning<float>::passTolerance(kFrame, drag, 0.75)};
        ExactRod<float> rod(rest, {});
        const double before = rod.energy(settings), scale = 9.81 * rest.length() * rest.length();
        for (int f = 0; f < kEnergyFrames / 4; ++f) {
          rod.step(kFrame, {}, settings);
          test::keepLargest(worst, 100 * (rod.energy(settings) - before) / scale);
        }
        passes += rod.statistics().passes;
        steps += rod.statistics().steps;
      }
    }
  }
  expectAtMost("growth of energy with drag, % of mgL", worst, 0.05);
  const double mostPasses = kEnergyFrames < 2000 ? 1.7 : 1.3;  // as above
  expectAtMost("mean Newton passes with drag",
               static_cast<double>(passes) / static_cast<double>(steps), mostPasses);
}

TEST(ExactRod, NeverGainsEnergyInTenThousandFrames) {
  const RestStrand rest(straightPoints(32, 0.3, Vector3d(1, 0, 0)));
  RodSettings settings;
  ExactRod<float> rod(rest, {});
  const double before = rod.energy(settings);
  double most = -1e30;
  for (int f = 0; f < 10000; ++f) {
    rod.step(kFrame, {}, settings);
    test::keepLargest(most, rod.energy(settings));
  }
  expectAtMost("growth of energy in 10,000 frames, % of mgL", 100 * (most - before) / 0.8829, 0);
}

TEST(ExactRod, SurvivesEverythingThatAFileOrAnAnimationCanHold) {
  const int strands = kFuzzStrands, frames = 90;
  int broken = 0, stretched = 0;
  double largest = 0;
  for (int seed = 0; seed < strands; ++seed) {
    const FuzzCase test = makeFuzzCase(static_cast<uint32_t>(seed), frames);
    RodSettings settings = test.settings;
    std::vector<RodCollider> colliders = test.colliders;
    if (seed % 5 == 0)
      colliders.push_back(RodCollider::plane(Vector3d(0, -0.1, 0), Vector3d(0, 1, 0), 0.5));
    settings.colliders = colliders;
    const RestStrand rest(test.points);
    ExactRod<float> rod(rest, test.poses[0]);
    double worst = 0;
    bool finite = true;
    for (int f = 0; f < frames && finite; ++f) {
      if (seed % 2 == 0) {
        // They go along, and spin.
        for (RodCollider& collider : colliders) {
          collider.move(test.poses[f + 1].translation - test.poses[f].translation);
          collider.spin = Vector3d(0.2, -0.1, 0.3);
        }
      }
      rod.step(test.steps[f], test.poses[f + 1], settings);
      double extent = 0;
      for (int i = 0; i < rod.size(); ++i) {
        const Vector3d x(rod.position(i));
        finite = finite && isFinite(x) && isFinite(rod.velocity(i));
        for (const double coordinate : {x.x, x.y, x.z})
          test::keepLargest(extent, std::abs(coordinate));
      }
      for (int j = 1; j + 1 < rod.size(); ++j) {
        const double size = length(Vector3d(rod.position(j + 1)) - Vector3d(rod.position(j)));
        // Coordinates of this extent are 2e-7 extent apart at most: a hundredth of this allowance.
        const double allowed = rest.lengths[j] + extent * 2e-5 + 1e-9;
        test::keepLargest(worst, std::abs(size - rest.lengths[j]) / allowed);
      }
    }
    if (!finite) {
      ++broken;
      ADD_FAILURE() << "seed " << seed << " is not finite";
    }
    if (worst > 0.01) ++stretched;
    test::keepLargest(largest, worst);
  }
  expectAtMost("fuzzed strands with a NaN", broken, 0);
  expectAtMost("fuzzed strands stretched by more than 1 %", stretched, 0);
  expectAtMost("largest stretch, %", 100 * largest, 1);
}

// ---- contact

double deepestPenetration(const RodCollider& shape, double bend) {
  RodSettings settings = {.material = {.bend = bend, .twist = 0.75 * bend, .airDrag = 2},
                          .colliders = {&shape, 1}};
  ExactRod<float> rod(RestStrand(straightPoints(32, 0.3, Vector3d(0.3, -0.9539, 0))), swayed(0));
  const ContactShape<double> surface(shape, 0, 1);
  double deepest = 0;
  for (int f = 1; f <= 1200; ++f) {
    rod.step(kFrame, swayed(f * kFrame), settings);
    for (int i = 2; f > 120 && i < 32; ++i) {
      test::keepLargest(deepest, findContact(surface, Vector3d(rod.position(i))).penetration);
    }
  }
  return deepest;
}

TEST(ExactRod, StaysOutOfASphere) {
  const RodCollider sphere = RodCollider::sphere(Vector3d(0.02, -0.2, 0), 0.08);
  expectAtMost("penetration of a sphere, B = 1e-3 [mm]", 1e3 * deepestPenetration(sphere, 1e-3),
               0.05);
  expectAtMost("penetration of a sphere, B = 1e-6 [mm]", 1e3 * deepestPenetration(sphere, 1e-6), 1);
}

TEST(ExactRod, StaysOutOfATaperedCapsule) {
  RodCollider capsule = RodCollider::sphere(Vector3d(-0.08, -0.18, 0), 0.06);
  capsule.tail = capsule.tailBefore = Vector3d(0.12, -0.22, 0.02);
  capsule.tailRadius = 0.09;
  expectAtMost("penetration of a tapered capsule, B = 1e-3 [mm]",
               1e3 * deepestPenetration(capsule, 1e-3), 0.05);
}

TEST(RodContact, FindsTheDistanceToATaperedCapsule) {
  RodCollider capsule = RodCollider::sphere(Vector3d(0, 0, 0), 0.3);
  capsule.tail = Vector3d(1, 0, 0);
  capsule.tailRadius = 0.1;
  const ContactShape<double> shape(capsule, 0, 1);
  for (int k = 0; k < 200; ++k) {
    const Vector3d p(-0.6 + 0.01 * k, 0.35 + 0.1 * std::sin(k), 0.2 * std::cos(3 * k));
    double nearest = 1e9;
    for (int j = 0; j <= 20000; ++j) {
      const double t = j / 20000.0;
      test::keepSmallest(nearest, length(p - Vector3d(t, 0, 0)) - (0.3 - 0.2 * t));
    }
    EXPECT_NEAR(-findContact(shape, p).penetration, nearest, 1e-8) << k;
  }
}

Points linePoints(int n, const Vector3d& from, const Vector3d& to) {
  Points points;
  for (int i = 0; i < n; ++i) points.push_back(from + (to - from) * (i / (n - 1.0)));
  return points;
}

template <class Real>
double deepestOf(const ExactRod<Real>& rod, std::span<const RodCollider> colliders) {
  double deepest = 0;
  for (const RodCollider& collider : colliders) {
    const ContactShape<double> shape(collider, 0, 1);
    for (int i = 2; i < rod.size(); ++i)
      test::keepLargest(deepest, findContact(shape, Vector3d(rod.position(i))).penetration);
  }
  return deepest;
}

/// How a strand came to rest on a collider.
struct Rest {
  double time = 0;         // the last time at which a vertex was faster than 0.5 mm/s [s]
  double late = 0;         // the fastest vertex in the last second [m/s]
  double rise = 0;         // the most that the energy rose in a second, over mgL
  double growth = -1e9;    // the same against the start
  double penetration = 0;  // in the end [m]
  double deepest = 0;      // [m]
  double passes = 0;       // a step
};

Rest comeToRest(const Points& points, RodSettings settings, const RodCollider& collider,
                double seconds) {
  settings.colliders = {&collider, 1};
  const RestStrand rest(points);
  ExactRod<float> rod(rest, {});
  const double scale = 9.81 * rest.length() * rest.length();
  Rest result;
  std::vector<double> energies = {rod.energy(settings)};
  for (int f = 1; f <= seconds * 60; ++f) {
    const Points before = rod.positions();
    rod.step(kFrame, {}, settings);
    const Points after = rod.positions();
    for (size_t i = 0; i < after.size(); ++i) {
      const double speed = length(after[i] - before[i]) / kFrame;
      if (speed > 5e-4) result.time = f * kFrame;
      if (f > (seconds - 1) * 60) test::keepLargest(result.late, speed);
    }
    energies.push_back(rod.energy(settings));
    const auto since = energies.end() - std::min<std::ptrdiff_t>(f + 1, 61);
    result.rise =
        std::max(result.rise, (energies.back() - *std::min_element(since, energies.end())) / scale);
    test::keepLargest(result.growth, (energies.back() - energies.front()) / scale);
    result.penetration = deepestOf(rod, settings.colliders);
    test::keepLargest(result.deepest, result.penetration);
  }
  result.passes =
      static_cast<double>(rod.statistics().passes) / static_cast<double>(rod.statistics().steps);
  return result;
}

RodCollider cylinderAlongZ(double radius, double friction) {
  return RodCollider::capsule(Vector3d(0, 0, -0.3), Vector3d(0, 0, 0.3), radius, friction);
}

TEST(ExactRod, ComesToRestOverACylinder) {
  struct Case {
    const char* name;
    double bendLength, friction, start;
  };
  for (const Case& c : {Case{"default hair, mu 0.3", 0.0467, 0.3, 0.075},
                        {"default hair, mu 0", 0.0467, 0, 0.075},
                        {"bend length 0.01, mu 0.3", 0.01, 0.3, 0.075},
                        {"limp, mu 0.3", 0, 0.3, 0.055}}) {
    for (const int subSteps : {1, 4}) {
      const Points points = linePoints(64, Vector3d(-0.07, c.start, 0), Vector3d(0.43, c.start, 0));
      const Rest rest = comeToRest(points, hair(c.bendLength, 0.06, subSteps),
                                   cylinderAlongZ(0.05, c.friction), 10);
      const std::string what = "over a cylinder, " + std::string(c.name) + ", " +
                               std::to_string(subSteps) + " sub-steps, ";
      expectAtMost(what + "slower than 0.5 mm/s from [s]", rest.time, 6);
      expectAtMost(what + "speed after 10 s [mm/s]", 1e3 * rest.late, 0.1);
      expectAtMost(what + "energy up in a second, % of mgL", 100 * rest.rise, 0.01);
      expectAtMost(what + "penetration at rest [mm]", 1e3 * rest.penetration, 0.05);
      expectAtMost(what + "at worst [mm]", 1e3 * rest.deepest, 0.05);
      expectAtMost(what + "passes", rest.passes, 1.7);
    }
  }
}

// With the penalty of an active set hair flew off at 8 and more sub-steps, at up to 150 m/s.
TEST(ExactRod, StaysCalmOverACylinderAtAnyNumberOfSubSteps) {
  test::Random random(30);
  double fastest = 0, deepest = 0, late = 0;
  for (const int subSteps : {1, 2, 4, 8, 16, 32}) {
    for (const double rate : {60.0, 120.0, 240.0}) {
      const int frames = static_cast<int>((subSteps == 32 ? 1 : 3) * kCalmSeconds / 3 * rate);
      for (int k = 0; k < 3; ++k) {
        const double radius = random.between(0.02, 0.08), size = random.between(0.15, 0.5);
        const RodCollider cylinder = cylinderAlongZ(radius, random.between(0, 0.8));
        const Vector3d start(random.between(-0.3, 0) * size, radius + random.between(0.001, 0.03),
                             0);
        const Vector3d direction(1, random.between(0, 0.3), random.between(-0.2, 0.2));
        const Vector3d end = start + direction * (size / length(direction));
        RodSettings settings =
            hair(random.between(0.005, 0.07), random.between(0.03, 0.1), subSteps);
        settings.colliders = {&cylinder, 1};
        const int count = 16 + static_cast<int>(random.between(0, 49));
        ExactRod<float> rod(RestStrand(linePoints(count, start, end)), {});
        for (int f = 0; f < frames; ++f) {
          const Points before = rod.positions();
          rod.step(1 / rate, {}, settings);
          const Points after = rod.positions();
          for (size_t i = 0; i < after.size(); ++i) {
            const double speed = length(after[i] - before[i]) * rate;
            test::keepLargest(fastest, speed);
            if (f + 1 == frames && subSteps * rate <= 960) test::keepLargest(late, speed);
          }
          test::keepLargest(deepest, deepestOf(rod, settings.colliders));
        }
      }
    }
  }
  expectAtMost("over a cylinder, 1 to 32 sub-steps at 60 to 240 Hz, fastest [m/s]", fastest, 10);
  expectAtMost("over a cylinder, 1 to 32 sub-steps at 60 to 240 Hz, at worst [mm]", 1e3 * deepest,
               0.05);
  if (kCalmSeconds > 1)
    expectAtMost("over a cylinder, up to 960 sub-steps a second, speed after 3 s [m/s]", late, 1);
}

TEST(ExactRod, GainsNoEnergyFromACylinderWithoutFriction) {
  for (const double damping : {0.0, 0.06}) {
    for (const int subSteps : {1, 4}) {
      const Points points = linePoints(64, Vector3d(-0.07, 0.055, 0), Vector3d(0.43, 0.055, 0));
      const Rest rest = comeToRest(points, hair(0, damping, subSteps), cylinderAlongZ(0.05, 0), 10);
      const std::string what = "limp rope, damping " + std::to_string(damping).substr(0, 4) + ", " +
                               std::to_string(subSteps) + " sub-steps, ";
      expectAtMost(what + "energy above the start's, % of mgL", 100 * rest.growth,
                   damping > 0 ? 0 : 1);
      // As for free strands. Without drag it whips on for ever, and the energy of BDF2's velocities
      // goes up and down.
      expectAtMost(what + "energy up in a second, % of mgL", 100 * rest.rise,
                   damping > 0 ? 0.1 : 3);
      expectAtMost(what + "at worst [mm]", 1e3 * rest.deepest, 0.05);
      expectAtMost(what + "passes", rest.passes, 1.7);
    }
  }
}

/// How far down a slope the tip of a limp strand goes that lies across it [m].
/// \param above angle above that of friction [degree]
double slipDownSlope(double mu, double above, int subSteps, double seconds, double bendLength = 0) {
  const double angle = std::atan(mu) + above * pi / 180;
  const Vector3d normal(std::sin(angle), std::cos(angle), 0), down(normal.y, -normal.x, 0);
  const RodCollider slope = RodCollider::plane(Vector3d(), normal, mu);
  RodSettings settings = hair(bendLength, 0, subSteps);
  settings.colliders = {&slope, 1};
  ExactRod<float> rod(RestStrand(linePoints(32, Vector3d(), Vector3d(0, 0, 0.5))), {});
  double farthest = 0;
  const double pull = std::max(0.0, 9.81 * (std::sin(angle) - mu * std::cos(angle)));
  for (int f = 1; f <= std::lround(seconds * 60); ++f) {
    // The root goes along as Coulomb says: where it stays, the strand becomes taut and is pulled
    // up.
    const double time = f * kFrame;
    rod.step(kFrame, {Quaterniond(), down * (0.5 * pull * time * time)}, settings);
    const double displacement = dot(Vector3d(rod.position(31)), down);
    test::keepLargest(farthest, std::abs(displacement));
  }
  return farthest;
}

TEST(ExactRod, SlipsDownASlopeAsCoulombSays) {
  for (const double mu : {0.1, 0.3, 0.6, 1.0}) {
    const double angle = std::atan(mu) + 2 * pi / 180;
    const double coulomb = 0.5 * 9.81 * (std::sin(angle) - mu * std::cos(angle)) * 0.3 * 0.3;
    for (const int subSteps : {1, 4}) {
      const std::string what =
          text("2 degrees too steep for mu %.1f, %d sub-steps, %% off", mu, subSteps);
      const double error = slipDownSlope(mu, 2, subSteps, 0.3) / coulomb - 1;
      expectAtMost(what, 100 * std::abs(error), subSteps == 1 ? 3 : 1.1);
    }
  }
}

TEST(ExactRod, HoldsOnASlopeThatFrictionHolds) {
  for (const double mu : {0.1, 0.3, 0.6, 1.0}) {
    for (const int subSteps : {1, 4}) {
      expectAtMost(text("0.5 degrees short of mu %.1f, %d sub-steps, 10 s [mm]", mu, subSteps),
                   1e3 * slipDownSlope(mu, -0.5, subSteps, 10), 0.01);
    }
  }
}

TEST(ExactRod, IsDraggedAlongByAFloorAsCoulombSays) {
  const double mu = 0.3;
  for (const int subSteps : {1, 4}) {
    RodCollider floor = RodCollider::plane(Vector3d(), Vector3d(0, 1, 0), mu);
    RodSettings settings = hair(0, 0, subSteps);
    ExactRod<float> rod(RestStrand(linePoints(32, Vector3d(), Vector3d(0, 0, 0.5))), {});
    for (int f = 1; f <= 12; ++f) {
      floor.move(Vector3d(2 * kFrame, 0, 0));
      settings.colliders = {&floor, 1};
      rod.step(kFrame, {}, settings);
      if (f % 6 != 0) continue;
      const double time = f * kFrame, coulomb = 0.5 * mu * 9.81 * time * time;
      expectAtMost(text("dragged by a floor for %.1f s, %d sub-steps, %% off", time, subSteps),
                   100 * std::abs(rod.position(31).x / coulomb - 1), 5);
    }
  }
}

/// From the root straight to a cylinder about z, over it and down.
Points overCylinder(int n, const Vector3d& root, double radius, double hanging) {
  const double away = std::hypot(root.x, root.y),
               straight = std::sqrt(away * away - radius * radius);
  const double angle = std::atan2(root.y, root.x) - std::acos(radius / away);
  const Vector3d tangent(radius * std::cos(angle), radius * std::sin(angle), 0);
  const double arc = radius * angle, size = straight + arc + hanging;
  Points points;
  for (int i = 0; i < n; ++i) {
    const double s = size * i / (n - 1), at = angle - (s - straight) / radius;
    points.push_back(s < straight ? root + (tangent - root) * (s / straight)
                     : s < straight + arc
                         ? Vector3d(radius * std::cos(at), radius * std::sin(at), 0)
                         : Vector3d(radius, straight + arc - s, 0));
  }
  return points;
}

TEST(ExactRod, StaysWhereItIsWhenItHangsTautOverACylinder) {
  for (const int subSteps : {1, 4}) {
    const RodCollider cylinder = cylinderAlongZ(0.05, 0.3);
    RodSettings settings = hair(0, 0.06, subSteps);
    settings.colliders = {&cylinder, 1};
    const RestStrand rest(overCylinder(64, Vector3d(-0.08, 0.06, 0), 0.05, 0.3));
    ExactRod<float> rod(rest, {});
    double early = 0, late = 0;
    Points settled;
    for (int f = 1; f <= 3600; ++f) {
      rod.step(kFrame, {}, settings);
      if (f == 60) settled = rod.positions();
      for (int i = 0; i < 64; ++i) {
        const Vector3d x(rod.position(i));
        double& farthest = f > 60 ? late : early;
        test::keepLargest(farthest, length(x - (f > 60 ? settled[i] : rest.positions[i])));
      }
    }
    // The first steps do not know the forces: each lets the strand slip by what it falls in a
    // frame.
    const std::string what = "taut over a cylinder, " + std::to_string(subSteps) + " sub-steps, ";
    expectAtMost(what + "slip in the first second [mm]", 1e3 * early, 3);
    expectAtMost(what + "in the next 59 s [mm]", 1e3 * late, 0.5);
  }
}

TEST(ExactRod, StaysOutOfASphereThatIsThrownAtIt) {
  for (const double speed : {2.0, 5.0}) {
    RodSettings settings = hair(0.0467, 0.06);
    RodCollider sphere = RodCollider::sphere(Vector3d(-0.3, -0.2, 0.01), 0.05, 0.3);
    ExactRod<float> rod(RestStrand(linePoints(32, Vector3d(), Vector3d(0, -0.3, 0))), {});
    double deepest = 0, farthest = 0;
    for (int f = 1; f <= 60; ++f) {
      sphere.move(Vector3d(speed * kFrame, 0, 0));
      settings.colliders = {&sphere, 1};
      rod.step(kFrame, {}, settings);
      test::keepLargest(deepest, deepestOf(rod, settings.colliders));
      for (int i = 0; i < 32; ++i)
        test::keepLargest(farthest, static_cast<double>(rod.position(i).x));
    }
    expectAtMost(text("sphere thrown at %.0f m/s, at worst [mm]", speed), 1e3 * deepest, 0.05);
    EXPECT_GT(farthest, 0.05) << "the sphere has met it";
  }
}

TEST(ExactRod, StaysOnAHeadThatIsShaken) {
  // Along the head, then down.
  Points points;
  for (int i = 0; i < 24; ++i) {
    const double angle = 0.1 + 0.05 * i;
    points.push_back(i < 12 ? Vector3d(std::sin(angle), std::cos(angle), 0) * 0.1002
                            : points.back() + Vector3d(0.001, -0.012, 0));
  }
  for (const double bendLength : {0.01, 0.0467}) {
    for (const int subSteps : {1, 2}) {
      RodSettings settings = hair(bendLength, 0.06, subSteps);
      RodCollider head = RodCollider::sphere(Vector3d(), 0.1, 0.3);
      ExactRod<float> rod(RestStrand(points), {});
      std::vector<double> depths;
      for (int f = 1; f <= 240; ++f) {
        const double time = f * kFrame, angle = 0.5 * std::sin(2 * pi * 1.3 * time);
        const RootPose pose = {axisAngle(Vector3d(0, 1, 0), angle),
                               Vector3d(0.2 * std::sin(2 * pi * 1.9 * time), 0, 0)};
        head.move(pose.translation - head.head);
        head.spin = Vector3d(0, angle - 0.5 * std::sin(2 * pi * 1.3 * (time - kFrame)), 0);
        settings.colliders = {&head, 1};
        rod.step(kFrame, pose, settings);
        const ContactShape<double> shape(head, 0, 1);
        for (int i = 2; i < rod.size(); ++i)
          depths.push_back(findContact(shape, Vector3d(rod.position(i))).penetration);
      }
      EXPECT_TRUE(
          std::none_of(depths.begin(), depths.end(), [](double d) { return std::isnan(d); }));
      std::sort(depths.begin(), depths.end());
      const std::string what =
          text("shaken head, bend length %.4f m, %d sub-steps, ", bendLength, subSteps);
      expectAtMost(what + "99.9 % [mm]", 1e3 * depths[depths.size() * 999 / 1000], 0.5);
      expectAtMost(what + "at worst [mm]", 1e3 * depths.back(), 2);
    }
  }
}

/// A limp strand that hangs in a slack loop between its root and a cylinder about z, goes over it
/// and hangs down to its tip.
struct SlackStrand {
  static constexpr double kRadius = 0.05, kEdge = 0.008;
  ExactRod<float> rod;
  RodSettings settings = hair(0.01, 0.06);
  RootPose root;

  SlackStrand(double loop, double hanging) : rod(RestStrand(points(loop, hanging)), {}) {}
  void step(const RodCollider& cylinder) {
    settings.colliders = {&cylinder, 1};
    rod.step(kFrame, root, settings);
  }
  Vector3d at(int i) const { return Vector3d(rod.position(i)); }

  static Points points(double loop, double hanging) {
    const double gap = 0.04;  // of the loop
    const double half = pi * gap / 2, side = (loop - half) / 2, arc = pi * kRadius;
    const double x = -kRadius - gap;
    Points result;
    for (double s = 0; s < loop + arc + hanging; s += kEdge) {
      const double u = s - side, v = s - loop, w = v - arc;
      if (s < side) {
        result.emplace_back(x, -s, 0);
      } else if (u < half) {
        const double a = pi * u / half;
        result.emplace_back(x + gap / 2 * (1 - std::cos(a)), -side - gap / 2 * std::sin(a), 0);
      } else if (s < loop) {
        result.emplace_back(-kRadius, s - loop, 0);
      } else if (v < arc) {
        result.emplace_back(-kRadius * std::cos(v / kRadius), kRadius * std::sin(v / kRadius), 0);
      } else {
        result.emplace_back(kRadius, -w, 0);
      }
    }
    return result;
  }
};

TEST(ExactRod, SlipsOverACylinderAtTheRatioOfTensionsOfACapstan) {
  for (const double mu : {0.1, 0.3}) {
    // Holds at first. The root goes up: the loop becomes lighter until the strand slips.
    SlackStrand strand(0.4, 0.11 * std::exp(mu * pi));
    const RodCollider cylinder = cylinderAlongZ(SlackStrand::kRadius, mu);
    for (int f = 0; f < 240; ++f) strand.step(cylinder);
    const int tip = strand.rod.size() - 1;
    const double held = strand.at(tip).y;
    for (int f = 0; f < 3600 && strand.at(tip).y > held - 5e-4; ++f) {
      strand.root.translation.y += 0.005 * kFrame;
      strand.step(cylinder);
    }
    // Weights on the two sides of the cylinder, and its angle.
    int lowest = 2;
    while (lowest < tip && strand.at(lowest + 1).y < strand.at(lowest).y) ++lowest;
    int first = lowest;
    while (first < tip && length(strand.at(first)) > SlackStrand::kRadius + 1e-4) ++first;
    int last = tip;
    while (last > first && length(strand.at(last)) > SlackStrand::kRadius + 1e-4) --last;
    // The loop pulls along its last edge with its weight from the lowest point.
    const Vector3d edge = strand.at(first) - strand.at(first - 1);
    const double loop = SlackStrand::kEdge * (first - lowest) * length(edge) / edge.y;
    const double hanging = SlackStrand::kEdge * (tip - last);
    // dT/da = R w cos a + mu (T + R w sin a), with a the direction of the strand, up at 0.
    const Vector3d off = strand.at(last + 1) - strand.at(last);
    const double begin = std::atan2(edge.x, edge.y);
    double end = std::atan2(off.x, off.y);
    if (end < begin) end += 2 * pi;
    double tension = loop;
    const int steps = 10000;
    for (int k = 0; k < steps; ++k) {
      const double a = begin + (end - begin) * (k + 0.5) / steps;
      tension += (end - begin) / steps *
                 (SlackStrand::kRadius * (std::cos(a) + mu * std::sin(a)) + mu * tension);
    }
    const std::string what = text("capstan, mu %.1f, ratio of tensions, %% off", mu);
    // One vertex is 3 to 6 % of the hanging length.
    expectAtMost(what, 100 * std::abs(hanging / tension - 1), 8);
  }
}

TEST(ExactRod, GoesWithASpinningCylinder) {
  // A limp strand lies along the top; its root stays where it is.
  const double radius = 0.1;
  RodCollider cylinder = cylinderAlongZ(radius, 1);
  cylinder.tail.z = cylinder.tailBefore.z = 1;
  RodSettings settings = hair(0, 0.06);
  const Vector3d top(0, radius, 0);
  ExactRod<float> rod(RestStrand(linePoints(48, top, top + Vector3d(0, 0, 0.376))), {});
  double angle = 0;
  for (int f = 1; f <= 180; ++f) {
    cylinder.spin = Vector3d(0, 0, f > 60 ? -0.2 / 120 : 0);
    angle -= cylinder.spin.z;
    settings.colliders = {&cylinder, 1};
    rod.step(kFrame, {}, settings);
  }
  const double rotated = std::atan2(rod.position(47).x, rod.position(47).y);
  expectAtMost("on a cylinder that spins by 0.2 rad, % off", 100 * std::abs(rotated / angle - 1),
               2);
}

}  // namespace
}  // namespace pelage::rod
